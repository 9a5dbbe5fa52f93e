"""Measures of swarms."""

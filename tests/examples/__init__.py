"""Rods, scenes and data that several tests share."""

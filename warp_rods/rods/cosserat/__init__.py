"""Extensible and shearable rods in space."""

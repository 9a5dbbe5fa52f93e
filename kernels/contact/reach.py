"""How far apart rods feel each other: known without Warp, so that a scene can be checked without it."""

REACH = 8.0
"""Pairs farther apart than this many ranges a are left out."""

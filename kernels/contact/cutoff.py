"""The cut-off of the steric potential; this module does not import Warp, so that a scene can be checked without it."""

CUTOFF = 8.0
"""Cut-off distance in units of the range a; pairs that are farther apart do not interact."""

"""Linear theory, fixed shapes, continuation, buckling."""

"""Free rods: active swimmers and passive rods in space."""

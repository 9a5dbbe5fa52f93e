"""warp_rods: geometrically exact Kirchhoff rods at low Reynolds number, in batches, on NVIDIA Warp."""

"""Membranes: surfaces φ(x) = 0, built in, from a formula, a grid or a mesh; at rest or moving."""

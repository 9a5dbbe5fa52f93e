"""Cases that nobody means: scenes, formulas, meshes and stacks with faults of every kind, from numbers as seeds."""

"""Surfaces φ(x) = 0: their fields, and the geometry that follows from φ, ∇φ and ∇∇φ (docs/model.md §5)."""

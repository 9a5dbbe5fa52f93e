"""Equations of extensible and shearable rods (docs/model.md §10)."""

"""Filaments bound to a surface (docs/model.md §3; dissertation, chapter 5)."""

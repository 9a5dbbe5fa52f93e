"""Filaments bound to a surface (model §3; thesis chapter 5)."""

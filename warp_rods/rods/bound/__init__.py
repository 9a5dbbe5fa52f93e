"""Filaments bound to a membrane."""

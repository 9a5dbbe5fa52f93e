"""Scenes: TOML or Python to a checked, frozen description of a run; nothing is built here."""

"""The animation of a run as USD."""

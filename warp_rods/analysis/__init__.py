"""From a trajectory to numbers: every measure is a row of ``registry.MEASURES``."""

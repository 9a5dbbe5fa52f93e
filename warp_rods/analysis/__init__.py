"""From a trajectory to numbers."""

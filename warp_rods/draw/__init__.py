"""From a trajectory to pictures: plots and USD."""

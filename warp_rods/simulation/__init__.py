"""From a scene to a run folder: layout, loop, runner, trajectory."""

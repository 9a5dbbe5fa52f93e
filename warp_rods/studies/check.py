"""The check of a study before it begins, for `warp-rods check`."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

from warp_rods.progress import waiting
from warp_rods.scene.scene import Scene
from warp_rods.simulation.frames import Frames
from warp_rods.studies.plan import Plan
from warp_rods.studies.summaries import FEWEST_IN_QUARTER, frames_in_quarters

__all__ = ["check_study"]


def check_study(path: str | Path) -> tuple[str, list[str]]:
    """What the sweep of the scene in a file is, and warnings; raises SceneError for what is not possible in it."""
    plan = Plan(Scene.load(path))
    plan.check()
    from warp_rods.simulation.loop import Simulation
    from warp_rods.studies.probes import IDLE_SEEDS, probe, seeds_are_idle, warnings_of_corners

    with waiting("trying the measures of the study at its first point"):
        simulation = Simulation(plan.scene_at((0,) * len(plan.axes)), "cpu")
        probe(plan, simulation)
        idle = [IDLE_SEEDS] if seeds_are_idle(plan, simulation) else []
    return f"a study of {plan.size}, for `warp-rods sweep`", [*_warnings(plan), *idle, *warnings_of_corners(plan)]


def _warnings(plan: Plan) -> list[str]:
    """A warning where a measure assumes a settled motion, and there are too few frames to tell."""
    names = [name for name in plan.sweep.measure if any(w.name == name and w.summary.settled for w in plan.wanted)]
    fewest = min(map(_frames, _times(plan)))
    if not names or fewest >= FEWEST_IN_QUARTER:
        return []
    what = f"{', '.join(names)} assume{'s' * (len(names) == 1)} a settled motion"
    advice = f"give time.save_every = time.end/{4 * FEWEST_IN_QUARTER} or less"
    few = f"{fewest} frame{'s' * (fewest != 1)}"
    return [f"{what}, which cannot be told with {few} in a quarter of the run: {advice}"]


def _times(plan: Plan) -> list[np.ndarray]:
    """The times of the frames of points that have the smallest and the largest values of swept times."""
    ends = [
        sorted({int(np.argmin(axis.values)), int(np.argmax(axis.values))}) if axis.key.startswith("time.") else [0]
        for axis in plan.axes
    ]
    return [Frames.of(plan.scene_at(point).time).times for point in itertools.product(*ends)]


def _frames(times: np.ndarray) -> int:
    return min(map(len, frames_in_quarters(times)))

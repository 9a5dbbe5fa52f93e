"""How a study begins: its folder, its store with chunks that make tasks of some seconds, and how it goes on later."""

from __future__ import annotations

import math
import shutil
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.errors import RunFolderError, SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.files import replace_file
from warp_rods.simulation.loop import Simulation
from warp_rods.studies.batches import batch_tables, why_not
from warp_rods.studies.new_store import create
from warp_rods.studies.plan import Plan, columns_of
from warp_rods.studies.points import assumes, measured
from warp_rods.studies.probes import refuse_other_dimensions
from warp_rods.studies.record import Record, bytes_of_a_rod, still
from warp_rods.studies.store import STORE, Store
from warp_rods.studies.summaries import SETTLED
from warp_rods.studies.tasks import SCENE, TRAJECTORIES

__all__ = ["begin"]

SECONDS = 5.0
"""What a task should take."""
TASKS_EACH = 4
"""Tasks for each worker, at least, so that all end at about the same time."""
MOST_TASKS = 20_000
"""Of a level of a study: each costs client, scheduler and disk some milliseconds, and about ten files."""
MOST_RODS, MOST_BYTES = 4096, 1.5e8
"""Rods of a batch, and bytes of its trajectory in memory, at most."""
TRIED, BUDGET = 8, 3.0
"""Points with which times are estimated, and seconds for that."""
FEWEST = 192
"""Rods of a batch, where there are as many: reading frames and measuring takes about as long for fewer."""


def begin(plan: Plan, folder: Path, device: str, workers: int, overwrite: bool) -> tuple[Store, list[str]]:
    """The store of a study in ``folder``, made unless it is there, and lines for the user.

    Its kernels are compiled then. Raises RunFolderError where the folder holds another study, or something else.
    """
    if overwrite:
        _remove(folder)
    if (folder / STORE).exists():
        return _resumed(plan, folder, device), []
    ours = (SCENE, STORE, TRAJECTORIES)  # another part may be making them
    if folder.exists() and any(not file.name.startswith(".") and file.name not in ours for file in folder.iterdir()):
        raise RunFolderError(f"{folder} holds something that is not a study: give another --out")
    return _created(plan, folder, device, workers)


def _remove(folder: Path) -> None:
    """Remove the study in a folder, and nothing else."""
    for name in (STORE, TRAJECTORIES):
        shutil.rmtree(folder / name, ignore_errors=True)


def _resumed(plan: Plan, folder: Path, device: str) -> Store:
    """The store of a study that goes on; raises RunFolderError where it is that of another scene or device."""
    store = Store(folder / STORE)
    attributes = store.attributes
    if attributes.get("scene_hash") != plan.scene.hash():
        before = Scene.load(folder / SCENE) if (folder / SCENE).is_file() else None
        raise RunFolderError(
            f"{folder} holds a study of another scene{_differences(before, plan.scene)}: give another --out, or "
            f"--overwrite to replace it"
        )
    if attributes.get("device") != _kind(device):
        raise RunFolderError(
            f"{folder} was begun on {attributes.get('device')}, whose bits are not those of {_kind(device)}: go on "
            f"with --device {attributes.get('device')}"
        )
    store.clear_leftovers()
    _warm_up(plan, device)
    return store


def _kind(device: str) -> str:
    return "cuda" if device.startswith("cuda") else "cpu"


def _differences(before: Scene | None, now: Scene) -> str:
    """The tables in which two scenes differ, in words."""
    if before is None:
        return ""
    one, other = before.model_dump(), now.model_dump()
    keys = [f"[{key}]" if isinstance(other[key] or one[key], dict) else key for key in one if one[key] != other[key]]
    return f" ({', '.join(keys)} differ{'s' if len(keys) == 1 else ''})"


def _warm_up(plan: Plan, device: str) -> Simulation:
    """A simulation of the first point, with which every kernel is compiled before workers need them."""
    simulation = Simulation(plan.scene_at((0,) * len(plan.axes)), device)
    simulation.warm_up()
    return simulation


def _created(plan: Plan, folder: Path, device: str, workers: int) -> tuple[Store, list[str]]:
    simulation = _warm_up(plan, device)
    found = _probe(plan, simulation)
    reason = why_not(plan.scene, plan.paths, simulation) if plan.sweep.keep == "summary" else "trajectories are kept"
    seconds = _seconds(plan, simulation, device, alone=bool(reason))
    rods = max(simulation.rods, 1)
    together = 0
    if not reason:
        fits = MOST_BYTES / max(bytes_of_a_rod(simulation, plan.needs) * rods, 1.0)
        together = max(1, int(min(MOST_RODS / rods, fits)))
    fewest = math.ceil(FEWEST / rods) if together else 1
    chunk = _chunk(plan, _points_in_a_task(plan, seconds, workers, fewest, together or math.inf))
    folder.mkdir(parents=True, exist_ok=True)
    replace_file(folder / SCENE, plan.scene.to_toml().encode(), durable=True)
    attributes = {
        "title": plan.scene.title, "warp_rods_version": version("warp-rods"), "scene_hash": plan.scene.hash(),
        "device": _kind(device), "points_in_a_batch": together, "scene": plan.scene.to_toml(),
    }  # fmt: skip
    own = ["settled", "lost", "message", *(["trajectory"] if plan.sweep.keep == "trajectory" else []), "state"]
    columns = columns_of(found, assumes(plan, found))
    store = create(folder / STORE, plan.axes, columns, chunk, own, attributes, {"settled": {"comment": SETTLED}})
    how = f"rods of batches of up to {together}" if together else f"simulated one by one, as {reason}"
    warnings = [f"warning, at the first point: {line}" for line in simulation.warnings]
    return store, [*warnings, f"points are {how}; about {seconds:.2g} s of one core for each"]


def _probe(plan: Plan, simulation: Simulation) -> dict[str, Any]:
    """All measures of a point in which nothing moves, for their names and dimensions; raises SceneError."""
    try:
        found = measured(plan, still(simulation), 1, simulation.surfaces["surface"])
    except ValueError as error:
        raise SceneError(f"sweep.measure: {error}") from None
    refuse_other_dimensions(plan, simulation, found)
    return found


def _seconds(plan: Plan, simulation: Simulation, device: str, alone: bool) -> float:
    """Seconds of one core for a point, simulated alone or as a rod of a batch; some are tried for that."""
    if alone:
        return _tried(simulation)
    points = np.argwhere(plan.first())
    some = [tuple(points[i].tolist()) for i in np.linspace(0, len(points) - 1, TRIED).astype(int)]
    scene = Scene.parse(batch_tables([plan.tables_at(point) for point in some]))
    batch = Simulation(scene, device, seeds=[plan.axes[-1].values[point[-1]] for point in some])
    return _tried(batch) / TRIED


def _tried(simulation: Simulation) -> float:
    """Seconds of a whole simulation: of as much of it as fits in the budget, and as long again for what is left."""
    Record(simulation, ())  # frames take time, too
    begun = time.perf_counter()
    passed = [(0.0, 0.0)]
    for _ in simulation.advance():
        passed.append((time.perf_counter() - begun, simulation.now))
        if passed[-1][0] > BUDGET:
            break
    (before, since), (spent, now) = passed[len(passed) // 2], passed[-1]
    left = simulation.scene.time.end - now
    return spent + (left * (spent - before) / (now - since) if now > since else 0.0)


def _points_in_a_task(plan: Plan, seconds: float, workers: int, fewest: int, most: float) -> int:
    """How many of the first points a task has: some seconds' worth, but so many tasks that all workers have some."""
    total = plan.first_points
    wanted = min(SECONDS / max(seconds, 1e-6), total / (TASKS_EACH * workers), most)
    wanted = max(wanted, min(fewest, total / workers))
    return max(1, math.ceil(max(wanted, total / MOST_TASKS)))


def _chunk(plan: Plan, points: int) -> tuple[int, ...]:
    """The shape of a chunk of the grid with about so many first points: whole rows of the last axes first."""
    chunk: list[int] = []
    for axis in reversed(plan.axes):
        here = min(axis.first, max(points, 1))
        parts = math.ceil(axis.first / here)
        here = math.ceil(axis.first / parts)  # chunks of about equal sizes
        chunk.append(min(here * axis.stride, len(axis)))
        points = round(points / here)
    return tuple(reversed(chunk))

"""How a study begins: its folder, its store with chunks that make tasks of some seconds, and how it goes on later."""

from __future__ import annotations

import contextlib
import math
import shutil
import time
import uuid
from importlib.metadata import version
from pathlib import Path

import numpy as np

from warp_rods.errors import RunFolderError, WarpRodsError
from warp_rods.scene.scene import Scene, text_with_whole_paths
from warp_rods.simulation.files import TRAJECTORIES, replace_file
from warp_rods.simulation.leftovers import aside_of
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.zarr_format import METADATA
from warp_rods.studies.batches import batch_tables, why_not
from warp_rods.studies.columns import columns_of
from warp_rods.studies.inputs import inputs
from warp_rods.studies.new_store import create
from warp_rods.studies.plan import Plan
from warp_rods.studies.points import assumes
from warp_rods.studies.probes import IDLE_SEEDS, probe, seeds_are_idle
from warp_rods.studies.record import Record, bytes_of_a_rod
from warp_rods.studies.store import STORE, Store
from warp_rods.studies.summaries import SETTLED
from warp_rods.studies.tasks import SCENE, scene_of

__all__ = ["begin"]

SECONDS = 5.0
"""What a task should take."""
TASKS_EACH = 4
"""Tasks for each worker, at least, so that all end at about the same time."""
MOST_TASKS = 20_000
"""Of a level of a study: each costs client, scheduler and disk some milliseconds, and about ten files."""
MOST_RODS, MOST_BYTES = 4096, 1.5e8
"""Rods of a batch, and bytes of its trajectory in memory, at most."""
TRIED, BUDGET, LATE = 8, 3.0, 0.9
"""Points with which times are estimated, seconds for that, and the share after which their last steps begin."""
MOST_PLACES = 65536
"""Points of a chunk, which is a file of each variable."""
FEWEST = 192
"""Rods of a batch, where there are as many: reading frames and measuring takes about as long for fewer."""


def begin(plan: Plan, folder: Path, device: str, workers: int, overwrite: bool) -> tuple[Store, list[str]]:
    """The store of a study in ``folder``, made unless it is there, and lines for the user.

    Its kernels are compiled then. Raises RunFolderError where the folder holds another study, or something else, and
    SceneError for a study that is not possible; then what the folder holds stays, with ``overwrite`` as well.
    """
    there = (folder / STORE / METADATA).exists()
    if there and not overwrite:
        return _resumed(plan, folder, device)
    if not there and folder.exists() and any(not file.name.startswith(".") for file in folder.iterdir()):
        raise RunFolderError(f"{folder} holds something that is not a study: give another --out")
    return _created(plan, folder, device, workers, overwrite)


def _resumed(plan: Plan, folder: Path, device: str) -> tuple[Store, list[str]]:
    """The store of a study that goes on, and lines; RunFolderError where its points would not be those of one study."""
    store = Store(folder / STORE)
    attributes = store.attributes
    if attributes.get("scene_hash") != plan.scene.hash():
        raise RunFolderError(
            f"{folder} holds a study of another scene{_differences(store, plan.scene)}: give another --out, or "
            f"--overwrite to replace it"
        )
    if attributes.get("device") != _kind(device):
        raise RunFolderError(
            f"{folder} was begun on {attributes.get('device')}, whose bits are not those of {_kind(device)}: go on "
            f"with --device {attributes.get('device')}"
        )
    if (before := attributes.get("warp_rods_version")) != (now := version("warp-rods")):
        raise RunFolderError(
            f"{folder} was begun with warp-rods {before}, whose numbers may not be those of {now}: go on with that "
            f"version, give another --out, or --overwrite to replace the study"
        )
    files = inputs(plan)
    if changed := [path for path, sha in attributes.get("inputs", {}).items() if files.get(path) != sha]:
        raise RunFolderError(
            f"{folder}: {', '.join(changed)} changed since this study was begun: put back what was there, give "
            f"another --out, or --overwrite to replace the study"
        )
    store.clear_leftovers()
    _copy_scene(store, folder)
    _warm_up(plan, device)
    damaged = store.forget_damaged()
    return store, [f"{file} is damaged or missing: the points in it are computed again" for file in damaged]


def _kind(device: str) -> str:
    return "cuda" if device.startswith("cuda") else "cpu"


def _differences(store: Store, now: Scene) -> str:
    """The tables in which the scene of a study and another one differ, in words."""
    one, other = scene_of(store).model_dump(), now.model_dump()
    keys = [f"[{key}]" if isinstance(other[key] or one[key], dict) else key for key in one if one[key] != other[key]]
    return f" ({', '.join(keys)} differ{'s' if len(keys) == 1 else ''})"


def _warm_up(plan: Plan, device: str) -> Simulation:
    """A simulation of the first point, with which every kernel is compiled before workers need them."""
    simulation = Simulation(plan.scene_at((0,) * len(plan.axes)), device)
    simulation.warm_up()
    return simulation


def _created(plan: Plan, folder: Path, device: str, workers: int, overwrite: bool) -> tuple[Store, list[str]]:
    simulation = _warm_up(plan, device)
    found = probe(plan, simulation)
    reason = why_not(plan.scene, plan.paths, simulation) if plan.sweep.keep == "summary" else "trajectories are kept"
    seconds = _seconds(plan, simulation, device, alone=bool(reason))
    rods = max(simulation.rods, 1)
    together = 0
    if not reason:
        fits = MOST_BYTES / max(bytes_of_a_rod(simulation, plan.needs) * rods, 1.0)
        together = max(1, int(min(MOST_RODS / rods, fits)))
    fewest = math.ceil(FEWEST / rods) if together else 1
    task = _points_in_a_task(plan, seconds, workers, fewest, together or math.inf)
    attributes = {
        "title": plan.scene.title, "warp_rods_version": version("warp-rods"), "scene_hash": plan.scene.hash(),
        "device": _kind(device), "points_in_a_batch": together, "points_in_a_task": task, "inputs": inputs(plan),
        "study": uuid.uuid4().hex,
        # The present folder of workers is another one.
        "scene": text_with_whole_paths(plan.scene.to_toml(), Path.cwd()),
    }  # fmt: skip
    own = ["settled", "lost", "message", *(["trajectory"] if plan.sweep.keep == "trajectory" else []), "state"]
    columns = columns_of(found, assumes(plan, found))
    folder.mkdir(parents=True, exist_ok=True)
    if overwrite:
        _set_aside(folder / TRAJECTORIES)
    explained = {"settled": {"comment": SETTLED}}
    store = create(folder / STORE, plan.axes, columns, _chunk(plan, task), own, attributes, explained, overwrite)
    if store.identity != attributes["study"]:  # another process was faster, perhaps with another scene
        return _resumed(plan, folder, device)
    _copy_scene(store, folder)
    how = f"rods of batches of up to {together}" if together else f"simulated one by one, as {reason}"
    warnings = [f"warning, at the first point: {line}" for line in simulation.warnings]
    if seeds_are_idle(plan, simulation):
        warnings.append(f"warning: {IDLE_SEEDS}")
    return store, [*warnings, f"points are {how}; about {seconds:.2g} s of one core for each"]


def _set_aside(folder: Path) -> None:
    """Remove a folder, which is nobody's from the first moment on."""
    aside = aside_of(folder)
    with contextlib.suppress(FileNotFoundError):
        folder.rename(aside)
    shutil.rmtree(aside, ignore_errors=True)


def _copy_scene(store: Store, folder: Path) -> None:
    """The scene of the study beside its store, for who looks at the folder; nothing reads it."""
    text = store.attributes["scene"].encode()
    if not (folder / SCENE).is_file() or (folder / SCENE).read_bytes() != text:
        replace_file(folder / SCENE, text, store.partial(), durable=True)


def _seconds(plan: Plan, simulation: Simulation, device: str, alone: bool) -> float:
    """Seconds of one core for a point, simulated alone or as a rod of a batch; some are tried for that."""
    if alone:
        return _tried(simulation)
    points = np.argwhere(plan.first())
    some = [tuple(points[i].tolist()) for i in np.linspace(0, len(points) - 1, TRIED).astype(int)]
    for tried in (some, some[:1] * TRIED):  # a point that is not possible fails by itself, later
        with contextlib.suppress(WarpRodsError, ValueError, ArithmeticError):
            scene = Scene.parse(batch_tables([plan.tables_at(point) for point in tried]))
            batch = Simulation(scene, device, seeds=[plan.axes[-1].values[point[-1]] for point in tried])
            return _tried(batch) / TRIED
    return _tried(simulation)


def _tried(simulation: Simulation) -> float:
    """Seconds of a whole simulation: of as much of it as fits in the budget, and what is left at the speed of its end.

    Steps begin short: an average over more of them would be far too slow for those that follow.
    """
    Record(simulation, ())  # frames take time, too
    begun = time.perf_counter()
    passed = [(0.0, 0.0)]
    for _ in simulation.advance():
        passed.append((time.perf_counter() - begun, simulation.now))
        if passed[-1][0] > BUDGET:
            break
    (before, since), (spent, now) = passed[max(0, min(int(LATE * len(passed)), len(passed) - 2))], passed[-1]
    left = simulation.scene.time.end - now
    return spent + (left * (spent - before) / (now - since) if now > since else 0.0)


def _points_in_a_task(plan: Plan, seconds: float, workers: int, fewest: int, most: float) -> int:
    """How many of the first points a task has: some seconds' worth, but so many tasks that all workers have some."""
    total = plan.first_points
    wanted = min(SECONDS / max(seconds, 1e-6), total / (TASKS_EACH * workers), most)
    wanted = max(wanted, min(fewest, total / workers))
    return max(1, math.ceil(max(wanted, total / MOST_TASKS)))


def _chunk(plan: Plan, points: int) -> tuple[int, ...]:
    """The shape of a chunk of the grid with about so many first points: whole rows of the last axes first.

    A file has ``MOST_PLACES`` at most, with those of refinement, as it is written once for each task of the chunk.
    """
    chunk: list[int] = []
    places = MOST_PLACES
    for axis in reversed(plan.axes):
        here = max(min(axis.first, points, places // axis.stride), 1)
        parts = math.ceil(axis.first / here)
        here = math.ceil(axis.first / parts)  # chunks of about equal sizes
        chunk.append(min(here * axis.stride, len(axis)))
        points = round(points / here)
        places //= chunk[-1]
    return tuple(reversed(chunk))

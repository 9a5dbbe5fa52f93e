"""Simulates points of a study and measures them: as the rods of one batch, or each in a simulation of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from warp_rods.errors import RodFailure
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.storage import StorageError
from warp_rods.simulation.under_way import FolderInUse
from warp_rods.studies.batches import batch_tables
from warp_rods.studies.plan import Index, Plan
from warp_rods.studies.record import Record
from warp_rods.studies.summaries import each_point, settled

__all__ = ["COMPUTED", "FAILED", "LOST", "Results", "as_rods", "each_alone", "measured"]

COMPUTED, LOST, FAILED = 1, 2, 3
"""States of a point: measured; all its rods lost, or one where a run would stop; not possible to simulate."""


class Results(NamedTuple):
    """Values at points, [point, …] by the names of variables, and points that raised an error, with its text."""

    points: list[Index]
    values: dict[str, np.ndarray]
    errors: dict[Index, str]


def as_rods(plan: Plan, points: Sequence[Index], device: str) -> Results:
    """Points as the rods of one batch. Raises what the simulation does, as where a point has an impossible value."""
    scene = Scene.parse(batch_tables([plan.tables_at(point) for point in points]))
    seeds = [plan.axes[-1].values[point[-1]] for point in points]
    simulation = Simulation(scene, device, seeds=seeds)
    record = Record(simulation, plan.needs)
    for _ in simulation.advance():
        pass
    counts = _lost_rods(simulation, len(points))
    stops = plan.scene.on_failure == "stop"
    found = _results(plan, list(points), record.data(), simulation.surfaces["surface"], counts, stops)
    found.values["message"][:] = _losses(simulation, len(points))
    return found


def _losses(simulation: Simulation, points: int) -> list[str]:
    """What happened to the rods that each point has lost."""
    said: list[list[str]] = [[] for _ in range(points)]
    for name, ensemble in simulation.ensembles.items():
        for failure in ensemble.failures():
            point, rod = divmod(failure.rod, ensemble.count // points)
            said[point].append(f"{name}: rod {rod} {failure.what} at t = {failure.time:.6g}")
    return ["; ".join(lines) for lines in said]


def each_alone(
    plan: Plan, points: Sequence[Index], device: str, folder: Path | None = None
) -> Iterator[Results]:  # fmt: skip
    """Points in simulations of their own, each of which may fail; in ``folder`` they leave folders of their runs.

    A point whose folder another process writes to is that one's. Raises OSError and StorageError, as on a full disk.
    """
    for point in points:
        try:
            found = _alone(plan, point, device, folder)
        except (OSError, StorageError):
            raise
        except FolderInUse:
            continue
        except Exception as error:  # whatever it is, it is that of this point
            found = Results([], {}, {point: f"{type(error).__name__}: {error}"})
        yield found


def _alone(plan: Plan, point: Index, device: str, folder: Path | None) -> Results:
    """One point in a simulation of its own."""
    scene, stops = plan.scene_at(point), plan.scene.on_failure == "stop"
    if folder is not None:
        return _run(plan, point, scene, device, folder / name_of(point))
    simulation = Simulation(scene, device)
    record = Record(simulation, plan.needs)
    try:
        for _ in simulation.advance():
            if stops and simulation.frozen:
                break
            simulation.new_failures()
    except RodFailure:
        pass  # what was lost is in the data
    said = "; ".join([*filter(None, _losses(simulation, 1)), *simulation.new_warnings()])
    counts = _lost_rods(simulation, 1)
    found = _results(plan, [point], record.data(), simulation.surfaces["surface"], counts, stops)
    found.values["message"][0] = said
    return found


def _run(plan: Plan, point: Index, scene: Scene, device: str, folder: Path) -> Results:
    """One point as a run with a folder, which is continued where it was left."""
    from rich.console import Console

    from warp_rods.simulation.reading import open_run
    from warp_rods.simulation.runner import simulate

    said = ""
    try:
        run = simulate(scene, folder, device=device, resume=True, console=Console(quiet=True))
        said = "; ".join(line for line in run.messages if line.startswith("warning"))
    except RodFailure as error:
        said = str(error)
    data = open_run(folder)
    lost = np.array([sum(int((g["status"].isel(frame=-1) != 0).sum()) for g in data.children.values())])
    rods = sum(group.sizes["rod"] for group in data.children.values())
    stops = plan.scene.on_failure == "stop"
    found = _results(plan, [point], data, _membrane(scene), (lost, rods), stops)
    found.values["message"][0] = said
    found.values["trajectory"][0] = f"{folder.parent.name}/{folder.name}"
    return found


def name_of(point: Index) -> str:
    """The name of the folder of a point."""
    return "-".join(map(str, point))


def _membrane(scene: Scene) -> Any:
    from warp_rods.simulation.surfaces import build_surfaces

    return build_surfaces(scene)[0]


def _lost_rods(simulation: Simulation, points: int) -> tuple[np.ndarray, int]:
    """The number of rods that each point has lost, and of those that it had."""
    each = [(e.status != 0).reshape(points, -1).sum(axis=1) for e in simulation.ensembles.values()]
    return np.sum(each, axis=0), simulation.rods // points


def _results(
    plan: Plan, points: list[Index], data: xr.DataTree, surface: Any, lost: tuple[np.ndarray, int], stops: bool
) -> Results:  # fmt: skip
    """What the trajectory of points, whose rods follow each other, has to tell."""
    count, (number, rods) = len(points), lost
    dead = (number > 0) if stops else (number == rods)
    values: dict[str, np.ndarray] = {
        "state": np.where(dead, LOST, COMPUTED).astype(np.int8),
        "lost": number.astype(np.int32),
        "settled": np.min([settled(group.to_dataset(), count) for group in data.children.values()], axis=0),
        "message": np.full(count, "", dtype=object),
    }
    if plan.sweep.keep == "trajectory":
        values["trajectory"] = np.full(count, "", dtype=object)
    for name, array in ({} if dead.all() else measured(plan, data, count, surface)).items():
        values[name] = array.to_numpy()
        if dead.any():
            values[name] = values[name].copy()
            values[name][dead] = "failed" if values[name].dtype == object else np.nan
    return Results(points, values, {})


def measured(plan: Plan, data: xr.DataTree, count: int, surface: Any) -> dict[str, xr.DataArray]:
    """All measures at so many points [point, …]."""
    found: dict[str, xr.DataArray] = {}
    for wanted in plan.wanted:
        group = data[wanted.ensemble].to_dataset() if wanted.ensemble else data
        each = each_point(wanted.name, wanted.summary, group, count, surface)
        found |= {wanted.prefix + name: values for name, values in each.items()}
    return found


def assumes(plan: Plan, found: Mapping[str, Any]) -> dict[str, bool]:
    """Which variables assume a settled motion."""
    rows = {wanted.prefix + wanted.name: wanted.summary.settled for wanted in plan.wanted}
    return {name: next((yes for key, yes in rows.items() if name.startswith(key)), True) for name in found}

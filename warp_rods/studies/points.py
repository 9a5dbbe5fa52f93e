"""Simulates points of a study and measures them: as the rods of one batch, or each in a simulation of its own."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from warp_rods.errors import RodFailure
from warp_rods.scene.scene import Scene
from warp_rods.simulation.layout import warnings_of_apart
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.storage import StorageError
from warp_rods.simulation.under_way import FolderInUse
from warp_rods.studies.batches import batch_tables
from warp_rods.studies.columns import columns_of
from warp_rods.studies.plan import Index, Plan, Wanted
from warp_rods.studies.record import Record
from warp_rods.studies.store import COMPUTED, LOST
from warp_rods.studies.summaries import each_point, of_all, settled

__all__ = ["Results", "as_rods", "assumes", "each_alone", "measured", "taken"]


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
    surface = simulation.surfaces["surface"]
    found = _results(plan, list(points), record.data(plan.scene), surface, counts, stops)
    lost, warned = _losses(simulation, len(points)), _warnings(plan, points, surface)
    found.values["message"][:] = [_message(*lines) for lines in zip(lost, warned, strict=True)]
    return found


def _message(lost: Sequence[str], warned: Sequence[str]) -> str:
    return "; ".join([*lost, *(f"warning: {line}" for line in warned)])


def _warnings(plan: Plan, points: Sequence[Index], surface: Any) -> list[list[str]]:
    """The warnings of the scene of each point. Those of the batch are about its worst rod, whichever point has that."""
    places = list(dict.fromkeys(point[:-1] for point in points))  # seeds make no difference
    found = warnings_of_apart([plan.scene_at((*place, 0)) for place in places], surface)
    at = dict(zip(places, found, strict=True))
    return [at[point[:-1]] for point in points]


def _losses(simulation: Simulation, points: int) -> list[list[str]]:
    """What happened to the rods that each point has lost."""
    said: list[list[str]] = [[] for _ in range(points)]
    for name, ensemble in simulation.ensembles.items():
        for failure in ensemble.failures():
            point, rod = divmod(failure.rod, ensemble.count // points)
            said[point].append(f"{name}: rod {rod} {failure.what} at t = {failure.time:.6g}")
    return said


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
            if stops and simulation.frozen and not simulation.own_steps:
                break  # rods that do not feel each other go on, as they do in a batch
            simulation.new_failures()
    except RodFailure:
        pass  # what was lost is in the data
    said = _message(_losses(simulation, 1)[0], [*simulation.warnings, *simulation.new_warnings()])
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
        with _not_logged():  # all points have much the same warnings: ``status.warnings`` names the points
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


@contextlib.contextmanager
def _not_logged() -> Iterator[None]:
    """A context in which the logger of the package says nothing."""
    log = logging.getLogger("warp_rods")
    before, log.disabled = log.disabled, True
    try:
        yield
    finally:
        log.disabled = before


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
    told = [settled(group.to_dataset(), count) for group in data.children.values()]
    values: dict[str, np.ndarray] = {
        "state": np.where(dead, LOST, COMPUTED).astype(np.int8),
        "lost": number.astype(np.int32),
        "settled": np.where(dead, -1, of_all(told)).astype(np.int8),
        "message": np.full(count, "", dtype=object),
    }
    if plan.sweep.keep == "trajectory":
        values["trajectory"] = np.full(count, "", dtype=object)
    found = {} if dead.all() else measured(plan, data, count, surface)
    columns = plan.columns or columns_of(found, assumes(plan, found))
    values |= {column.name: column.filled(found.get(column.name), dead) for column in columns}
    return Results(points, values, {})


def measured(plan: Plan, data: xr.DataTree, count: int, surface: Any) -> dict[str, xr.DataArray]:
    """All measures at so many points [point, …]; the attribute ``measure`` of each is its name in the sweep."""
    found: dict[str, xr.DataArray] = {}
    for wanted in plan.wanted:
        found |= taken(wanted, data, count, surface)
    return found


def taken(wanted: Wanted, data: xr.DataTree, count: int, surface: Any) -> dict[str, xr.DataArray]:
    """The variables of one measure at so many points [point, …]."""
    group = data[wanted.ensemble].to_dataset() if wanted.ensemble else data
    each = each_point(wanted.name, wanted.summary, group, count, surface)
    return {wanted.prefix + name: values for name, values in each.items()}


def assumes(plan: Plan, found: Mapping[str, xr.DataArray]) -> dict[str, bool]:
    """Which variables assume a settled motion."""
    rows = {wanted.name: wanted.summary.settled for wanted in plan.wanted}
    return {name: rows[values.attrs["measure"]] for name, values in found.items()}

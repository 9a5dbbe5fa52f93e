"""Probes of a study before it begins: whether its measures are possible and have the same dimensions at all points,
whether its seeds make a difference, and of what its points will be warned.
"""

from __future__ import annotations

import contextlib
import itertools
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.errors import SceneError, WarpRodsError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.layout import warnings_of_apart
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.surfaces import build_surfaces
from warp_rods.studies.axes import Axis
from warp_rods.studies.columns import MEASURE_RUNS, SAME, columns_of
from warp_rods.studies.plan import Index, Plan, Wanted
from warp_rods.studies.points import assumes, taken
from warp_rods.studies.record import drifting, still

__all__ = ["IDLE_SEEDS", "probe", "seeds_are_idle", "warnings_of_corners"]

IDLE_SEEDS = (
    "seeds: nothing in this scene is random, so that all seeds give the same: give shape.perturbation, "
    'placement = "random" or a behaviour, or leave seeds out'
)
MOST_CORNERS = 16
"""Of the grid, that are looked at."""


def probe(plan: Plan, simulation: Simulation) -> dict[str, xr.DataArray]:
    """All measures of a point in which nothing moves, for their names and dimensions; raises SceneError.

    simulation: of the first point.
    """
    found: dict[str, xr.DataArray] = {}
    record = still(simulation)
    for wanted in plan.wanted:
        try:
            found |= taken(wanted, record, 1, simulation.surfaces["surface"])
        except ValueError as error:
            raise SceneError(f"{_named(plan, wanted)}: {error}{_of_frames(str(error), simulation)}") from None
    refuse_other_dimensions(plan, simulation, found)
    return found


def _named(plan: Plan, wanted: Wanted) -> str:
    return f'sweep.measure[{plan.sweep.measure.index(wanted.name)}] = "{wanted.name}"'


def _of_frames(error: str, simulation: Simulation) -> str:
    """The key that gives more frames, where an error is about their number."""
    times = simulation.scene.time
    few = f"; time.save_every = {times.save_every:g} gives {len(simulation.frames.times)} in all: give a smaller one"
    return few if "frames" in error else ""


def seeds_are_idle(plan: Plan, simulation: Simulation) -> bool:
    """Whether there are several seeds and rods start alike with all of them, without anything random later on.

    simulation: of the first point. The last one is looked at as well, where the first one is not random by its values.
    """
    if len(plan.axes[-1]) < 2:
        return False

    def starts(place: Index, seed: int) -> Mapping[str, Mapping[str, Any]]:
        if place == first and seed == 0:
            return simulation.variables()
        return Simulation(plan.scene_at((*place, seed)), str(simulation.device)).variables()

    first, last = (0,) * (len(plan.axes) - 1), tuple(n - 1 for n in plan.shape[:-1])
    with contextlib.suppress(WarpRodsError, ValueError):  # a point that is not possible fails by itself
        if any(table.behaviour for place in (first, last) for table in plan.scene_at((*place, 0)).swimmers):
            return False
        return all(_same(starts(place, 0), starts(place, 1)) for place in dict.fromkeys((first, last)))
    return False


def _same(one: Mapping[str, Mapping[str, Any]], other: Mapping[str, Mapping[str, Any]]) -> bool:
    """Whether the variables of all ensembles have the same bits."""
    return all(
        np.asarray(value).tobytes() == np.asarray(other[name][key]).tobytes()
        for name, frame in one.items()
        for key, value in frame.items()
    )


def warnings_of_corners(plan: Plan) -> list[str]:
    """The warnings of points at the ends of all ranges, each once, with the point that asks for most.

    Without those of the scene itself.
    """
    found, known = dict[str, tuple[int, str]](), _warned(plan.scene)
    ends = [_ends(axis) for axis in plan.axes[:-1]]
    for point in itertools.islice(itertools.product(*ends, [0]), MOST_CORNERS):
        with contextlib.suppress(WarpRodsError, ValueError):  # it is not possible, and will fail by itself
            for line in (line for line in _warned(plan.scene_at(point)) if line not in known):
                kind = re.sub(r"[-+.\de]*\d", "#", line)  # the same of other numbers
                asked = re.search(r"use (\d+) nodes", line)
                worth = int(asked[1]) if asked else 0
                if kind not in found or worth > found[kind][0]:
                    found[kind] = worth, f"at {_place(plan, point)}: {line}"
    return [line for _, line in found.values()]


def _warned(scene: Scene) -> list[str]:
    return warnings_of_apart([scene], build_surfaces(scene)[0])[0]


def _place(plan: Plan, point: Index) -> str:
    """The values of the swept keys at a point."""
    return plan.words(point).rpartition(", ")[0]


def _ends(axis: Axis) -> list[int]:
    """The places of the smallest and the largest number of an axis; the first value of others."""
    if not axis.numeric:
        return [0]
    return sorted({int(np.argmin(axis.values)), int(np.argmax(axis.values))})


def refuse_other_dimensions(plan: Plan, simulation: Simulation, found: Mapping[str, xr.DataArray]) -> None:
    """Raises SceneError for a measure that has other further dimensions, or labels, in motion or at the last point.

    simulation: of the first point. found: all measures in a record in which nothing moves.
    """
    columns = {column.name: column for column in columns_of(found, assumes(plan, found))}
    doubtful = {values.attrs["measure"] for values in found.values() if values.ndim > 1}
    for where, data, surface in _records(plan, simulation) if doubtful else ():
        for wanted in plan.wanted:
            for name, values in _taken(wanted, data, surface).items() if wanted.name in doubtful else ():
                if why := columns[name].misfit(values):
                    what = f"{_named(plan, wanted)}: {where} it has {why}"
                    raise SceneError(f"{what}, {SAME}: {MEASURE_RUNS}")


def _records(plan: Plan, simulation: Simulation) -> Iterator[tuple[str, xr.DataTree, Any]]:
    """Records that differ from that in which nothing moves: where, the record, and the membrane."""
    yield "where rods move", drifting(simulation), simulation.surfaces["surface"]
    try:
        last = Simulation(plan.scene_at(tuple(n - 1 for n in plan.shape)), str(simulation.device))
    except (WarpRodsError, ValueError):
        return  # it is not possible, and will fail by itself
    yield "at the last point", still(last), last.surfaces["surface"]


def _taken(wanted: Wanted, data: xr.DataTree, surface: Any) -> dict[str, xr.DataArray]:
    """A measure; nothing where it cannot be measured, which is found, if it happens, at the points."""
    try:
        return taken(wanted, data, 1, surface)
    except ValueError:
        return {}

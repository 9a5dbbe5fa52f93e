"""Probes of a study before it begins: whether the dimensions of its measures are the same at all points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import xarray as xr

from warp_rods.errors import SceneError, WarpRodsError
from warp_rods.simulation.loop import Simulation
from warp_rods.studies.columns import MEASURE_RUNS, SAME, columns_of
from warp_rods.studies.plan import Plan, Wanted
from warp_rods.studies.points import assumes, taken
from warp_rods.studies.record import drifting, still

__all__ = ["refuse_other_dimensions"]


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
                    i = plan.sweep.measure.index(wanted.name)
                    what = f'sweep.measure[{i}] = "{wanted.name}": {where} it has {why}'
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

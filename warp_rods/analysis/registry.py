"""The table of measures, and ``measure``, which computes any of them for one ensemble or a whole run.

To add one, write a function of an ensemble that returns a DataArray with units, long_name and source
(``described.described``), or a Dataset of several, and give it a row of ``MEASURES``. The first line of its docstring
is its description. A row of ``warp_rods.draw.measured.PLOTS`` gives it a plot. A script can add rows to both tables.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from warp_rods import arguments
from warp_rods.analysis import balance, crossings, curvature, kymograph, load, motion, motion_class, settling, shape
from warp_rods.analysis.conditions import (
    CENTRES_APART,
    GROWTH,
    LATE_FRAMES,
    MIDDLES_APART,
    WIDE_BOX,
    even_frames,
    frames,
)
from warp_rods.analysis.described import without_failed
from warp_rods.analysis.listing import MEMBRANE, Measure, Measures
from warp_rods.analysis.membrane import has_membrane, membrane_moves, membrane_of
from warp_rods.analysis.swarm import motion as swarm_motion
from warp_rods.analysis.swarm import order, shapes, space
from warp_rods.analysis.swarm.data import check_nodes, members_of, together
from warp_rods.errors import nearest
from warp_rods.membranes.surfaces import Surface

__all__ = ["MEASURES", "Measure", "Measures", "measure", "measures"]

LOG = logging.getLogger("warp_rods")
FAILED = "failed"
"""The value of a rod that failed in a measure whose values are words."""
IN_STUDIES = {"class": "shape_class", "modes": "mode_coefficients"}
"""Measures that have a shorter name in a parameter study, too."""
_ENERGIES = ("activity", "strain", "energy_density")
_GAUSS = ("gauss", "status", MEMBRANE)
_FORCE = ("load", "end_load", "length")
_TORQUE = (*_FORCE, "load_moment", "end_moment", "position", "orientation")
_RELAXATION = ("energy", "steric_energy", "dissipation", "status")

MEASURES = Measures(
    {
        "mode_coefficients": Measure(shape.mode_coefficients, "rods", "1/length", ("strain",)),
        "twist_harmonics": Measure(shape.twist_harmonics, "rods", "1/length", ("strain",)),
        "total_twist": Measure(shape.total_twist, "rods", "1", ("strain",)),
        "writhe": Measure(shape.writhe, "rods", "1", ("position",)),
        "speed": Measure(motion.speed, "rods", "length/time", ("position",), (frames(2),)),
        "instantaneous_speed": Measure(motion.instantaneous_speed, "rods", "length/time", ("position",), (frames(3),)),
        "energy_balance": Measure(balance.energy_balance, "rods", "1", ("energy", "dissipation"), (frames(3),)),
        "arc_length": Measure(balance.arc_length, "rods", "1", ("position", "strain")),
        "orthonormality": Measure(balance.orthonormality, "rods", "1", ("orientation",)),
        "bending_energy": Measure(balance.bending_energy, "swimmers", "force*length", _ENERGIES),
        "twist_energy": Measure(balance.twist_energy, "swimmers", "force*length", _ENERGIES),
        "period": Measure(motion_class.period, "swimmers", "time", ("activity", "strain"), (LATE_FRAMES,)),
        "shape_class": Measure(
            motion_class.shape_class, "swimmers", "1", ("activity", "strain", "status"), (LATE_FRAMES,)
        ),
        "curvature_histogram": Measure(curvature.curvature_histogram, "filaments", "1", _GAUSS),
        "enrichment": Measure(curvature.enrichment, "filaments", "1", _GAUSS),
        "settling_time": Measure(settling.settling_time, "filaments", "time", ("position", "length", "status")),
        "relaxation_time": Measure(settling.relaxation_time, "filaments", "time", _RELAXATION),
        "energy_terms": Measure(
            kymograph.energy_terms, "filaments", "force", ("stiffness", "intrinsic", "strain", "length")
        ),
        "energy_per_length": Measure(
            kymograph.energy_per_length,
            "filaments",
            "force",
            ("energy", "steric_energy", "length"),
            (frames(2), GROWTH),
        ),
        "dissipation_peaks": Measure(kymograph.dissipation_peaks, "filaments", "1", ("dissipation", "length")),
        "force_on_membrane": Measure(load.force_on_membrane, "filaments", "force", _FORCE),
        "torque_on_membrane": Measure(load.torque_on_membrane, "filaments", "force*length", _TORQUE),
        "polar_order": Measure(order.polar_order, "swarm", "1", ("position",)),
        "nematic_order": Measure(order.nematic_order, "swarm", "1", ("position",)),
        "motion_order": Measure(order.motion_order, "swarm", "1", ("position",), (frames(2),)),
        "local_polar_order": Measure(order.local_polar_order, "swarm", "1", ("position",), (WIDE_BOX,)),
        "local_nematic_order": Measure(order.local_nematic_order, "swarm", "1", ("position",), (WIDE_BOX,)),
        "mean_speed": Measure(swarm_motion.mean_speed, "swarm", "length/time", ("position",), (frames(2),)),
        "speed_distribution": Measure(
            swarm_motion.speed_distribution, "swarm", "time/length", ("position",), (frames(2),)
        ),
        "mean_square_displacement": Measure(
            swarm_motion.mean_square_displacement, "swarm", "length^2", ("position",), (even_frames(3),)
        ),
        "displacement_exponent": Measure(
            swarm_motion.displacement_exponent, "swarm", "1", ("position",), (even_frames(5),)
        ),
        "pair_correlation": Measure(space.pair_correlation, "swarm", "1", ("position",), (MIDDLES_APART,)),
        "velocity_correlation": Measure(
            space.velocity_correlation, "swarm", "1", ("position",), (frames(2), CENTRES_APART)
        ),
        "density_map": Measure(space.density_map, "swarm", "1/length^d", ("position",)),
        "shape_shares": Measure(shapes.shape_shares, "swarm", "1", ("activity", "strain", "position")),
        "crossings": Measure(crossings.crossings_per_frame, "swarm", "1", ("position",)),
    }
)
"""Every measure: its function, what it applies to, the units of its values, and what it needs."""


def measures(data: xr.Dataset | xr.DataTree | None = None) -> Measures:
    """The table of measures with their units and needs; for given data, those that can be computed from the data.

    ``help(wr.measures()["speed"].function)`` explains one measure and its options.
    """
    if data is None:
        return Measures(MEASURES)
    _check_data(data)
    return Measures({name: row for name, row in MEASURES.items() if _is_possible(name, row, data)})


def measure(data: xr.Dataset | xr.DataTree, *names: str, **options: Any) -> xr.Dataset:
    """The measures with these names in one Dataset; ``measures()`` lists them.

    ``data``: one ensemble, ``open_run(folder)[name]``, or a whole run. Measures of swarms combine all swimmers of a
    run, or all filaments where it has none; the others take one ensemble. An option goes to every measure in the call
    that accepts it. Measures that need the membrane take it from the scene of the run; ``surface=`` replaces it, for
    example by ``surface.at(t)`` of a moving one.

    Rods that have failed by the last frame of the data are left out of every measure: NaN (or "failed") in those of
    single rods. The attribute ``left_out`` names them, and so does a warning of the logger ``warp_rods``. Select
    earlier frames to measure a rod until it failed.

    Raises ValueError for an unknown name or option, for a run where one ensemble is needed, where the data lack a
    variable that a measure needs, and where all rods failed.
    """
    return take(MEASURES, data, names, options)


def take(
    table: Mapping[str, Measure], data: xr.Dataset | xr.DataTree, names: Sequence[str], options: Mapping[str, Any]
) -> xr.Dataset:
    """The measures with these names in a table, as ``measure`` computes them."""
    if not names:
        raise ValueError("no measure is named: measures(data) lists those for these data")
    _check_data(data)
    for name in names:
        if isinstance(name, str) and name not in table and (why := _no_measure(name, data)):
            raise ValueError(why)
    rows = {name: named(table, name) for name in names}
    _check_options(rows, options)
    for name, row in rows.items():
        if obstacle := _obstacle(name, row, data, options.get("surface")):
            raise ValueError(obstacle)
    found = [_taken(name, row, data, options) for name, row in rows.items()]
    return xr.merge(found, join="outer", compat="no_conflicts")


def _no_measure(name: str, data: xr.Dataset | xr.DataTree) -> str:
    """What somebody may have meant who asks for a measure that there is not; empty where it is not known."""
    if name in IN_STUDIES:
        return f"no measure called {name}, its name in a study: {IN_STUDIES[name]}"
    groups = [data] if isinstance(data, xr.Dataset) else list(data.children.values())
    if any(name in group.data_vars for group in groups):
        where = "" if isinstance(data, xr.Dataset) else f'["{next(k for k, g in data.children.items() if name in g)}"]'
        return f'no measure called {name}: it is a variable: data{where}["{name}"]'
    return ""


def named(table: Mapping[str, Measure], name: str) -> Measure:
    """The row with this name; raises ValueError with the nearest and all known names where it is unknown."""
    if not isinstance(name, str) or name not in table:
        raise ValueError(f"no measure called {name}{nearest(name, table)}: there are {', '.join(table)}")
    return table[name]


def _check_options(rows: Mapping[str, Measure], options: Mapping[str, Any]) -> None:
    """Raises ValueError where no measure takes an option."""
    accepted = {name: row.options for name, row in rows.items()}
    for option in options:
        if not any(option in own for own in accepted.values()):
            allowed = "; ".join(f"{name} takes {', '.join(own) or 'none'}" for name, own in accepted.items())
            raise ValueError(f"{option}: not an option of {', '.join(rows)}. Options: {allowed}")
    if options.get("surface") is not None:
        arguments.instance("surface", options["surface"], Surface, "a Surface, which surfaces.make(kind, …) returns")


def _check_data(data: Any) -> None:
    """Raises ValueError for data that are not those of a run."""
    if not isinstance(data, (xr.Dataset, xr.DataTree)):
        raise ValueError(f"data: {type(data).__name__}; give one ensemble or a run as open_run reads it")


def _is_possible(name: str, row: Measure, data: xr.Dataset | xr.DataTree) -> bool:
    """Whether a measure can be computed from these data with its default options."""
    if _obstacle(name, row, data):
        return False
    group, *others = _groups(row, data)
    if not group.sizes.get("frame", 1) or (row.needs_membrane and membrane_moves(group)):
        return False
    ends = data.isel(frame=[0, -1], missing_dims="ignore")
    ends = together(ends) if others else _groups(row, ends)[0]  # type: ignore[arg-type]
    return all(condition.holds(ends if condition.of_ends else group) for condition in row.conditions)


def _obstacle(name: str, row: Measure, data: Any, surface: Surface | None = None) -> str:
    """Why a measure cannot be computed from these data; empty where it can."""
    try:
        groups = _groups(row, data)
    except ValueError as error:
        return f"{name}: {error}"
    for group in groups:
        if lacking := [need for need in row.needs if need not in group and need != MEMBRANE]:
            return f"{name}: the group has no {', '.join(lacking)}; it has {', '.join(sorted(map(str, group)))}"
        if row.of == "filaments" and "activity" in group:
            return f"{name}: a measure of filaments, and these are swimmers"
        if row.needs_membrane and surface is None and not has_membrane(group):
            return f"{name}: needs the membrane, and the scene of these data has none; give surface="
    return ""


def _groups(row: Measure, data: xr.Dataset | xr.DataTree) -> list[xr.Dataset]:
    """The ensembles of the data, several only for a swarm. Raises ValueError where one of several must be chosen."""
    if isinstance(data, xr.Dataset):
        return [data]
    if len(data.children) < 2:
        return [next(iter(data.children.values()), data).to_dataset()]
    if row.of == "swarm":
        members = {name: data[name].to_dataset() for name in members_of(data)}
        check_nodes(members)
        return list(members.values())
    first, *others = data.children
    raise ValueError(f"a measure of one ensemble: give run[{first!r}] or another of {', '.join(others)}")


def _taken(name: str, row: Measure, data: xr.Dataset | xr.DataTree, options: Mapping[str, Any]) -> xr.Dataset:
    """One measure as a Dataset; the attribute ``measure`` of its variables is its name."""
    groups = _groups(row, data)
    if len(groups) > 1:
        assert isinstance(data, xr.DataTree)
        group = together(data)
    else:
        (group,) = groups
    ok = without_failed(group)
    own = {key: value for key, value in options.items() if key in row.options and key != "surface"}
    surface = options.get("surface")
    needed = [membrane_of(group) if surface is None else surface] if row.needs_membrane else []
    found = row.function(ok, *needed, **own)
    found = found.to_dataset(name=name) if isinstance(found, xr.DataArray) else found
    said = {"measure": name}
    if "rod" in found.dims and "rod" not in found.coords:
        found = found.assign_coords(rod=ok["rod"].to_numpy())
    if failed := sorted(set(group["rod"].to_numpy().tolist()) - set(ok["rod"].to_numpy().tolist())):
        said["left_out"] = f"failed rods {', '.join(map(str, failed))}"
        LOG.warning(f"{name}: {said['left_out']} are left out")
        found = _with_failed(found, group["rod"].to_numpy())
    return found.assign({key: found[key].assign_attrs(said) for key in found.data_vars})


def _with_failed(found: xr.Dataset, rods: np.ndarray) -> xr.Dataset:
    """A measure with all ``rods``: NaN for those that it left out, "failed" where it is a word."""
    if "rod" not in found.dims:
        return found
    words = {name: FAILED for name, values in found.data_vars.items() if values.dtype.kind == "U"}
    fill = {name: np.nan for name in [*found.data_vars, *found.coords] if name not in words} | words
    return found.reindex(rod=rods, fill_value=fill)

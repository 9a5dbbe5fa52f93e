"""What one measures of swarms: the table of measures, the table of their plots, and how to take and draw them.

To add a measure, write a function of a dataset that returns a DataArray with units, long_name and source
(``measures.described``) and a function that draws it, and give them a row of ``MEASURES`` and one of ``PLOTS``.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import xarray as xr

from warp_rods.analysis import crossings, measures
from warp_rods.analysis.swarm import (
    data as swarm_data,
)
from warp_rods.analysis.swarm import (
    motion as swarm_motion,
)
from warp_rods.analysis.swarm import (
    order as swarm_order,
)
from warp_rods.analysis.swarm import (
    shapes as swarm_shapes,
)
from warp_rods.analysis.swarm import (
    space as swarm_space,
)
from warp_rods.draw import plots, swarm_plots

MEASURES: dict[str, Callable[..., xr.DataArray]] = {
    "polar_order": swarm_order.polar_order,
    "nematic_order": swarm_order.nematic_order,
    "motion_order": swarm_order.motion_order,
    "local_polar_order": swarm_order.local_polar_order,
    "local_nematic_order": swarm_order.local_nematic_order,
    "mean_speed": swarm_motion.mean_speed,
    "speed_distribution": swarm_motion.speed_distribution,
    "mean_square_displacement": swarm_motion.mean_square_displacement,
    "displacement_exponent": swarm_motion.displacement_exponent,
    "pair_correlation": swarm_space.pair_correlation,
    "velocity_correlation": swarm_space.velocity_correlation,
    "density_map": swarm_space.density_map,
    "shape_shares": swarm_shapes.shape_shares,
    "crossings": crossings.crossings_per_frame,
}
"""By name: functions ``(dataset, **options)``; what the options are is said by each."""

PLOTS: dict[str, Callable[[Any, xr.DataArray], None]] = {
    "polar_order": swarm_plots.order,
    "nematic_order": swarm_plots.order,
    "motion_order": swarm_plots.order,
    "local_polar_order": swarm_plots.local_order,
    "local_nematic_order": swarm_plots.local_order,
    "mean_speed": swarm_plots.over_time,
    "speed_distribution": swarm_plots.speed_distribution,
    "mean_square_displacement": swarm_plots.mean_square_displacement,
    "displacement_exponent": swarm_plots.displacement_exponent,
    "pair_correlation": swarm_plots.pair_correlation,
    "velocity_correlation": swarm_plots.velocity_correlation,
    "density_map": swarm_plots.density_map,
    "shape_shares": swarm_plots.shape_shares,
    "crossings": swarm_plots.crossings,
}
"""By name of the measure: what draws it."""


def measure(dataset: xr.Dataset, *names: str) -> xr.Dataset:
    """The measures of these names, each with its default options, of one group of a trajectory.

    ``dataset``: ``open_run(run_dir)[group].to_dataset()``. Raises ValueError for an unknown name, and where
    the group lacks what a measure needs.
    """
    return measures.taken(MEASURES, dataset, names)


def together(run: xr.DataTree, *names: str) -> xr.Dataset:
    """Ensembles of a run, by default all swimmers, as one swarm to be measured: see ``swarm_data.together``."""
    return swarm_data.together(run, *names)


def plot(data: xr.Dataset, name: str, path: str | Path | None = None) -> Any:
    """The Matplotlib figure of one measure, saved as ``path``.png and ``path``.svg where a path is given.

    ``data``: what ``measure`` gave, or the group of a trajectory, which is measured first. Raises ValueError as
    ``measure``.
    """
    measured = data[name] if name in MEASURES and name in data else measure(data, name)[name]
    figure = plots.figure()
    PLOTS[name](figure.add_subplot(), measured)
    if path is not None:
        plots.save(figure, path)
    return figure

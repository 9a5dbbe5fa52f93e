"""A plot of every measure: the table ``PLOTS``, and ``plot``, which draws any of them.

To add one, write a function ``(axes, measured, **options)`` of Matplotlib's axes and of what ``measure`` found, a
DataArray, or a Dataset where the measure gives several variables; and give it a row of ``PLOTS``.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import xarray as xr

from warp_rods.analysis.registry import MEASURES, measure, named
from warp_rods.draw import correlations, distributions, maps, over_time, plots

__all__ = ["PLOTS", "plot"]

PLOTS: dict[str, Callable[..., None]] = {
    "mode_coefficients": over_time.modes,
    "twist_harmonics": over_time.modes,
    "total_twist": over_time.curve,
    "writhe": over_time.curve,
    "speed": distributions.histogram,
    "instantaneous_speed": over_time.curve,
    "energy_balance": over_time.error,
    "arc_length": over_time.error,
    "orthonormality": over_time.error,
    "bending_energy": over_time.curve,
    "twist_energy": over_time.curve,
    "period": distributions.histogram,
    "shape_class": distributions.classes,
    "curvature_histogram": distributions.curvature_histogram,
    "enrichment": over_time.enrichment,
    "settling_time": distributions.settled,
    "relaxation_time": distributions.settled,
    "energy_terms": maps.energy_terms,
    "energy_per_length": over_time.curve,
    "dissipation_peaks": distributions.peaks,
    "polar_order": over_time.order,
    "nematic_order": over_time.order,
    "motion_order": over_time.order,
    "local_polar_order": over_time.local_order,
    "local_nematic_order": over_time.local_order,
    "mean_speed": over_time.curve,
    "speed_distribution": distributions.speed_distribution,
    "mean_square_displacement": correlations.mean_square_displacement,
    "displacement_exponent": correlations.displacement_exponent,
    "pair_correlation": correlations.pair_correlation,
    "velocity_correlation": correlations.velocity_correlation,
    "density_map": maps.density_map,
    "shape_shares": over_time.shape_shares,
    "crossings": over_time.crossings,
}
"""By name of the measure: what draws it. ``over_time.curve`` serves any with one value per frame, or frame and rod."""


def plot(data: xr.Dataset | xr.DataTree, name: str, path: str | Path | None = None, **options: Any) -> Any:
    """The figure of one measure, which a notebook shows; saved as ``path``.png and ``path``.svg where a path is given.

    ``data``: what ``measure`` found, or what it takes. Options go to the plot or to the measure, whichever accepts
    them. Raises ValueError as ``measure`` does, and where a measure has no plot.
    """
    named(MEASURES, name)
    if name not in PLOTS:
        raise ValueError(f"{name} has no plot: give it a row of warp_rods.draw.measured.PLOTS")
    draw = PLOTS[name]
    own = {key: value for key, value in options.items() if key in list(inspect.signature(draw).parameters)[2:]}
    measured = _measured(data, name, {key: value for key, value in options.items() if key not in own})
    with plots.style():
        figure = plots.figure()
        draw(figure.add_subplot(), measured[name] if set(measured.data_vars) == {name} else measured, **own)
    if path is not None:
        plots.save(figure, path)
    return figure


def _measured(data: xr.Dataset | xr.DataTree, name: str, options: dict[str, Any]) -> xr.Dataset:
    """The variables of one measure, taken now unless the data are measured already."""
    known = []
    if isinstance(data, xr.Dataset):
        known = [key for key, array in data.data_vars.items() if array.attrs.get("measure") == name]
    if not known or not isinstance(data, xr.Dataset):
        return measure(data, name, **options)
    if options:
        raise ValueError(f"{', '.join(options)}: not an option of this plot; {name} has been measured already")
    return data[known]

"""Plots of measures: the table ``PLOTS``, and ``plot``, which draws any of them.

To add one, write a function ``(axes, measured, **options)`` and give it a row of ``PLOTS``. ``axes`` are Matplotlib
axes; ``measured`` is the DataArray of a measure, or a Dataset where the measure has several variables.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from warp_rods.analysis.registry import MEASURES, measure, named
from warp_rods.draw import correlations, distributions, maps, over_time, plots
from warp_rods.draw.views import View, options_of, views

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
    "force_on_membrane": over_time.magnitude,
    "torque_on_membrane": over_time.magnitude,
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
"""Plot function of each measure. ``over_time.curve`` draws any measure over (frame) or (frame, rod)."""


def plot(data: xr.Dataset | xr.DataTree, name: str, path: str | Path | None = None, **options: Any) -> Figure:
    """The figure of one measure, or of what a trajectory holds; saved as ``path``.png and .svg where a path is given.

    ``data``: the result of ``measure``, or data that ``measure`` takes; one ensemble for the names of ``views``, such
    as "energies" and "kymograph_twist". Options go to the plot function or to the measure, whichever accepts them.
    Raises ValueError as ``measure`` does, and where the measure has no plot.
    """
    if isinstance(data, xr.Dataset) and name not in MEASURES and (row := views(data).get(name)) is not None:
        return _drawn(lambda axes: row.function(axes, data, **_checked(name, row, options)), path)
    named(MEASURES, name)
    if name not in PLOTS:
        raise ValueError(f"{name} has no plot: give it a row of warp_rods.draw.measured.PLOTS")
    draw = PLOTS[name]
    own = {key: value for key, value in options.items() if key in list(inspect.signature(draw).parameters)[2:]}
    measured = _measured(data, name, {key: value for key, value in options.items() if key not in own})
    values = measured[name] if set(measured.data_vars) == {name} else measured
    return _drawn(lambda axes: draw(axes, values, **own), path)


def _drawn(draw: Callable[[Any], None], path: str | Path | None) -> Figure:
    """A figure with what a function draws on its axes."""
    with plots.style():
        figure = plots.figure()
        draw(figure.add_subplot())
    if path is not None:
        plots.save(figure, path)
    return figure


def _checked(name: str, row: View, options: dict[str, Any]) -> dict[str, Any]:
    """The options of a view; raises ValueError for one that it does not take."""
    for option in options.keys() - set(options_of(row)):
        raise ValueError(f"{option}: not an option of {name}, which takes {', '.join(options_of(row)) or 'none'}")
    return options


def _measured(data: xr.Dataset | xr.DataTree, name: str, options: dict[str, Any]) -> xr.Dataset:
    """The variables of one measure, computed unless the data contain them already."""
    known = []
    if isinstance(data, xr.Dataset):
        known = [key for key, array in data.data_vars.items() if array.attrs.get("measure") == name]
    if not known or not isinstance(data, xr.Dataset):
        return measure(data, name, **options)
    if options:
        raise ValueError(f"{', '.join(options)}: not an option of this plot; {name} has been measured already")
    return data[known]

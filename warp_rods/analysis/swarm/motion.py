"""Motion of a swarm: speeds and displacements.

The position of a rod is that of its centre, ∫ r ds / L, which oscillates less than the middle node. Velocities are
differences between frames: central and second order in their spacing, one-sided in the first and the last. Failed rods
are left out.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from warp_rods.analysis.described import attributes, described, units_of
from warp_rods.analysis.swarm.data import centres, over_frames, surviving, velocities

LAGS = 60
"""Largest number of lags, spaced evenly on a logarithmic scale up to half the run."""


def mean_speed(dataset: xr.Dataset) -> xr.DataArray:
    """Mean speed of the rods (frame).

    ⟨|v|⟩. Raises ValueError where there are fewer than two frames.
    """
    dataset = surviving(dataset)
    values = np.linalg.norm(velocities(dataset), axis=-1).mean(axis=1)
    return over_frames(dataset, values, "mean speed", "⟨|v|⟩", "length/time")


def speed_distribution(dataset: xr.Dataset, bins: int = 50) -> xr.DataArray:
    """Probability density of the speed (v).

    Over all rods and frames. ``bins`` of equal width from 0 to the largest speed, with ``v`` at their middles; it
    integrates to one. Raises ValueError where there are fewer than two frames.
    """
    dataset = surviving(dataset)
    speeds = np.linalg.norm(velocities(dataset), axis=-1)
    # The largest speed belongs in the last bin, even where all are at rest.
    top = np.nextafter(max(speeds.max(), np.finfo(float).tiny), np.inf)
    density, edges = np.histogram(speeds, bins, (0.0, top), density=True)
    found = described(dataset, ("v",), density, "time/length", "probability density", "p(|v|)")
    speed = attributes(units_of(dataset, "length/time"), "speed")
    return found.assign_coords(v=("v", (edges[1:] + edges[:-1]) / 2, speed))


def mean_square_displacement(dataset: xr.Dataset) -> xr.DataArray:
    """Mean square displacement against lag (lag).

    ⟨|r(t + lag) − r(t)|²⟩ over the rods and all times t, for lags up to half the run: v² lag² for straight motion, 2d D
    lag for diffusion in d dimensions. Lags are multiples of the time between frames. As all times t count, neighbouring
    values are not independent. Raises ValueError where frames are not equally spaced in time, or fewer than three.
    """
    dataset = surviving(dataset)
    at, interval = centres(dataset), _interval(dataset)
    longest = (len(at) - 1) // 2
    lags = np.unique(np.round(np.geomspace(1, longest, LAGS)).astype(int))
    values = [np.sum((at[lag:] - at[:-lag]) ** 2, axis=-1).mean() for lag in lags]
    found = described(dataset, ("lag",), values, "length^2", "mean square displacement", "⟨|r(t + lag) − r(t)|²⟩")
    return found.assign_coords(lag=("lag", lags * interval, attributes(units_of(dataset, "time"), "lag")))


def displacement_exponent(dataset: xr.Dataset) -> xr.DataArray:
    """Exponent of the mean square displacement (lag).

    d ln MSD / d ln lag: 2 for straight motion, 1 for diffusion. Raises ValueError as ``mean_square_displacement`` does,
    and where there are fewer than five frames.
    """
    msd = mean_square_displacement(dataset)
    if msd.sizes["lag"] < 2:
        raise ValueError(
            f"an exponent needs two lags and hence five frames or more; there are {dataset.sizes['frame']}"
        )
    with np.errstate(divide="ignore", invalid="ignore"):  # rods at rest have no exponent: NaN
        values = np.gradient(np.log(msd.to_numpy()), np.log(msd["lag"].to_numpy()))
    found = described(dataset, ("lag",), values, "1", "exponent of the displacement", "d ln MSD / d ln lag")
    return found.assign_coords(lag=msd["lag"])


def evenly_spaced(times: np.ndarray) -> bool:
    """Whether the intervals between frames are equal."""
    spacing = np.diff(times)
    return np.ptp(spacing) <= 1e-6 * spacing[0]


def _interval(dataset: xr.Dataset) -> float:
    """Time between frames."""
    times = dataset["time"].to_numpy()
    if len(times) < 3 or not evenly_spaced(times):
        raise ValueError("needs three frames or more, equally spaced in time: select them with dataset.isel(frame=…)")
    return float((times[-1] - times[0]) / (len(times) - 1))

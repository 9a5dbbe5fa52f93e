"""Times at which filaments have settled, in position and in energy."""

from __future__ import annotations

import numpy as np
import xarray as xr

from warp_rods.analysis.described import attributes, need, units_of


def settling_time(data: xr.Dataset, distance: float = 0.1, quiet: float = 0.2) -> xr.Dataset:
    """Time from which the midpoint stays in place (rod).

    The first saved time from which it stays within ``distance`` rod lengths of its final place. inf where this is in
    the last fraction ``quiet`` of the run, as a filament that still drifts is near its final place only late, however
    long the run. A median over rods is therefore valid as long as fewer than half are inf. NaN for failed rods.
    """
    need(data, "position", "length", "status")
    middle = data.position.isel(node=data.sizes["node"] // 2)
    away = np.sqrt(((middle - _last(middle)) ** 2).sum("axis")) > distance * data.length
    time = _last_true(away, data.time)
    latest = float(data.time[-1]) - quiet * _span(data)
    time = time.where(time <= latest, np.inf).where(_last(data.status) == 0)
    source = f"first time from which |r(0, t) − r(0, T)| ≤ {distance:g} L; inf after {latest:g}"
    return xr.Dataset({"settling_time": time.assign_attrs(attributes(units_of(data, "time"), "settling time", source))})


def relaxation_time(data: xr.Dataset, fraction: float = 0.95) -> xr.Dataset:
    """Time by which a fraction of the energy is released (rod).

    The first saved time from which the energy, elastic and steric, exceeds its final value by at most 1 − ``fraction``
    of its largest excess. inf where the final dissipation rate, over another run of the same duration, would release
    more than that; NaN for failed rods. Nearly all energy of a random start is bending, which is released long before a
    filament reaches its place; a ``fraction`` of 0.9999 shows this slower motion.
    """
    need(data, "energy", "steric_energy", "dissipation", "status")
    energy = data.energy + data.steric_energy
    excess = energy - _last(energy)
    rest = (1 - fraction) * excess.max("frame")
    time = _last_true(np.abs(excess) > rest, data.time)
    still = _last(data.dissipation) * _span(data) > rest
    time = time.where(~still, np.inf).where(_last(data.status) == 0)
    source = f"first time from which |E − E(T)| ≤ {1 - fraction:g} max (E − E(T)), (5.28)"
    return xr.Dataset(
        {"relaxation_time": time.assign_attrs(attributes(units_of(data, "time"), "relaxation time", source))}
    )


def _last_true(condition: xr.DataArray, time: xr.DataArray) -> xr.DataArray:
    """The first time [rod] from which a condition [frame, rod] stays false; it is false at the end."""
    frames = condition.transpose("frame", "rod").values
    after = np.where(frames.any(axis=0), len(frames) - np.argmax(frames[::-1], axis=0), 0)
    return xr.DataArray(time.values[after], dims="rod")


def _last(values: xr.DataArray) -> xr.DataArray:
    return values.isel(frame=-1).drop_vars("time")


def _span(data: xr.Dataset) -> float:
    return float(data.time[-1] - data.time[0])

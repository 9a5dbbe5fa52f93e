"""Plots against distance or lag: functions ``(axes, measured)``."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from warp_rods.draw.labels import BLUE, GUIDE, label, plain_numbers

LATE = 0.5
"""Correlations are averaged over the frames after this fraction of the run."""


def mean_square_displacement(axes: Any, measured: xr.DataArray) -> None:
    """Against lag on logarithmic axes, with the slopes of straight motion and of diffusion."""
    lag, msd = measured["lag"].to_numpy(), measured.to_numpy()
    axes.loglog(lag, msd, color=BLUE)
    limits = axes.get_ylim()
    axes.plot(lag, msd[0] * (lag / lag[0]) ** 2, label="straight motion, ∝ lag²", **GUIDE)
    axes.plot(lag, msd[-1] * lag / lag[-1], label="diffusion, ∝ lag", **(GUIDE | {"linestyle": ":"}))
    axes.set(ylim=limits, xlabel=label(measured["lag"]), ylabel=label(measured))
    plain_numbers(axes.xaxis)
    plain_numbers(axes.yaxis)
    axes.legend()


def displacement_exponent(axes: Any, measured: xr.DataArray) -> None:
    """Against lag, with the exponents of straight motion and of diffusion."""
    axes.semilogx(measured["lag"], measured, color=BLUE)
    axes.axhline(2, label="straight motion", **GUIDE)
    axes.axhline(1, label="diffusion", **(GUIDE | {"linestyle": ":"}))
    axes.set(ylim=(0, 2.1), xlabel=label(measured["lag"]), ylabel=label(measured))
    plain_numbers(axes.xaxis)
    axes.legend()


def pair_correlation(axes: Any, measured: xr.DataArray) -> None:
    """g(r) averaged over the later half of the frames, and the standard error of one frame of independent rods."""
    late = _late(measured)
    error = 1 / np.sqrt(np.maximum(late["expected"].mean("frame").to_numpy(), 1e-9))
    r = late["r"].to_numpy()
    axes.fill_between(r, 1 - error, 1 + error, color="0.85", linewidth=0, label="independent rods, error of one frame")
    axes.plot(r, late.mean("frame"), color=BLUE, label="mean of the later half")
    axes.set(xlim=(0, None), xlabel=label(measured["r"]), ylabel=label(measured))
    axes.set_ylim(0, 1.1 * max(1.5, float(late.mean("frame").max())))
    axes.legend()


def velocity_correlation(axes: Any, measured: xr.DataArray) -> None:
    """C_v(r) averaged over the later half of the frames."""
    values = _late(measured).mean("frame")
    axes.plot(values["r"], values, color=BLUE, marker="o")
    axes.axhline(0, **GUIDE)
    axes.set_ylim(min(-0.2, 1.1 * float(values.min())), max(0.5, 1.1 * float(values.max())))
    axes.set(xlim=(0, None), xlabel=label(measured["r"]), ylabel=label(measured))


def _late(measured: xr.DataArray) -> xr.DataArray:
    """The later frames at the distances that have a value; a dataset of several measures has other bins, too.

    Raises ValueError where there are none.
    """
    late = measured.isel(frame=slice(int(LATE * measured.sizes["frame"]), None)).dropna("r", how="all")
    if not late.size:
        raise ValueError(f"{measured.name} has no value at any distance: there is nothing to draw")
    return late

"""Distributions of a value over the rods or over the membrane: functions ``(axes, measured)``."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from warp_rods.analysis.motion_class import CLASSES
from warp_rods.analysis.registry import FAILED
from warp_rods.draw.labels import BLUE, GUIDE, bin_edges, label, named

FEW = 10
"""Up to this number, rods are drawn one by one."""


def histogram(axes: Any, measured: xr.DataArray) -> None:
    """Histogram over the rods, or the value of each where they are few; the title counts rods without a value."""
    known = measured[np.isfinite(measured.to_numpy())]
    if known.size > FEW:
        axes.hist(known, bins="auto", color=BLUE, alpha=0.5)
        axes.set(xlabel=label(measured), ylabel="rods")
        axes.yaxis.get_major_locator().set_params(integer=True)
    else:
        axes.bar(known["rod"].to_numpy().astype(str), known, width=0.5, color=BLUE, alpha=0.5)
        axes.set(xlabel="rod", ylabel=label(measured), xlim=(-0.5, max(known.size, 1) - 0.5))
    if not known.size:
        axes.set_yticks([])
    if missing := measured.size - known.size:
        axes.set_title(f"none for {missing} of {measured.size} rods")


def classes(axes: Any, measured: xr.DataArray) -> None:
    """Number of rods in each class of motion."""
    names = [*CLASSES, "irregular", *([FAILED] if (measured == FAILED).any() else [])]
    axes.barh(names, [int((measured == name).sum()) for name in names], color=BLUE, alpha=0.5)
    axes.invert_yaxis()
    axes.set(xlabel="rods", ylabel=label(measured))
    axes.xaxis.get_major_locator().set_params(integer=True)


def settled(axes: Any, measured: xr.DataArray) -> None:
    """Fraction of rods that have settled against time; inf is not settled, and NaN, a failed rod, does not count."""
    known = np.sort(measured.to_numpy()[~np.isnan(measured.to_numpy())])
    finite = known[np.isfinite(known)]
    axes.step(np.append(0, finite), np.arange(len(finite) + 1) / max(len(known), 1), where="post", color=BLUE)
    axes.set(xlim=(0, None), ylim=(0, 1.02), xlabel=label(measured), ylabel="share of the rods")


def speed_distribution(axes: Any, measured: xr.DataArray) -> None:
    """Probability density against speed."""
    measured = measured.dropna("v")
    edges = bin_edges(measured["v"].to_numpy())
    axes.stairs(measured, edges, color=BLUE, fill=True, alpha=0.25)
    axes.stairs(measured, edges, color=BLUE)
    axes.set(xlim=(0, None), ylim=(0, None), xlabel=label(measured["v"]), ylabel=label(measured))


def curvature_histogram(axes: Any, measured: xr.Dataset) -> None:
    """Fractions of the filaments in the last frame, and of the area."""
    edges = np.append(measured["gauss_low"].to_numpy(), measured["gauss_high"].to_numpy()[-1])
    last = measured.isel(frame=-1)
    axes.stairs(last["gauss_share"], edges, color=BLUE, fill=True, alpha=0.5, label="filaments")
    axes.stairs(last["gauss_area_share"], edges, color="black", label="area of the membrane")
    axes.axvline(0, **GUIDE)
    units = measured["gauss_low"].attrs["units"]
    axes.set(xlabel=named("Gaussian curvature", units), ylabel="share", title=f"at t = {float(last['time']):.4g}")
    axes.legend()


def peaks(axes: Any, measured: xr.Dataset) -> None:
    """Height of the largest peak against its time."""
    axes.semilogy(measured["peak_time"], measured["peak_ratio"], "o", color=BLUE)
    axes.set(xlabel=label(measured["peak_time"]), ylabel=label(measured["peak_ratio"]))

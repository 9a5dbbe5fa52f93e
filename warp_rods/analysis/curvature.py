"""Where filaments gather: Gaussian curvature at their midpoints, compared with that of the whole membrane."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from warp_rods.analysis.bootstrap import bootstrap
from warp_rods.analysis.described import attributes, need, units_of
from warp_rods.membranes.mesh import area_below, area_mean, curvatures, triangulate
from warp_rods.membranes.surfaces import Surface

FLAT = 1e-9
"""A 𝒦 below this fraction of the largest squared principal curvature counts as zero."""
SOURCE = "K11 K22 − K12²"


def curvature_histogram(data: xr.Dataset, surface: Surface, bins: int | Sequence[float] = 21) -> xr.Dataset:
    """Histogram of 𝒦 at the midpoints, and over the area (frame, bin).

    ``gauss_share(frame, bin)`` of the filaments and ``gauss_area_share(bin)`` of the area, in bins from
    ``gauss_low(bin)`` to ``gauss_high(bin)``; and the means ``gauss_mean(frame)`` and ``gauss_area_mean``. ``bins``:
    their number, over all curvatures that occur, or their edges (1/length²). The shares sum to less than one where
    values lie outside the edges. Failed rods are left out. Raises ValueError for a moving membrane: give
    ``surface.at(t)``.
    """
    need(data, "gauss", "status")
    _refuse_moving(surface)
    mesh = triangulate(surface)
    over_area, sampled = curvatures(surface, mesh.points).gaussian, _gauss(data)
    edges = _edges(np.concatenate([over_area, sampled.values[np.isfinite(sampled.values)]]), bins)
    counts = np.array([np.histogram(now[np.isfinite(now)], edges)[0] for now in sampled.values])
    whole = np.isfinite(sampled.values).sum(axis=1, keepdims=True)
    shares = np.divide(counts, whole, out=np.full(counts.shape, np.nan), where=whole > 0)
    area = np.diff(area_below(mesh, over_area, edges))
    units, source = units_of(data, "1/length^2"), "midpoints in a bin over all; area in a bin over all"
    variables = {
        "gauss_share": (("frame", "bin"), shares, attributes("1", "share of the filaments", source)),
        "gauss_area_share": ("bin", area, attributes("1", "share of the area", source)),
        "gauss_mean": sampled.mean("rod").assign_attrs(attributes(units, "mean 𝒦 at the midpoints", SOURCE)),
        "gauss_area_mean": ((), area_mean(mesh, over_area), attributes(units, "mean 𝒦 of the area", SOURCE)),
    }
    limits = {"gauss_low": edges[:-1], "gauss_high": edges[1:]}
    ends = {name: ("bin", at, attributes(units, "Gaussian curvature 𝒦", SOURCE)) for name, at in limits.items()}
    return xr.Dataset(variables, coords={"time": data.time, **ends})


def enrichment(data: xr.Dataset, surface: Surface) -> xr.Dataset:
    """Density at 𝒦 > 0 and at 𝒦 < 0 relative to a uniform one (frame, side).

    ``enrichment(frame, side)`` is the share of the midpoints on a side divided by the share of the area there,
    ``area_share(side)``; NaN where that is zero. ``enrichment_low`` and ``enrichment_high`` are the bounds of its
    bootstrap interval, which has zero width where all filaments are on one side. Failed rods are left out. Raises
    ValueError for a moving membrane: give ``surface.at(t)``.
    """
    need(data, "gauss", "status")
    _refuse_moving(surface)
    mesh = triangulate(surface)
    over_area, gauss = curvatures(surface, mesh.points), _gauss(data)
    zero = FLAT * float(np.max(over_area.principal**2))
    below, above = area_below(mesh, over_area.gaussian, np.array([-zero, zero]))
    sides = {"side": ["positive", "negative"]}
    area = xr.DataArray([1 - above, below], sides, attrs=attributes("1", "share of the area", "area of a side"))
    there = xr.concat([gauss > zero, gauss < -zero], area.side).where(gauss.notnull())
    found = bootstrap(there / area.where(area > 0), np.nanmean)
    labels = {"value": "", "low": ", lower bound", "high": ", upper bound"}
    names = {"value": "enrichment", "low": "enrichment_low", "high": "enrichment_high"}
    for key, label in labels.items():
        long_name = f"density of filaments relative to a uniform one{label}"
        found[key].attrs = attributes("1", long_name, "share of the midpoints over share of the area")
    return found.rename(names).transpose("frame", "side").assign(area_share=area)


def _refuse_moving(surface: Surface) -> None:
    """Raises ValueError for a moving membrane, whose area is different in each frame."""
    if surface.moving:
        raise ValueError("this membrane moves: give surface.at(t), and the frame at that time")


def _gauss(data: xr.Dataset) -> xr.DataArray:
    """𝒦 at the midpoints [frame, rod], NaN for failed rods."""
    return data.gauss.where(data.status.isel(frame=-1, drop=True) == 0)


def _edges(gauss: np.ndarray, bins: int | Sequence[float]) -> np.ndarray:
    """Edges of bins that contain all values; a 𝒦 that is constant up to round-off lies in the middle bin."""
    low, high = gauss.min(), gauss.max()
    slack = 1e-6 * max(abs(low), abs(high))
    return np.histogram_bin_edges(gauss, bins, (low - slack, high + slack))

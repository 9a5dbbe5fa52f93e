"""Moving curves in a USD stage: the rods of an ensemble, and functions for all sets of curves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.draw.usd.materials import energy_colours
from warp_rods.progress import with_progress

_SAMPLED_FRAMES = 100
"""Largest number of frames from which a range of values is estimated."""
_READ_AT_ONCE = 16e6
"""Bytes."""


def draw_rods(
    stage: Any,
    name: str,
    data: xr.Dataset,
    radius: float,
    colour_range: tuple[float, float],
    material: Any,
    displayed: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """Draw one ensemble as curves at every frame; returns the box [2, 3] that holds them at all times.

    colour_range: energy densities at both ends of the colour map. displayed: maps positions [rod, node, 3] to those
    that are drawn.
    """
    from pxr import Tf, UsdGeom, Vt

    rods, nodes = data.sizes["rod"], data.sizes["node"]
    path = f"/World/Ensembles/{Tf.MakeValidIdentifier(name)}"
    curves = linear_curves(stage, path, np.full(rods, nodes), material)
    curves.CreateWidthsAttr([2 * radius])
    curves.SetWidthsInterpolation(UsdGeom.Tokens.constant)
    colour = curves.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
    boxes, points = [], np.zeros((rods, nodes, 3), np.float32)
    steps = with_progress(range(data.sizes["frame"]), f"USD: {name}")
    for frame, (place, density) in zip(steps, frames_of(data, "position", "energy_density"), strict=True):
        position = displayed(place)
        valid = np.isfinite(position).all(axis=(1, 2), keepdims=True)
        points = np.where(valid, position, points).astype(np.float32)  # a failed rod stays at its last position
        boxes.append(set_points(curves, frame, points.reshape(-1, 3), radius))
        rgb = energy_colours(np.nan_to_num(density), *colour_range)
        colour.Set(Vt.Vec3fArray.FromNumpy(rgb.reshape(-1, 3)), frame)
    return np.stack([np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]])


def linear_curves(stage: Any, path: str, counts: np.ndarray, material: Any) -> Any:
    """Linear curves with these numbers of points and a material; points, extent and widths are still to be set."""
    from pxr import UsdGeom, Vt

    curves = UsdGeom.BasisCurves.Define(stage, path)
    curves.CreateTypeAttr(UsdGeom.Tokens.linear)
    curves.CreateWrapAttr(UsdGeom.Tokens.nonperiodic)
    curves.CreateCurveVertexCountsAttr(Vt.IntArray.FromNumpy(counts.astype(np.int32)))
    bind(curves, material)
    return curves


def set_points(curves: Any, frame: int | None, points: np.ndarray, radius: float) -> np.ndarray:
    """Set the points [n, 3] of curves of at most this radius, at a frame or for all times; returns their extent."""
    from pxr import Usd, Vt

    when = Usd.TimeCode.Default() if frame is None else frame
    box = np.stack([points.min(axis=0) - radius, points.max(axis=0) + radius])
    curves.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)), when)
    curves.CreateExtentAttr().Set(Vt.Vec3fArray.FromNumpy(box.astype(np.float32)), when)
    return box


def bind(prim: Any, material: Any) -> None:
    """Assign a material to a prim."""
    from pxr import UsdShade

    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(material)


def frames_of(data: xr.Dataset, *names: str) -> Iterator[tuple[np.ndarray, ...]]:
    """These variables at each frame. Many frames are read at once: a read of Zarr costs milliseconds."""
    each = sum(data[name].nbytes for name in names) / data.sizes["frame"]
    block = max(1, int(_READ_AT_ONCE / each))
    for start in range(0, data.sizes["frame"], block):
        part = data[list(names)].isel(frame=slice(start, start + block))
        yield from zip(*(part[name].values for name in names), strict=True)


def sampled(values: xr.DataArray) -> xr.DataArray:
    """A variable at a limited number of evenly spaced frames, to estimate the range of its values."""
    return values.isel(frame=slice(None, None, -(-values.sizes["frame"] // _SAMPLED_FRAMES)))

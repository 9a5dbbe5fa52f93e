"""Curves that move in a USD stage: the rods of an ensemble, and what all sets of curves have in common."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.draw.usd.look import energy_colours
from warp_rods.progress import with_progress

_SAMPLED_FRAMES = 100


def draw_rods(
    stage: Any,
    name: str,
    data: xr.Dataset,
    radius: float,
    colours: tuple[float, float],
    look: Any,
    seen: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """One ensemble as curves, every frame; returns the box [2, 3] that holds them all the time.

    seen: where positions [rod, node, 3] are drawn.
    """
    from pxr import Tf, UsdGeom, Vt

    rods, nodes = data.sizes["rod"], data.sizes["node"]
    path = f"/World/Ensembles/{Tf.MakeValidIdentifier(name)}"
    curves = linear_curves(stage, path, np.full(rods, nodes), look)
    curves.CreateWidthsAttr([2 * radius])
    curves.SetWidthsInterpolation(UsdGeom.Tokens.constant)
    colour = curves.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
    boxes, points = [], np.zeros((rods, nodes, 3), np.float32)
    for frame in with_progress(range(data.sizes["frame"]), f"USD: {name}"):
        now = data.isel(frame=frame)
        position, density = seen(now.position.values), now.energy_density.values
        sound = np.isfinite(position).all(axis=(1, 2), keepdims=True)
        points = np.where(sound, position, points).astype(np.float32)  # a failed rod stays where it was
        boxes.append(set_points(curves, frame, points.reshape(-1, 3), radius))
        rgb = energy_colours(np.nan_to_num(density), *colours)
        colour.Set(Vt.Vec3fArray.FromNumpy(rgb.reshape(-1, 3)), frame)
    return np.stack([np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]])


def linear_curves(stage: Any, path: str, counts: np.ndarray, look: Any) -> Any:
    """Linear curves of so many points each, with a material; points, extent and widths are to be set."""
    from pxr import UsdGeom, Vt

    curves = UsdGeom.BasisCurves.Define(stage, path)
    curves.CreateTypeAttr(UsdGeom.Tokens.linear)
    curves.CreateWrapAttr(UsdGeom.Tokens.nonperiodic)
    curves.CreateCurveVertexCountsAttr(Vt.IntArray.FromNumpy(counts.astype(np.int32)))
    bind(curves, look)
    return curves


def set_points(curves: Any, frame: int | None, points: np.ndarray, radius: float) -> np.ndarray:
    """Sets the points [n, 3] of curves no thicker than ``radius`` at a frame, or for good; returns their extent."""
    from pxr import Usd, Vt

    when = Usd.TimeCode.Default() if frame is None else frame
    box = np.stack([points.min(axis=0) - radius, points.max(axis=0) + radius])
    curves.CreatePointsAttr().Set(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)), when)
    curves.CreateExtentAttr().Set(Vt.Vec3fArray.FromNumpy(box.astype(np.float32)), when)
    return box


def bind(prim: Any, look: Any) -> None:
    """Gives a prim its material."""
    from pxr import UsdShade

    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(look)


def sampled(values: xr.DataArray) -> xr.DataArray:
    """A variable at evenly spread frames, not many: enough for a range that holds for the whole run."""
    return values.isel(frame=slice(None, None, -(-values.sizes["frame"] // _SAMPLED_FRAMES)))

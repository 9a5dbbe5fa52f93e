"""Moving curves in a USD stage: the rods of an ensemble, and functions for all sets of curves."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw.content import Content
from warp_rods.draw.rods import Rods
from warp_rods.draw.scale import linear
from warp_rods.progress import with_progress


def draw_rods(stage: Any, rods: Rods, shown: Content, frames: range, material: Any) -> np.ndarray:
    """Draw one ensemble as curves at these frames; returns the boxes [n, 2, 3] that hold them."""
    from pxr import UsdGeom, Vt

    curves = linear_curves(stage, path_of(rods.name), np.full(rods.count, rods.nodes), material)
    curves.CreateWidthsAttr([2 * rods.radius])
    curves.SetWidthsInterpolation(UsdGeom.Tokens.constant)
    colour = curves.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
    boxes = []
    for frame in with_progress(frames, f"USD: {rods.name}"):
        points = rods.positions(frame).astype(np.float32)
        boxes.append(set_points(curves, frame, points.reshape(-1, 3), rods.radius))
        rgb = linear(shown.scale(frame).rgb(rods.values(frame))).astype(np.float32)
        colour.Set(Vt.Vec3fArray.FromNumpy(rgb.reshape(-1, 3)), frame)
    return np.array(boxes).reshape(-1, 2, 3)


def path_of(ensemble: str) -> str:
    """Where the rods of an ensemble are in a stage."""
    from pxr import Tf

    return f"/World/Ensembles/{Tf.MakeValidIdentifier(ensemble)}"


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

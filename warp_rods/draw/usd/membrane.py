"""The membrane in a USD stage: a mesh with its curvatures, with points at every frame where it moves."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw.scale import linear
from warp_rods.draw.sheet import CURVED, PALE, Sheet, curvature_colours
from warp_rods.draw.usd.curves import bind
from warp_rods.membranes.mesh import Curvatures, Mesh
from warp_rods.progress import with_progress

_SIGN = "of −∇n with n outward: a sphere of radius R has −1/R"


def draw_membrane(
    stage: Any, sheet: Sheet, frames: range, material: Any, path: str = "/World/Membrane", opacity: float = 0.0
) -> np.ndarray:
    """Draw the mesh of a surface, at all ``frames`` where it moves; returns its points, or its extreme points.

    With an ``opacity`` it has colours, those of its Gaussian curvature on posters, unless that hardly varies.
    """
    from pxr import UsdGeom, Vt

    mesh = sheet.mesh(frames.start)
    prim = UsdGeom.Mesh.Define(stage, path)
    prim.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    prim.CreateDoubleSidedAttr(True)
    prim.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(mesh.triangles), 3, np.int32)))
    prim.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(mesh.triangles.ravel().astype(np.int32)))
    prim.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    bind(prim, material)
    coloured = bool(opacity and sheet.curvature)
    if coloured:
        prim.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
        prim.CreateDisplayOpacityPrimvar(UsdGeom.Tokens.constant).Set([opacity])
        ends = {"low": -sheet.curvature, "high": sheet.curvature, "map": CURVED, "white": PALE}
        prim.GetPrim().SetCustomDataByKey("colour", {"name": "gaussianCurvature"} | ends)
    if not sheet.moving:
        _set(prim, mesh, sheet.curvatures(0))
        if coloured:
            _set_colours(prim, sheet, 0)
        return mesh.points
    boxes = []
    for frame in with_progress(frames, "USD: membrane"):
        mesh = sheet.mesh(frame)
        _set(prim, mesh, sheet.curvatures(frame), frame)
        if coloured:
            _set_colours(prim, sheet, frame, frame)
        boxes += [mesh.points.min(axis=0), mesh.points.max(axis=0)]
    return np.array(boxes).reshape(-1, 3)


def _set(prim: Any, mesh: Mesh, found: Curvatures, *frame: int) -> None:
    """Set points, normals, extent and curvatures, at a frame or for all times."""
    from pxr import Vt

    extent = np.stack([mesh.points.min(axis=0), mesh.points.max(axis=0)])
    rows = ((prim.CreatePointsAttr(), mesh.points), (prim.CreateNormalsAttr(), mesh.normals))
    for attribute, values in (*rows, (prim.CreateExtentAttr(), extent)):
        attribute.Set(Vt.Vec3fArray.FromNumpy(values.astype(np.float32)), *frame)
    _set_curvatures(prim, found, *frame)


def _set_colours(prim: Any, sheet: Sheet, frame: int, *when: int) -> None:
    """Set the colours of the curvature at a frame."""
    from pxr import Vt

    rgb = linear(curvature_colours(sheet.ratio(frame))).astype(np.float32)
    prim.GetDisplayColorAttr().Set(Vt.Vec3fArray.FromNumpy(rgb), *when)


def _set_curvatures(prim: Any, found: Curvatures, *frame: int) -> None:
    """Set the curvatures of the membrane at each point of its mesh."""
    from pxr import Sdf, UsdGeom, Vt

    kinds, both = Sdf.ValueTypeNames, found.principal
    rows = (
        ("principalCurvatures", kinds.Float2Array, Vt.Vec2fArray, both, f"1/length, {_SIGN}; ascending"),
        ("gaussianCurvature", kinds.FloatArray, Vt.FloatArray, found.gaussian, "1/length^2, their product"),
        ("meanCurvature", kinds.FloatArray, Vt.FloatArray, found.mean, f"1/length, H = −∇·n/2, {_SIGN}"),
    )
    for name, kind, array, values, documentation in rows:
        primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, kind, UsdGeom.Tokens.vertex)
        primvar.Set(array.FromNumpy(values.astype(np.float32)), *frame)
        primvar.GetAttr().SetDocumentation(documentation)

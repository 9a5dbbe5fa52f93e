"""Rods as meshes in a USD stage, for viewers that do not draw curves."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw.content import Content
from warp_rods.draw.rods import Rods
from warp_rods.draw.scale import linear
from warp_rods.draw.tube_mesh import tube_faces, tube_points
from warp_rods.draw.usd.curves import bind, path_of, set_points
from warp_rods.progress import with_progress

SIDES = 8
"""Sides of a tube: a node takes as many points."""


def draw_tubes(stage: Any, rods: Rods, shown: Content, frames: range, material: Any) -> np.ndarray:
    """Draw one ensemble as tubes at these frames; returns the boxes [n, 2, 3] that hold them."""
    from pxr import UsdGeom, Vt

    mesh = UsdGeom.Mesh.Define(stage, path_of(rods.name))
    rings = tube_points(np.zeros((1, rods.nodes, 3)), 1.0, SIDES)[0].shape[1]
    corners, counts = tube_faces(rods.count, rings, SIDES)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(counts))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    bind(mesh, material)
    colour = mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
    boxes = []
    for frame in with_progress(frames, f"USD: {rods.name}"):
        points, normals, nodes = tube_points(rods.positions(frame), rods.radius, SIDES)
        boxes.append(set_points(mesh, frame, points.reshape(-1, 3), 0.0))
        mesh.CreateNormalsAttr().Set(Vt.Vec3fArray.FromNumpy(normals.reshape(-1, 3).astype(np.float32)), frame)
        rgb = linear(shown.scale(frame).rgb(rods.values(frame)))[:, nodes]
        every = np.repeat(rgb[:, :, None], SIDES, axis=2).reshape(-1, 3).astype(np.float32)
        colour.Set(Vt.Vec3fArray.FromNumpy(every), frame)
    return np.array(boxes).reshape(-1, 2, 3)

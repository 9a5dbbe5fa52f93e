"""A membrane as triangles, for drawing: marching cubes, then Newton steps onto φ = 0."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import warp as wp

from .surfaces import Surface


class Mesh(NamedTuple):
    """Points [v, 3] on the surface, their outward normals [v, 3], triangles [t, 3] wound to face outwards."""

    points: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray


def triangulate(surface: Surface, cells: int = 96) -> Mesh:
    """The part of a surface inside its box, with ``cells`` cubes along the longest edge of the box."""
    from warp.geometry import IsoSurfaceMarchingCubes

    low, high = surface.box
    spacing = (high - low).max() / cells
    sizes = np.ceil((high - low) / spacing).astype(int) + 1
    axes = [np.linspace(a, b, n) for a, b, n in zip(low, high, sizes, strict=True)]
    phi = surface.phi(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1))
    field: Any = wp.array(phi, dtype=wp.float32, device="cpu")
    vertices, indices = IsoSurfaceMarchingCubes.extract(field, 0.0, lower=wp.vec3(*low), upper=wp.vec3(*high))
    # The rim of an open surface stays on the box.
    points = np.clip(surface.project(vertices.numpy().astype(float)), low, high)
    normals = surface.normal(points)
    return Mesh(points, normals, _outward(points, normals, indices.numpy().reshape(-1, 3)))


def _outward(points: np.ndarray, normals: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The triangles that are not degenerate, wound so that they face along the normals."""
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    facing = np.sum(np.cross(b - a, c - a) * normals[triangles].mean(axis=1), axis=-1)
    longest = np.max([np.sum((u - v) ** 2, axis=-1) for u, v in ((a, b), (b, c), (c, a))], axis=0)
    inward = facing < 0
    triangles = np.where(inward[:, None], triangles[:, ::-1], triangles)
    return triangles[np.abs(facing) > 1e-6 * longest]

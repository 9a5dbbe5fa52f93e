"""Triangulation of a membrane (marching cubes, then Newton steps onto φ = 0), its curvatures and its area."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warp_rods.device import exclusive
from warp_rods.membranes.surface import Surface


class Mesh(NamedTuple):
    """Points [v, 3] on the surface, their outward normals [v, 3], triangles [t, 3] oriented outwards."""

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
    with exclusive:
        field: Any = wp.array(phi, dtype=wp.float32, device="cpu")
        vertices, indices = IsoSurfaceMarchingCubes.extract(field, 0.0, lower=wp.vec3(*low), upper=wp.vec3(*high))
    # The boundary of an open surface stays on the box.
    points = np.clip(surface.project(vertices.numpy().astype(float)), low, high)
    normals = surface.normal(points)
    return Mesh(points, normals, _outward(points, normals, indices.numpy().reshape(-1, 3)))


def follow(mesh: Mesh, surface: Surface) -> tuple[Mesh, int]:
    """A mesh projected onto a surface that has moved a little, and the number of points that could not follow.

    The triangles stay the same. A point that would have to move by more than a tenth of the box stays where it is.
    """
    low, high = surface.box
    size = float(np.linalg.norm(high - low))
    with np.errstate(all="ignore"):  # points that cannot follow may overflow
        points = surface.project(mesh.points)
        off = np.abs(surface.phi(points)) / np.linalg.norm(surface.gradient(points), axis=-1)
        lost = ~((off < 1e-6 * size) & (np.linalg.norm(points - mesh.points, axis=-1) < 0.1 * size))
        points = points if surface.closed else np.clip(points, low, high)  # the boundary stays on the box
        points = np.where(lost[:, None], mesh.points, points)
        normals = np.where(lost[:, None], mesh.normals, surface.normal(points))
    return Mesh(points, normals, mesh.triangles), int(lost.sum())


def _outward(points: np.ndarray, normals: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The triangles that are not degenerate, oriented along the normals."""
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    facing = np.sum(np.cross(b - a, c - a) * normals[triangles].mean(axis=1), axis=-1)
    longest = np.max([np.sum((u - v) ** 2, axis=-1) for u, v in ((a, b), (b, c), (c, a))], axis=0)
    inward = facing < 0
    triangles = np.where(inward[:, None], triangles[:, ::-1], triangles)
    return triangles[np.abs(facing) > 1e-6 * longest]


class Curvatures(NamedTuple):
    """Curvatures of a surface at points: eigenvalues of −∇n with n outward (5.16). A sphere has −1/R twice."""

    principal: np.ndarray
    """[..., 2], 1/length, ascending."""
    gaussian: np.ndarray
    """𝒦 [...], 1/length²."""
    mean: np.ndarray
    """H = −∇·n/2 [...], 1/length."""


def curvatures(surface: Surface, points: np.ndarray) -> Curvatures:
    """The curvatures of a surface at points [..., 3] on it."""
    K = surface.second_form(points)[2]
    K11, K12, K22 = K[..., 0, 0], K[..., 0, 1], K[..., 1, 1]
    mean, spread = (K11 + K22) / 2, np.hypot((K11 - K22) / 2, K12)
    return Curvatures(np.stack([mean - spread, mean + spread], axis=-1), K11 * K22 - K12**2, mean)


def area_mean(mesh: Mesh, values: np.ndarray) -> float:
    """Mean over the area of values [v] at the points of a mesh, interpolated linearly."""
    return float(np.average(values[mesh.triangles].mean(axis=1), weights=_areas(mesh)))


def area_below(mesh: Mesh, values: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """Fractions [n] of the area where values [v] at the points of a mesh, interpolated linearly, are below levels [n].

    Second order in the size of the triangles, as these are cut at the level; counting points would be first order.
    """
    a, b, c = np.sort(values[mesh.triangles], axis=1).T
    areas, shares = _areas(mesh), []
    for level in levels:
        with np.errstate(divide="ignore", invalid="ignore"):  # results of divisions by zero are not selected
            low, high = (level - a) ** 2 / ((b - a) * (c - a)), 1 - (c - level) ** 2 / ((c - b) * (c - a))
        below = np.select([level <= a, level >= c, level < b], [0.0, 1.0, low], high)
        shares.append(np.average(below, weights=areas))
    return np.array(shares)


def _areas(mesh: Mesh) -> np.ndarray:
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=-1) / 2

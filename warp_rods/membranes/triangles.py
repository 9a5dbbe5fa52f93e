"""Closed surfaces of triangles: volume, area, finest part, distances to them; triangles of φ = 0 on a grid."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_rods.device import exclusive, start
from warp_rods.kernels.surface import mesh_distance

__all__ = ["Triangles", "iso_surface"]

FACING = 0.7
"""Two sheets are opposite where the cosine between their normals is below minus this."""
REACH = 4.0
"""Length of rays, in units of the largest extent."""


class Triangles:
    """Triangles [t, 3] between points [v, 3] that form closed surfaces, facing outwards."""

    def __init__(self, points: np.ndarray, faces: np.ndarray):
        self.points, self.faces = np.asarray(points, dtype=float), np.asarray(faces, dtype=np.int32)
        self.low, self.high = self.points.min(axis=0), self.points.max(axis=0)
        self.size = float((self.high - self.low).max())
        self._mesh: Any = None

    def corners(self) -> np.ndarray:
        """Corners [3, t, 3] of the triangles."""
        return np.moveaxis(self.points[self.faces], 1, 0)

    def normals(self) -> np.ndarray:
        """Normals [t, 3], twice as long as the areas of the triangles."""
        a, b, c = self.corners()
        return np.cross(b - a, c - a)

    def areas(self) -> np.ndarray:
        """Areas [t]."""
        return np.linalg.norm(self.normals(), axis=-1) / 2

    def volumes(self) -> np.ndarray:
        """Volumes [t] between the triangles and the middle of the box; their sum is the enclosed volume."""
        a, b, c = self.corners() - (self.low + self.high) / 2
        return np.sum(a * np.cross(b, c), axis=-1) / 6

    def pieces(self) -> np.ndarray:
        """The number of the connected piece of each point [v]."""
        from scipy import sparse

        links = np.concatenate([self.faces[:, [0, 1]], self.faces[:, [1, 2]]])
        graph = sparse.coo_matrix((np.ones(len(links), dtype=bool), links.T), shape=(len(self.points),) * 2)
        return sparse.csgraph.connected_components(graph, directed=False)[1]

    def facets(self) -> float:
        """The distance between the folds that make up most of the curvature: nine tenths of it is in closer ones."""
        sides = np.sort(self.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=-1)
        order = np.lexsort(sides.T)
        pairs = (order // 3).reshape(-1, 2)  # each edge has two triangles
        edge = self.points[sides[order[::2], 0]] - self.points[sides[order[::2], 1]]
        length = np.linalg.norm(edge, axis=-1)
        normals = self.normals()
        area = np.linalg.norm(normals, axis=-1)
        n = _unit(normals)
        fold = length * np.arccos(np.clip(np.sum(n[pairs[:, 0]] * n[pairs[:, 1]], axis=-1), -1, 1))
        height = area[pairs].mean(axis=-1) / np.maximum(length, np.finfo(float).tiny)
        by_height = np.argsort(height)
        share = np.cumsum(fold[by_height])
        return float(height[by_height][np.searchsorted(share, 0.9 * share[-1])]) if share[-1] > 0 else 0.0

    # --- distances, in single precision, hence in units of the size ---------------------------------------------------

    def _scaled(self, x: np.ndarray) -> Any:
        return wp.array((x - (self.low + self.high) / 2) / self.size, dtype=wp.vec3, device="cpu")

    def _query(self, kernel: Any, count: int, *inputs: Any) -> np.ndarray:
        found: Any = wp.zeros(count, dtype=wp.float64, device="cpu")
        wp.launch(kernel, dim=count, inputs=[self._mesh.id, *inputs, found], device="cpu")
        return self.size * found.numpy()

    def _prepare(self) -> None:
        start()
        if self._mesh is None:
            indices: Any = wp.array(self.faces.ravel(), dtype=wp.int32, device="cpu")
            self._mesh = wp.Mesh(points=self._scaled(self.points), indices=indices, support_winding_number=True)

    def distance(self, x: np.ndarray, signed: bool = False) -> np.ndarray:
        """Distances [n] of points [n, 3]; with a sign negative inside, which takes ten times as long."""
        with exclusive:
            self._prepare()
            reach = REACH + float(np.abs(x - self.low).max(initial=0)) / self.size
            kernel = mesh_distance.signed_distance if signed else mesh_distance.distance
            return self._query(kernel, len(x), reach, self._scaled(x))

    def opposite(self, rounds: int, outside: bool = False, box: tuple[np.ndarray, np.ndarray] | None = None) -> float:
        """The smallest distance to an opposite sheet: inwards the finest part, outwards the narrowest gap.

        Infinite where there is none. Rays start at the middles of the triangles inside the box, along normals averaged
        ``rounds`` times over neighbours, as the normals of slivers and of steps between voxels are arbitrary.
        """
        middles, n = self.corners().mean(axis=0), self.averaged_normals(rounds)
        if box:
            kept = ((middles > box[0]) & (middles < box[1])).all(axis=-1)
            middles, n = middles[kept], n[kept]
        with exclusive:
            self._prepare()
            normals: Any = wp.array(n, dtype=wp.vec3, device="cpu")
            rays = (1.0 if outside else -1.0, FACING, self._scaled(middles), normals)
            found = self._query(mesh_distance.opposite, len(n), REACH, *rays)
        nearest = float(found.min(initial=np.inf))
        return nearest if nearest < 0.99 * REACH * self.size else np.inf

    def averaged_normals(self, rounds: int) -> np.ndarray:
        """Unit normals [t, 3]; each round averages them over the triangles at each point, weighted by area."""
        normals, area = self.normals(), 2 * self.areas()[:, None]
        for _ in range(rounds):
            normals = area * _unit(self._at_points(normals)[self.faces].sum(axis=1))
        return _unit(normals)

    def normals_at_points(self) -> np.ndarray:
        """Unit normals [v, 3], averaged over the triangles at each point, weighted by area."""
        return _unit(self._at_points(self.normals()))

    def _at_points(self, values: np.ndarray) -> np.ndarray:
        """Sums [v, 3] over the triangles at each point of values [t, 3]."""
        corners = self.faces.ravel()
        sums = [np.bincount(corners, np.repeat(v, 3), minlength=len(self.points)) for v in values.T]
        return np.stack(sums, axis=-1)


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), np.finfo(float).tiny)


def iso_surface(
    phi: np.ndarray, spacing: np.ndarray, first: np.ndarray, cubic: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Points [v, 3] and triangles [t, 3] of φ = 0 on a grid [x, y, z], closed at the ends of the grid.

    The points are on edges of the grid, at zeros of the cubic through four nodes, or of the line through two.
    """
    from warp.geometry import IsoSurfaceMarchingCubes

    around = np.pad(phi, 1, constant_values=float(phi.max()))
    start()
    with exclusive:
        field: Any = wp.array(around, dtype=wp.float32, device="cpu")
        vertices, indices = IsoSurfaceMarchingCubes.extract(field, 0.0)
        points, faces = vertices.numpy().astype(float) - 1, indices.numpy().reshape(-1, 3)
    return first + (_refined(points, phi) if cubic else points) * spacing, faces


def _refined(points: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Points on edges of the grid, in units of its spacing, moved along the edge to the zero of a cubic."""
    axis = np.argmax(np.abs(points - np.round(points)), axis=-1)
    rows = np.arange(len(points))
    node = np.round(points).astype(int)
    node[rows, axis] = np.floor(points[rows, axis]).astype(int)
    within = (node[rows, axis] >= 1) & (node[rows, axis] + 2 < np.array(phi.shape)[axis])
    within &= ((node >= 0) & (node < phi.shape)).all(axis=-1)
    rows, node, axis = rows[within], node[within], axis[within]
    step = np.eye(3, dtype=int)[axis]
    a, b, c, d = (phi[tuple((node + k * step).T)] for k in (-1, 0, 1, 2))
    t = points[rows, axis] - node[np.arange(len(rows)), axis]
    # φ(t) = b + t (c1 + t (c2 + t c3)), the cubic through a, b, c, d at −1, 0, 1, 2
    c1, c2, c3 = c - b / 2 - a / 3 - d / 6, (a + c) / 2 - b, (d - a) / 6 + (b - c) / 2
    for _ in range(3):
        slope = c1 + t * (2 * c2 + 3 * t * c3)
        flat = np.abs(slope) < 0.1 * np.abs(c - b)
        t = np.clip(t - np.where(flat, 0, (b + t * (c1 + t * (c2 + t * c3)))) / np.where(flat, 1, slope), 0, 1)
    moved = points.copy()
    moved[rows, axis] = node[np.arange(len(rows)), axis] + t
    return moved

"""φ on a grid: the signed distance to the boundary of segmented voxels, or to a closed mesh."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from scipy import ndimage

from warp_rods.device import exclusive, start
from warp_rods.kernels.surface.mesh_distance import signed_distance
from warp_rods.membranes.files import FileError

__all__ = ["from_mesh", "from_voxels", "grid_around"]

VOXELS_SMOOTHED, EDGES_SMOOTHED = 4.0, 2.0
"""Widths, in grid spacings, of the Gaussians that smooth the steps of voxels and the edges of triangles."""
MARGIN = 8
"""Grid spacings between a mesh and the boundary of its grid."""


def from_voxels(inside: np.ndarray, spacing: np.ndarray) -> np.ndarray:
    """Smoothed signed distance [x, y, z] to the boundary of the voxels that are True, negative inside."""
    if inside.all() or not inside.any():
        raise FileError("has voxels that are all inside or all outside: there is no boundary")
    half = spacing.min() / 2  # the boundary is half way between the centres of voxels
    outer = ndimage.distance_transform_edt(~inside, sampling=spacing) - half
    inner = ndimage.distance_transform_edt(inside, sampling=spacing) - half
    return _smoothed(np.where(inside, -inner, outer), VOXELS_SMOOTHED)


def _smoothed(distance: np.ndarray, width: float) -> np.ndarray:
    """2Gφ − GGφ, as a single Gaussian G would move the membrane inwards by its mean curvature times width²."""
    once = ndimage.gaussian_filter(distance, width, mode="nearest")
    return 2 * once - ndimage.gaussian_filter(once, width, mode="nearest")


def grid_around(mesh: Any, spacing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First node [3] and numbers of nodes [3] of a grid around a mesh, centred on it, with a margin."""
    low, high = mesh.bounds
    count = np.ceil((high - low) / spacing).astype(int) + 1 + 2 * MARGIN
    return (low + high - (count - 1) * spacing) / 2, count


def from_mesh(mesh: Any, spacing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smoothed signed distance [x, y, z] on a grid around the mesh, negative inside; and its first node [3]."""
    first, count = grid_around(mesh, spacing)
    centre, size = first + (count - 1) * spacing / 2, float(np.max(count * spacing))
    axes = [np.arange(n) * h + a for n, h, a in zip(count, spacing, first, strict=True)]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    # Meshes of Warp are float32, hence coordinates are scaled to order one.
    distance = _signed_distance((mesh.vertices - centre) / size, mesh.faces, (x - centre) / size)
    return _smoothed(size * distance.reshape(count), EDGES_SMOOTHED), first


def _signed_distance(vertices: np.ndarray, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Signed distance [point] from points [point, 3] to a closed mesh in single precision, negative inside."""
    start()
    with exclusive:
        triangles: Any = wp.Mesh(
            points=wp.array(vertices, dtype=wp.vec3, device="cpu"),
            indices=wp.array(np.ravel(faces), dtype=wp.int32, device="cpu"),
            support_winding_number=True,
        )
        queried: Any = wp.array(points, dtype=wp.vec3, device="cpu")
        distance: Any = wp.zeros(len(points), dtype=wp.float64, device="cpu")
        wp.launch(signed_distance, dim=len(points), inputs=[triangles.id, 10.0, queried, distance], device="cpu")
        return distance.numpy()

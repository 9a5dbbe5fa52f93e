"""The surface of a file: a cubic spline through φ on a grid."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
from scipy import ndimage

from warp_rods.kernels.surface.spline import spline
from warp_rods.membranes import distance
from warp_rods.membranes.files import MESHES, MOST_NODES, FileError, read_array, read_mesh
from warp_rods.membranes.level_set import LevelSet

__all__ = ["PAD", "from_file", "interpolated"]

PAD = 8
"""Nodes added on each side by linear continuation of φ, so that effects of the ends of the spline are outside."""

Triple = tuple[float, float, float]


@functools.lru_cache(maxsize=4)
def from_file(path: Path, changed: int, spacing: Triple, origin: Triple) -> LevelSet:
    """The surface in a file last changed at the time ``changed``; raises FileError.

    spacing: between nodes. origin: the first node of an array, or the displacement of a mesh.
    """
    h = np.array(spacing)
    if path.suffix.lower() in MESHES:
        mesh = read_mesh(path)
        if (count := np.prod(distance.grid_around(mesh, h)[1], dtype=float)) > MOST_NODES:
            raise FileError(f"with spacing = {list(spacing)} needs {count:.2g} nodes; at most {MOST_NODES:.0g}")
        phi, first = distance.from_mesh(mesh, h)
        return interpolated(phi, h, first + origin)
    values = read_array(path)
    phi = values.astype(float) if values.dtype.kind == "f" else distance.from_voxels(values != 0, h)
    if not np.isfinite(phi).all():
        raise FileError("contains values that are not finite")
    return interpolated(phi, h, np.array(origin))


def interpolated(phi: np.ndarray, spacing: np.ndarray, origin: np.ndarray) -> LevelSet:
    """The surface of the cubic spline through φ [x, y, z] at nodes origin + (i, j, k) spacing."""
    grid = ndimage.spline_filter(np.pad(phi, PAD, mode="reflect", reflect_type="odd"), order=3, mode="mirror")
    numbers = np.concatenate([origin - PAD * spacing, spacing])
    box = (np.array(origin), origin + (np.array(phi.shape) - 1) * spacing)
    return LevelSet(spline, numbers, box, closed=None, grid=grid)

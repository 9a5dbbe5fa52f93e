"""Read arrays and meshes from files, and refuse those that do not define a surface."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["ARRAYS", "FEWEST_NODES", "KEPT", "MESHES", "MOST_NODES", "FileError", "read_array", "read_mesh"]

ARRAYS, MESHES = (".npy",), (".obj", ".stl", ".ply")
KEPT = ".npz"
"""The suffix of a sampled field that a run kept."""
FEWEST_NODES = 8
"""Smallest number of nodes along each axis of a grid for a spline."""
MOST_NODES = 2e7


class FileError(ValueError):
    """A file that defines no surface; the message follows the name of the file."""


def read_array(path: Path) -> np.ndarray:
    """The array [x, y, z] in a file, memory-mapped; raises FileError for an array of another form."""
    try:
        values = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, EOFError) as error:
        raise FileError(f"cannot be read as an array: {error}") from None
    fits = values.ndim == 3 and min(values.shape) >= FEWEST_NODES and values.size <= MOST_NODES
    if not fits or values.dtype.kind not in "biuf":
        raise FileError(
            f"has shape {values.shape} of {values.dtype}: must be [x, y, z] with at least {FEWEST_NODES} nodes along "
            f"each axis, {MOST_NODES:.0g} in all; floats (φ, negative inside), or true or labels inside and 0 outside"
        )
    return values


def read_mesh(path: Path) -> Any:
    """The triangles of an OBJ, STL or PLY file, facing outwards; raises FileError where they are not closed."""
    import trimesh

    try:
        mesh = trimesh.load_mesh(path)
    except Exception as error:  # each reader of trimesh raises its own
        raise FileError(f"cannot be read as a mesh: {error}") from None
    if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces):
        raise FileError("contains no triangles")
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    if not mesh.is_watertight:
        raise FileError("is not closed: some edges have a triangle on one side only")
    if not mesh.is_winding_consistent:
        raise FileError("has triangles that face inwards and others that face outwards")
    if mesh.volume < 0:
        mesh.invert()
    return mesh

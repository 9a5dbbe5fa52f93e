"""What the readers of files share: the kinds of files, their limits, and the error for a file without a surface."""

from __future__ import annotations

import numpy as np

__all__ = [
    "ARRAYS",
    "FEWEST_NODES",
    "IMAGES",
    "KEPT",
    "MESHES",
    "MOST_NODES",
    "FileError",
    "check_distance",
    "counted",
    "shown_point",
]

ARRAYS, MESHES = (".npy",), (".obj", ".stl", ".ply")
IMAGES = (".tif", ".tiff", ".nii", ".nii.gz")
KEPT = ".npz"
"""The suffix of a sampled field that a run kept."""
FEWEST_NODES = 8
"""Smallest number of nodes along each axis of a level set for a spline."""
MOST_NODES = 2e7
FARTHEST = 1e6
"""Largest distance from the origin in units of the size: beyond, digits of places are lost."""


class FileError(ValueError):
    """A file that defines no surface; the message follows the name of the file."""


def check_distance(size: float, farthest: float) -> None:
    """Raises FileError where a membrane of this size is too far from the origin for places on it to be exact."""
    if not farthest <= FARTHEST * size:
        raise FileError(
            f"has a size of {size:.3g} and coordinates up to {farthest:.3g}, more than {FARTHEST:g} sizes from the "
            f"origin: move it there"
        )


def counted(count: int, word: str) -> str:
    """The count with the word, in the plural where necessary."""
    return f"{count} {word}{'' if count == 1 else 's'}"


def shown_point(x: np.ndarray) -> str:
    """A point in a message."""
    return "(" + ", ".join(f"{value + 0.0:.4g}" for value in x) + ")"

"""Frames of rods at random and about z, in NumPy alone: the rotations of SciPy take half a second to import.

The bits are those of ``scipy.spatial.transform.Rotation``, ``random`` and ``from_euler``.
"""

from __future__ import annotations

import numpy as np

__all__ = ["about_z", "isotropic"]


def isotropic(count: int, rng: np.random.Generator) -> np.ndarray:
    """Random frames [count, 3, 3], uniform on SO(3): by quaternions uniform on their sphere."""
    quaternion = rng.normal(size=(count, 4))
    return _matrices(*(quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)).T)


def about_z(angle: np.ndarray) -> np.ndarray:
    """Frames [n, 3, 3] along x, rotated about z by angles [n]."""
    zero = np.zeros(len(angle))
    return _matrices(zero, zero, np.sin(angle / 2), np.cos(angle / 2))


def _matrices(x: np.ndarray, y: np.ndarray, z: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Matrices [n, 3, 3] of unit quaternions x i + y j + z k + w."""
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    xy, zw, xz, yw, yz, xw = x * y, z * w, x * z, y * w, y * z, x * w
    rows = [
        [xx - yy - zz + ww, 2 * (xy - zw), 2 * (xz + yw)],
        [2 * (xy + zw), -xx + yy - zz + ww, 2 * (yz - xw)],
        [2 * (xz - yw), 2 * (yz + xw), -xx - yy + zz + ww],
    ]
    return np.ascontiguousarray(np.moveaxis(np.array(rows), -1, 0))

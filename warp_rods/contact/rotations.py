"""Frames of rods at random and about z, in NumPy alone: the rotations of SciPy take half a second to import.

The bits are those of ``scipy.spatial.transform.Rotation``, ``random`` and ``from_euler``.
"""

from __future__ import annotations

import numpy as np

__all__ = ["about_z", "isotropic", "with_chords_along_x"]


def isotropic(count: int, rng: np.random.Generator) -> np.ndarray:
    """Random frames [count, 3, 3], uniform on SO(3): by quaternions uniform on their sphere."""
    quaternion = rng.normal(size=(count, 4))
    return _matrices(*(quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)).T)


def with_chords_along_x(chord: np.ndarray, width: float, rng: np.random.Generator) -> np.ndarray:
    """Random frames [n, 3, 3], uniform among those whose chords [n, 3] span at most ``width`` across x.

    The turned chord c is uniform on the part of its sphere with c_y² + c_z² ≤ width², and the roll about it is uniform.
    """
    length = np.linalg.norm(chord, axis=1)
    sine = np.minimum(width / np.maximum(length, np.finfo(float).tiny), 1.0)
    least = np.sqrt(1 - sine**2)  # of |cos| of the angle from x; 1 − least without cancellation
    along = rng.choice([-1.0, 1.0], len(chord)) * (1 - rng.uniform(size=len(chord)) * sine**2 / (1 + least))
    angle, across = rng.uniform(0, 2 * np.pi, len(chord)), np.sqrt(np.maximum(1 - along**2, 0.0))
    aim = np.stack([along, across * np.cos(angle), across * np.sin(angle)], axis=-1)
    # A roll about the aim, after the half turn about the middle between chord and aim, which exchanges them.
    own = np.where(length[:, None] > 0, chord / np.maximum(length, np.finfo(float).tiny)[:, None], aim)
    middle = own + aim
    opposite = np.linalg.norm(middle, axis=1) < 1e-6
    middle[opposite] = np.cross(aim[opposite], np.eye(3)[np.abs(aim[opposite]).argmin(axis=1)])
    half_turns = _about(middle, np.full(len(chord), np.pi))
    return _about(aim, rng.uniform(0, 2 * np.pi, len(chord))) @ half_turns


def _about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotations [n, 3, 3] by angles [n] about axes [n, 3]."""
    x, y, z = (np.sin(angle / 2)[:, None] * axis / np.linalg.norm(axis, axis=1, keepdims=True)).T
    return _matrices(x, y, z, np.cos(angle / 2))


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

"""Frenet, Bishop and material strains of a rod, and how they turn into each other (3.49) to (3.61).

A strain Ω [..., node, 3], 1/length, is that of a frame whose first director is the tangent: Ω[0] twist, Ω[1] and Ω[2]
bending about the second and third director. Of the Frenet frame (T, N, B) it is (τ, 0, κ), of a Bishop frame Ω[0] = 0.
Indices count from 0 (the dissertation's from 1). Slopes along s are central differences, second order.
"""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from warp_rods import arguments
from warp_rods.frames import checks
from warp_rods.frames.rotations import rotation_exp

STRAIGHT = 8 * float(np.finfo(float).eps)
"""Curvature, times the length or relative to the largest one, that counts as zero."""


class FrenetStrain(NamedTuple):
    """Curvature κ ≥ 0 and torsion τ of the centre line, 1/length, and the angle θ of the frame against Frenet's."""

    curvature: np.ndarray
    torsion: np.ndarray
    angle: np.ndarray


def turned(R: ArrayLike, angle: ArrayLike) -> np.ndarray:
    """The frame R e^{θ ê0} [..., 3, 3], turned by the angle θ [...] about its tangent (3.52)."""
    R, angle = checks.rotations("R", R), checks.finite("angle", angle)
    return R @ rotation_exp(angle[..., None] * np.eye(3)[0])


def angle_between(R: ArrayLike, Q: ArrayLike) -> np.ndarray:
    """θ [..., node] of Q = R e^{θ ê0}: by what frames R [..., node, 3, 3] are turned about their tangent to become Q.

    Continuous along the nodes where it changes by less than π a node. Raises SceneError where tangents differ.
    """
    R, Q = checks.nodal_rotations("R", R, 1), checks.nodal_rotations("Q", Q, 1)
    between = np.swapaxes(R, -1, -2) @ Q
    apart = np.abs(between[..., 0, 0] - 1) > checks.ORTHONORMAL
    if apart.any():
        raise checks.SceneError(f"Q{checks.place(checks.first(apart))}: must have the tangent of R, its first column")
    return np.unwrap(np.arctan2(between[..., 2, 1], between[..., 1, 1]), axis=-1)


def turned_strain(strain: ArrayLike, angle: ArrayLike, spacing: ArrayLike) -> np.ndarray:
    """The strain of the frame R e^{θ ê0}: Ω[0] + θ′, e^{−θ ê0} Ω⊥ [..., node, 3] (3.53), (3.54); θ [..., node].

    spacing: Δs, a number or one for each curve [...].
    """
    strain, angle = checks.nodal_vectors("strain", strain, 3), checks.nodal_numbers("angle", angle, 3)
    across = (strain[..., 1] + 1j * strain[..., 2]) * np.exp(-1j * angle)
    return _together(strain[..., 0] + slope(angle, spacing), across)


def bishop_strain(strain: ArrayLike, spacing: ArrayLike, start: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """The strain of the Bishop frame, with Ω[0] = 0 (3.61), and the angle of the given frame against it [..., node].

    The angle ϑ = ∫ Ω[0] ds is 0 at the node ``start``, where both frames agree; trapezoid rule.
    """
    strain = checks.nodal_vectors("strain", strain, 2)
    if arguments.whole("start", start, 0) >= strain.shape[-2]:
        raise arguments.wrong("start", start, f"a node, 0 to {strain.shape[-2] - 1}")
    twist = strain[..., 0]
    cells = checks.spacings(spacing, twist.shape[:-1]) * (twist[..., 1:] + twist[..., :-1]) / 2
    angle = np.concatenate([np.zeros((*twist.shape[:-1], 1)), np.cumsum(cells, axis=-1)], axis=-1)
    angle = angle - angle[..., [start]]
    return _together(np.zeros_like(twist), (strain[..., 1] + 1j * strain[..., 2]) * np.exp(1j * angle)), angle


def frenet_strain(strain: ArrayLike, spacing: ArrayLike) -> FrenetStrain:
    """κ = |Ω⊥|, τ = Ω[0] + e0·(Ω⊥ × Ω⊥′)/κ², and θ with Ω⊥ = κ (sin θ, cos θ), each [..., node] (3.58) to (3.60).

    Where κ vanishes, as at free ends, the Frenet frame and τ are undefined: τ and θ are NaN there, and a RuntimeWarning
    names the first such node. The Bishop frame is defined everywhere.
    """
    strain = checks.nodal_vectors("strain", strain, 3)
    across = strain[..., 1] + 1j * strain[..., 2]
    curvature = np.abs(across)
    length = checks.spacings(spacing, curvature.shape[:-1]) * (curvature.shape[-1] - 1)
    straight = curvature * length <= STRAIGHT * np.maximum(1.0, (curvature * length).max(axis=-1, keepdims=True))
    tell_straight("frenet_strain", straight, "torsion and angle")
    change = (across.conj() * slope(across, spacing)).imag  # e0·(Ω⊥ × Ω⊥′)
    torsion = strain[..., 0] + change / np.where(straight, np.nan, curvature**2)
    angle = np.where(straight, np.nan, np.arctan2(strain[..., 1], strain[..., 2]))
    return FrenetStrain(curvature, torsion, _unwrapped(angle))


def material_strain(curvature: ArrayLike, torsion: ArrayLike, angle: ArrayLike, spacing: ArrayLike) -> np.ndarray:
    """(τ + θ′, κ sin θ, κ cos θ) [..., node, 3] of κ, τ, θ, numbers or [..., node] (3.53), (3.54).

    The strain of the frame that is turned by θ from Frenet's about the tangent. At least one of them is [..., node].
    """
    given = [checks.finite(n, v) for n, v in (("curvature", curvature), ("torsion", torsion), ("angle", angle))]
    k, tau, theta = np.broadcast_arrays(*given)
    theta = checks.nodal_numbers("angle", theta, 3)
    return np.stack([tau + slope(theta, spacing), k * np.sin(theta), k * np.cos(theta)], axis=-1)


def frenet_of_frame(R: ArrayLike, strain: ArrayLike) -> np.ndarray:
    """The Frenet frame (T, N, B) [..., 3, 3] of a frame R [..., 3, 3] with strain Ω [..., 3] (3.55) to (3.57).

    N and B are NaN where the curvature is zero, with a RuntimeWarning.
    """
    R, strain = checks.rotations("R", R), checks.vectors("strain", strain)
    curvature = np.hypot(strain[..., 1], strain[..., 2])
    tell_straight("frenet_of_frame", curvature == 0, "normal and binormal")
    cosine, sine = (strain[..., i] / np.where(curvature == 0, np.nan, curvature) for i in (2, 1))
    normal = cosine[..., None] * R[..., 1] - sine[..., None] * R[..., 2]
    binormal = sine[..., None] * R[..., 1] + cosine[..., None] * R[..., 2]
    return np.stack([R[..., 0], normal, binormal], axis=-1)


def slope(values: np.ndarray, spacing: ArrayLike) -> np.ndarray:
    """∂/∂s along the nodes, the last axis; second order."""
    return np.gradient(values, axis=-1, edge_order=2) / checks.spacings(spacing, values.shape[:-1])


def tell_straight(name: str, straight: np.ndarray, what: str) -> None:
    """A RuntimeWarning where the curvature vanishes."""
    if straight.any():
        warnings.warn(
            f"{name}: the curvature is zero at {straight.sum()} nodes, first at {list(checks.first(straight))}: {what} "
            "are undefined there (NaN); a Bishop frame is defined everywhere",
            RuntimeWarning,
            stacklevel=3,
        )


def _together(twist: np.ndarray, across: np.ndarray) -> np.ndarray:
    return np.stack([twist, across.real, across.imag], axis=-1)


def _unwrapped(angle: np.ndarray) -> np.ndarray:
    """The angle, continuous along the nodes on each side of a NaN."""
    change = np.diff(angle, axis=-1)
    jumps = np.nan_to_num(-2 * np.pi * np.round(change / (2 * np.pi)))
    return angle + np.concatenate([np.zeros_like(angle[..., :1]), np.cumsum(jumps, axis=-1)], axis=-1)

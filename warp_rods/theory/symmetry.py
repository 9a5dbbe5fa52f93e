"""Gauge and parity of a rod with circular cross-section (appendix C.4).

Strains are in the material frame, index 0 twist; nodes are spaced evenly about the middle one, so their
number is odd. ``...`` stands for any leading axes: frames, rods.
"""

import numpy as np
from numpy.typing import ArrayLike


def gauge_strain(strain: ArrayLike, angle: ArrayLike) -> np.ndarray:
    """Strains [..., node, 3] after a change of gauge by ``angle`` θ [...]: Ω₀e₀ + e^(θê₀)Ω⊥ (C.43).

    Body-frame velocities and angular velocities transform the same way (C.45), (C.46).
    """
    return np.asarray(strain, dtype=np.float64) @ np.swapaxes(_about_tangent(angle), -1, -2)


def gauge_frame(rotation: ArrayLike, angle: ArrayLike) -> np.ndarray:
    """Frames R [..., node, 3, 3], columns the directors, after it: R e^(−θê₀), ``angle`` θ [...] (C.41)."""
    inverse = np.swapaxes(_about_tangent(angle), -1, -2)
    return np.asarray(rotation, dtype=np.float64) @ inverse[..., None, :, :]


def symmetric_gauge(strain: ArrayLike) -> np.ndarray:
    """Angle θ [...] of the gauge in which Ω₁ [..., node, 3] comes closest to odd and Ω₂ to even.

    Least squares over θ, determined up to multiples of π; ``gauge_strain(strain, θ)`` goes there.
    """
    strain = np.asarray(strain, dtype=np.float64)
    k = strain[..., 1] + 1j * strain[..., 2]
    even, odd = _parts(k)
    # In that gauge the even part of k is imaginary and the odd part real: the squares of both line up.
    return -0.5 * np.angle(np.sum(odd**2 - even**2, axis=-1))


def parity_residual(strain: ArrayLike, activity: ArrayLike) -> np.ndarray:
    """Largest violation [...] of (C.49): Ω₀, Ω₂ even, Ω₁ and f odd; zero for a state with that symmetry.

    ``strain`` [..., node, 3], ``activity`` f [..., node] (m = M f is odd with it). A state symmetric in
    another gauge passes after ``symmetric_gauge``.
    """
    strain = np.asarray(strain, dtype=np.float64)
    twist, bend1, bend2 = (_parts(strain[..., index]) for index in range(3))
    wrong = [twist[1], bend1[0], bend2[1], _parts(np.asarray(activity, dtype=np.float64))[0]]
    return np.max(np.broadcast_arrays(*(np.abs(part).max(axis=-1) for part in wrong)), axis=0)


def axis_residual(position: ArrayLike, axis: ArrayLike) -> np.ndarray:
    """Largest distance [...] of a node from the centre line turned by π about its middle (C.52).

    ``position`` [..., node, 3]; ``axis`` [..., 3], a unit vector: q₁ at the middle in the symmetric gauge.
    """
    position = np.asarray(position, dtype=np.float64)
    axis = np.asarray(axis, dtype=np.float64)[..., None, :]
    arm = position - position[..., [position.shape[-2] // 2], :]
    turned = 2.0 * axis * np.sum(axis * arm, axis=-1, keepdims=True) - arm
    return np.linalg.norm(arm[..., ::-1, :] - turned, axis=-1).max(axis=-1)


def _parts(field: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Even and odd parts along the last axis."""
    mirrored = field[..., ::-1]
    return 0.5 * (field + mirrored), 0.5 * (field - mirrored)


def _about_tangent(angle: ArrayLike) -> np.ndarray:
    """e^(θê₀): [..., 3, 3] for ``angle`` [...]."""
    c, s = np.cos(angle), np.sin(angle)
    rotation = np.zeros((*np.shape(angle), 3, 3))
    rotation[..., 0, 0] = 1.0
    rotation[..., 1, 1] = rotation[..., 2, 2] = c
    rotation[..., 1, 2], rotation[..., 2, 1] = -s, s
    return rotation

"""Gauge and parity of a rod with circular cross-section (appendix C.4).

Strains are in the material frame, component 0 is twist. Nodes are equally spaced and their number is odd. ``...``
stands for any leading axes, such as frames and rods.
"""

import numpy as np
from numpy.typing import ArrayLike


def gauge_strain(strain: ArrayLike, angle: ArrayLike) -> np.ndarray:
    """Strains [..., node, 3] after a change of gauge by ``angle`` θ [...]: Ω₀e₀ + e^(θê₀)Ω⊥ (C.43).

    Velocities and angular velocities in the body frame transform in the same way (C.45), (C.46).
    """
    return np.asarray(strain, dtype=np.float64) @ np.swapaxes(_about_tangent(angle), -1, -2)


def gauge_frame(rotation: ArrayLike, angle: ArrayLike) -> np.ndarray:
    """Frames R [..., node, 3, 3] after a change of gauge by ``angle`` θ [...]: R e^(−θê₀) (C.41).

    Columns are the directors.
    """
    inverse = np.swapaxes(_about_tangent(angle), -1, -2)
    return np.asarray(rotation, dtype=np.float64) @ inverse[..., None, :, :]


def symmetric_gauge(strain: ArrayLike) -> np.ndarray:
    """Angle θ [...] of the gauge in which, in the least-squares sense, Ω₁ is closest to odd and Ω₂ closest to even.

    ``strain`` [..., node, 3]. θ is determined up to multiples of π; ``gauge_strain(strain, θ)`` applies the gauge.
    """
    strain = np.asarray(strain, dtype=np.float64)
    k = strain[..., 1] + 1j * strain[..., 2]
    even, odd = _parts(k)
    # In that gauge the even part of k is imaginary and the odd part is real.
    return -0.5 * np.angle(np.sum(odd**2 - even**2, axis=-1))


def parity_residual(strain: ArrayLike, activity: ArrayLike) -> np.ndarray:
    """Largest violation [...] of (C.49): Ω₀ and Ω₂ even, Ω₁ and f odd. Zero for a state with the symmetry.

    ``strain`` [..., node, 3], ``activity`` f [..., node]. Apply ``symmetric_gauge`` first where the state may be
    symmetric in another gauge.
    """
    strain = np.asarray(strain, dtype=np.float64)
    twist, bend1, bend2 = (_parts(strain[..., index]) for index in range(3))
    violations = [twist[1], bend1[0], bend2[1], _parts(np.asarray(activity, dtype=np.float64))[0]]
    return np.max(np.broadcast_arrays(*(np.abs(part).max(axis=-1) for part in violations)), axis=0)


def axis_residual(position: ArrayLike, axis: ArrayLike) -> np.ndarray:
    """Largest distance [...] between a node and its image under rotation by π about an axis through the middle (C.52).

    ``position`` [..., node, 3]. ``axis`` [..., 3]: a unit vector, q₁ at the middle in the symmetric gauge.
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

"""The modes in which shapes of a free rod are expanded: beam modes for curvature, harmonics for twist.

The arc length ``s`` runs from −1/2 to 1/2, and every mode has L² norm 1 on this interval. Modes are counted from 0.
Even modes are even functions, positive at the middle. Odd modes are odd functions with positive slope at the middle.
"""

import math

import numpy as np
from numpy.typing import ArrayLike


def beam_root(k: int) -> float:
    """Wave number x_k of beam mode ``k``: the k-th positive root of cos x cosh x = 1 (4.73004 for k = 0)."""
    if k < 0:
        raise ValueError(f"beam mode {k}: modes are counted from 0")
    parity = 1.0 if k % 2 == 0 else -1.0
    root = (k + 1.5) * math.pi
    # tan(x/2) = ∓tanh(x/2) solved for x: a contraction by 2 exp(−x) < 0.02.
    for _ in range(12):
        root = (k + 1.5) * math.pi + parity * 2.0 * math.atan(math.exp(-root))
    return root


def beam_mode(k: int, s: ArrayLike) -> np.ndarray:
    """Beam mode φ_k at arc lengths ``s`` in [−1/2, 1/2], shape of ``s``.

    The eigenfunction of ∂⁴ with φ = φ' = 0 at both ends, the conditions on the curvature at free ends (before 4.35).
    φ_0(0) = 1.58815. No growing exponential is evaluated, so the formula is stable for any ``k``.
    """
    return beam_mode_derivative(k, s, 0)


def beam_mode_derivative(k: int, s: ArrayLike, order: int = 1) -> np.ndarray:
    """Derivative of ``order`` of beam mode φ_k at ``s``, shape of ``s``.

    φ_k = ±[cos(xs)/cos(x/2) − cosh(xs)/cosh(x/2)] for even k, with sin and sinh for odd k; it has norm 1.
    """
    s = np.asarray(s, dtype=np.float64)
    x = beam_root(k)
    odd = k % 2
    end = math.sin(x / 2) if odd else math.cos(x / 2)
    wave = np.cos(x * s + (order - odd) * (math.pi / 2)) / end
    growing, decaying = np.exp(x * (s - 0.5)), np.exp(-x * (s + 0.5))
    # Each derivative exchanges cosh and sinh. Their ratio to the value at the end is written with exponents ≤ 0.
    numerator = growing - decaying if (odd + order) % 2 else growing + decaying
    envelope = numerator / (1.0 - math.exp(-x) if odd else 1.0 + math.exp(-x))
    return math.copysign(1.0, end) * x**order * (wave - envelope)


def coefficients(curvature: ArrayLike, s: ArrayLike, count: int) -> np.ndarray:
    """Coefficients a_k = ∫ κ φ_k ds of curvature on the first ``count`` beam modes.

    ``curvature`` [..., node] at arc lengths ``s`` [node]; returns [..., count]. The trapezoid rule is of fourth order
    for equally spaced nodes, and of sixth order if κ = κ' = 0 at the ends, as on a free rod.
    """
    return _project(curvature, s, np.array([beam_mode(k, s) for k in range(count)]))


def harmonic(k: int, s: ArrayLike) -> np.ndarray:
    """Harmonic γ_k at ``s``: √2 cos((k+1)πs) for even k, √2 sin((k+1)πs) for odd k.

    Eigenfunctions of ∂² with γ = 0 at both ends, the condition on the twist at free ends (4.48).
    """
    wave = np.sin if k % 2 else np.cos
    return math.sqrt(2.0) * wave((k + 1) * math.pi * np.asarray(s, dtype=np.float64))


def harmonic_coefficients(twist: ArrayLike, s: ArrayLike, count: int) -> np.ndarray:
    """Coefficients b_k = ∫ Ω₀ γ_k ds of twist on the first ``count`` harmonics (4.48).

    ``twist`` [..., node] at arc lengths ``s`` [node]; returns [..., count]. The trapezoid rule is of second order for
    equally spaced nodes, and of fourth order if the twist vanishes at the ends, as on a free rod.
    """
    return _project(twist, s, np.array([harmonic(k, s) for k in range(count)]))


def _project(field: ArrayLike, s: ArrayLike, modes: np.ndarray) -> np.ndarray:
    spacing = np.diff(np.asarray(s, dtype=np.float64))
    weights = 0.5 * (np.append(spacing, 0.0) + np.append(0.0, spacing))
    return np.asarray(field, dtype=np.float64) @ (modes * weights).T

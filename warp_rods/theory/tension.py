"""Tension of a planar active rod: the Fredholm series of appendix C.1, and the direct solve of (4.34).

Nodes are equally spaced from s = −1/2 to 1/2. Curvature κ and tension λ are zero at both ends. Both methods use the
same second-order discretisation, so that the series, where it converges, converges to the direct solution.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigvals, solve_banded


def planar_tension(curvature: ArrayLike, activity: ArrayLike, bend: float, drag_ratio: float) -> np.ndarray:
    """Tension λ [node] from (4.34) by a tridiagonal solve; ``curvature`` κ and ``activity`` f [node]."""
    κ, f, spacing = _nodes(curvature, activity)
    β, η = bend, drag_ratio
    source = -_slope(f, spacing) - 0.5 * β * _second(κ**2, spacing) - β / η * κ[1:-1] * _second(κ, spacing)
    bands = np.full((3, len(source)), 1.0 / spacing**2)
    bands[1] = -2.0 / spacing**2 - κ[1:-1] ** 2 / η
    return np.pad(solve_banded((1, 1), bands, source), 1)


def tension_series(curvature: ArrayLike, activity: ArrayLike, bend: float, drag_ratio: float, order: int) -> np.ndarray:
    """Partial sums of (C.9) up to each power of ε = 1/η from 0 to ``order``: [order + 1, node].

    λ = g₀ + Σ_j ε^j K^(j−1) (K g₀ + g₁). Converges geometrically with ``series_ratio`` where that is below 1.
    """
    κ, f, spacing = _nodes(curvature, activity)
    s = np.linspace(-0.5, 0.5, len(κ))
    green = green_function(s[:, None], s) * spacing
    # With the mean of the squared one-sided slopes, κκ'' + κ'² = (κ²)''/2 also holds for the stencils.
    steps = (np.diff(κ) / spacing) ** 2
    slope_squared = np.pad(0.5 * (steps[1:] + steps[:-1]), 1)
    g0 = -0.5 * bend * κ**2 - green @ np.pad(_slope(f, spacing), 1)
    g1 = -0.5 * bend * κ**2 + bend * green @ slope_squared
    kernel = green * κ**2
    terms = [g0, (kernel @ g0 + g1) / drag_ratio]
    while len(terms) <= order:
        terms.append(kernel @ terms[-1] / drag_ratio)
    return np.cumsum(terms[: order + 1], axis=0)


def series_ratio(curvature: ArrayLike, drag_ratio: float) -> float:
    """Spectral radius of K/η (C.7), the ratio of successive late terms of (C.9). The series diverges from 1 on."""
    κ = np.asarray(curvature, dtype=np.float64)
    s = np.linspace(-0.5, 0.5, len(κ))
    kernel = green_function(s[:, None], s) * κ**2 / (len(κ) - 1)
    return float(np.abs(eigvals(kernel)).max() / drag_ratio)


def green_function(s: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Green function of ∂² that is zero at s = ±1/2 (C.2); negative and symmetric. Arguments broadcast."""
    return (np.minimum(s, source) + 0.5) * (np.maximum(s, source) - 0.5)


def _nodes(curvature: ArrayLike, activity: ArrayLike) -> tuple[np.ndarray, np.ndarray, float]:
    κ, f = np.asarray(curvature, dtype=np.float64), np.asarray(activity, dtype=np.float64)
    return κ, f, 1.0 / (len(κ) - 1)


def _slope(field: np.ndarray, spacing: float) -> np.ndarray:
    return (field[2:] - field[:-2]) / (2.0 * spacing)


def _second(field: np.ndarray, spacing: float) -> np.ndarray:
    return (field[2:] - 2.0 * field[1:-1] + field[:-2]) / spacing**2

"""Buckling of an active rod under f = 1 − 2H(s) in closed form: the Airy conditions and functions of §4.3.

``depth`` is −ξ*, the end of the interval on which the Airy functions are evaluated.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import airy


def airy_stiffnesses(count: int) -> np.ndarray:
    """First ``count`` critical β⊥ of (4.37) with f = 1 − 2H(s), descending, modes alternately even and odd.

    Roots ξ* = −β^(−1/3)/2 of (4.45) and (4.47). Raises ValueError where ``count`` is below 1.
    """
    if count < 1:
        raise ValueError(f"count = {count}: must be at least one")
    even = _roots(_even_condition, (count + 1) // 2)
    odd = _roots(_odd_condition, count // 2)
    depths = np.empty(count)
    depths[0::2], depths[1::2] = even, odd
    return (2.0 * depths) ** -3


def airy_mode(k: int, s: ArrayLike) -> np.ndarray:
    """Curvature of marginal mode ``k`` at ``s`` in [−1/2, 1/2]: (4.44) for even k, (4.46) for odd k.

    The L² norm is 1. Signs are those of the beam modes: even modes are positive at the middle, odd modes rise there.
    """
    s = np.asarray(s, dtype=np.float64)
    depth = 0.5 * airy_stiffnesses(k + 1)[k] ** (-1 / 3)
    shape = _odd_shape if k % 2 else _even_shape
    nodes, weights = _gauss(depth)
    norm = np.sqrt(0.5 * weights @ shape(-0.5 * depth * (1.0 + nodes), depth) ** 2)
    half = shape(-depth * (1.0 - 2.0 * np.abs(s)), depth) / norm
    if k % 2:
        return np.sign(s) * half * np.sign(shape(-0.99 * depth, depth))
    return half * np.sign(shape(-depth, depth))


def _gauss(depth: float) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points and weights for the phase (2/3) depth^(3/2) of the Airy functions on [−depth, 0]."""
    return _leggauss(32 * (2 + int(depth**1.5) // 16))


_leggauss = lru_cache(np.polynomial.legendre.leggauss)


def _airy_integrals(xi: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """∫₀^ξ Ai dx and ∫₀^ξ Bi dx to round-off; the error of scipy.special.itairy is 2e-7."""
    xi = np.asarray(xi, dtype=np.float64)
    nodes, weights = _gauss(float(np.max(np.abs(xi))))
    ai, _, bi, _ = airy(0.5 * xi[..., None] * (1.0 + nodes))
    return 0.5 * xi * (ai @ weights), 0.5 * xi * (bi @ weights)


def _even_shape(xi: ArrayLike, depth: float) -> np.ndarray:
    """(4.44)."""
    ai, _, bi, _ = airy(xi)
    int_ai, int_bi = _airy_integrals(xi)
    return bi * int_ai - ai * int_bi


def _odd_shape(xi: ArrayLike, depth: float) -> np.ndarray:
    """(4.46), with ξ* = −depth."""
    ai, _, bi, _ = airy(xi)
    _, ai_slope, _, bi_slope = airy(0.0)
    return bi_slope * ai - ai_slope * bi - 1 / np.pi + depth * _even_shape(xi, depth)


def _even_condition(depth: float) -> float:
    """(4.45) at ξ* = −depth."""
    _, ai_slope, _, bi_slope = airy(-depth)
    int_ai, int_bi = _airy_integrals(-depth)
    return float(bi_slope * int_ai - ai_slope * int_bi)


def _odd_condition(depth: float) -> float:
    """(4.47) at ξ* = −depth."""
    return float(_odd_shape(-depth, depth))


def _roots(condition: Callable[[float], float], count: int) -> np.ndarray:
    """First ``count`` positive roots, bracketed in steps of a twentieth of the local wavelength."""
    roots: list[float] = []
    left, at_left = 1.0, condition(1.0)  # both conditions vanish trivially at 0, and nowhere else below 2
    while len(roots) < count:
        right = left + 0.3 / np.sqrt(left)
        at_right = condition(right)
        if at_left * at_right < 0:
            roots.append(float(brentq(condition, left, right, xtol=1e-14, rtol=1e-14)))
        left, at_left = right, at_right
    return np.array(roots)

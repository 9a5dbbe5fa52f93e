"""A smooth curve through points at given times, which rests where they rest (docs/model.md §2.11)."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["curve_through"]


def curve_through(times: np.ndarray, points: np.ndarray, periodic: bool) -> Any:
    """The cubic spline through points [time, 3], with its slopes at the times limited; a function of time.

    Of fourth order for smooth points; monotone between points where they are, and at rest where they are.
    """
    from scipy.interpolate import CubicHermiteSpline, CubicSpline  # slow to import

    slope = CubicSpline(times, points, bc_type="periodic" if periodic else "not-a-knot")(times, 1)
    curve = CubicHermiteSpline(times, points, _limited(times, points, slope, periodic))
    curve.extrapolate = "periodic" if periodic else True
    return curve


def _limited(times: np.ndarray, points: np.ndarray, slope: np.ndarray, periodic: bool) -> np.ndarray:
    """Slopes within the bounds of Huynh, SIAM J. Numer. Anal. 30 (1993) 57–100, which spare smooth extrema."""
    h = np.diff(times)[:, None]
    chord = np.diff(points, axis=0) / h
    # Two intervals more at each end: of the period before and after, or as the last ones.
    low, high = ([-2, -1], [0, 1]) if periodic else ([0, 0], [-1, -1])
    h, chord = (np.concatenate([v[low], v, v[high]]) for v in (h, chord))
    turning = np.diff(chord, axis=0) / (h[1:] + h[:-1])
    if not periodic:
        turning[:2], turning[-2:] = _smaller(turning[2], turning[3]), _smaller(turning[-3], turning[-4])
    before, after, wide = chord[1:-2], chord[2:-1], np.minimum(h[1:-2], h[2:-1])
    left, here, right = turning[:-2], turning[1:-1], turning[2:]
    from_left = before + h[1:-2] * _smaller(left, here)
    from_right = after - h[2:-1] * _smaller(here, right)
    if not periodic:
        from_left[0], from_right[-1] = from_right[0], from_left[-1]
    slack = wide * abs(_smaller(_smaller(left, here), right))
    bounds = np.stack([3 * _smaller(before, after), 1.5 * _smaller(from_left, from_right), slack, -slack, 0 * slack])
    return np.clip(slope, bounds.min(axis=0), bounds.max(axis=0))


def _smaller(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The one nearer to zero of two numbers of one sign; 0 where their signs differ."""
    return np.where(first * second > 0, np.sign(first) * np.minimum(abs(first), abs(second)), 0.0)

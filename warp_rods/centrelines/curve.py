"""A smooth curve along measured points: a smoothing spline whose width is stated, and its arc length."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.centrelines.track import TrackError
from warp_rods.errors import SceneError

__all__ = ["DEFAULT", "Curve", "check_smoothing", "curve_through", "fitted_curve"]

DEFAULT = "4 points"
"""The smoothing where none is given."""
COUNTED = re.compile(r"\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*points?\s*")
ALLOWED = 'a number, 0 or more, or a number of points in quotes, such as "4 points"'
DEGREE = 5
KNOTS = 6
"""Knots in a wavelength that is halved."""
FEWEST_CELLS, MOST_CELLS = 16, 100_000
ROUNDS, SETTLED = 4, 1e-9
"""Rounds in which the parameter becomes the arc length, and the relative change at which they end. Noise larger than
the distance of points makes loops of a curve that is smoothed little, which more rounds would enlarge."""
LONGEST = 1.5
"""Length of a curve in lengths of the polygon through its points above which it winds between them."""


@dataclass(frozen=True)
class Curve:
    """A smooth curve by its arc length from 0 to ``length``, and the wavelength that was halved.

    spline: the place relative to ``origin`` [3], as a function of a parameter, which ``_parameter`` gives for arc
    lengths. About a point of the line one in a plane of constant z stays in it exactly.
    """

    spline: Any
    length: float
    wavelength: float
    _parameter: Any
    origin: np.ndarray

    def _at(self, s: np.ndarray) -> np.ndarray:
        return np.clip(self._parameter(s), self.spline.t[self.spline.k], self.spline.t[-self.spline.k - 1])

    def place(self, s: np.ndarray) -> np.ndarray:
        """Places [n, 3] at arc lengths [n]."""
        return self.origin + self.spline(self._at(s))

    def tangent_and_bend(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Unit tangents t [n, 3] and ∂t/∂s [n, 3] at arc lengths [n]."""
        u = self._at(s)
        first, second = self.spline(u, 1), self.spline(u, 2)
        speed = np.linalg.norm(first, axis=1, keepdims=True)
        tangent = first / speed
        return tangent, (second - tangent * np.sum(tangent * second, axis=1, keepdims=True)) / speed**2


def check_smoothing(value: Any) -> tuple[float, bool]:
    """The number in ``smoothing``, and whether it counts points; raises SceneError."""
    if isinstance(value, str):
        match = COUNTED.fullmatch(value)
        number = float(match[1]) if match and match[1].count(".") < 2 and match[1] != "." else -1.0
        if not 0 <= number < np.inf:
            raise arguments.wrong("smoothing", value, ALLOWED)
        return number, True
    try:
        return arguments.real("smoothing", value, "zero or more"), False
    except SceneError:
        raise arguments.wrong("smoothing", value, ALLOWED) from None


def fitted_curve(points: np.ndarray, smoothing: Any = DEFAULT, unit: float | None = None) -> Curve:
    """The smooth curve along points [point, 3], neighbours of which do not coincide.

    It minimises ``∫ |x − p|² ds + (Λ/2π)⁶ ∫ |∂³x/∂s³|² ds``, the first integral as a sum over the points. A wave of
    wavelength Λ along the line is halved, one of 2Λ keeps 98 %, one of Λ/2 1.5 %. smoothing: Λ as a length, in units
    of ``unit`` or else of the length of the line, or in mean distances of points ("4 points"); with 0 the curve passes
    through every point. Raises TrackError where it is longer than the line.
    """
    number, counts = check_smoothing(smoothing)
    t = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
    chords = length = float(t[-1])
    origin, points = points[0], points - points[0]
    for _ in range(ROUNDS):
        wavelength = number * (length / (len(points) - 1) if counts else length if unit is None else unit)
        if wavelength > length:
            raise TrackError(
                f"smoothing = {smoothing!r}: a wavelength of {wavelength:.3g}; must be at most the length of the line, "
                f"{length:.3g}"
            )
        spline = _smooth(t, points, wavelength) if number else _interpolating(t, points, 3)
        curve = _by_arc_length(spline, wavelength, origin)
        if curve.length > LONGEST * chords:
            raise TrackError(
                f"winds between its points when smoothing = {smoothing!r}: give a larger one, or more points"
            )
        # The parameter of each point becomes its arc length: chords are shorter than arcs, and longer under noise.
        at = _arc_lengths(spline, t)
        change, t, length = np.abs(at - t).max(), at, curve.length
        if change < SETTLED * length:
            break
    return curve


def curve_through(points: np.ndarray) -> Curve:
    """The curve through all points [point, 3], which are dense along a smooth line and nearly equally spaced."""
    t = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
    return _by_arc_length(_interpolating(t, points - points[0], DEGREE), 0.0, points[0])


def _interpolating(t: np.ndarray, points: np.ndarray, degree: int) -> Any:
    from scipy.interpolate import make_interp_spline

    return make_interp_spline(t, points, k=degree)


def _smooth(t: np.ndarray, points: np.ndarray, wavelength: float) -> Any:
    """The smoothing spline of points at parameters t, on uniform knots."""
    from scipy.interpolate import BSpline
    from scipy.linalg import solveh_banded

    cells = int(np.clip(np.ceil(KNOTS * t[-1] / wavelength), FEWEST_CELLS, MOST_CELLS))
    breaks = np.linspace(t[0], t[-1], cells + 1)
    knots = np.r_[[t[0]] * DEGREE, breaks, [t[-1]] * DEGREE]
    half = np.diff(t) / 2
    # Each point stands for its share of the line, so that the width does not depend on how dense points are.
    share = np.minimum(np.r_[half, 0.0] + np.r_[0.0, half], max(wavelength / 4, 2 * float(np.median(half))))
    design = BSpline.design_matrix(t, knots, DEGREE)
    system = design.T @ (design.multiply(share[:, None])).tocsr()
    system = (system + (wavelength / (2 * np.pi)) ** 6 * _roughness(knots, breaks)).tocsr()
    bands = np.zeros((DEGREE + 1, system.shape[0]))
    for band in range(DEGREE + 1):
        bands[band, : system.shape[0] - band] = system.diagonal(-band)
    try:
        return BSpline(knots, solveh_banded(bands, design.T @ (share[:, None] * points), lower=True), DEGREE)
    except np.linalg.LinAlgError:
        raise TrackError(
            f"has points {np.diff(t).max():.3g} apart, which a smoothing of waves of length {wavelength:.3g} cannot "
            f"bridge: give a larger smoothing, or 0 for a line through every point"
        ) from None


def _roughness(knots: np.ndarray, breaks: np.ndarray) -> Any:
    """∫ B_i''' B_j''' of the basis, exact: three Gauss points in each cell."""
    from scipy.interpolate import BSpline
    from scipy.sparse import diags

    derivative, degree, t = None, DEGREE, knots
    for _ in range(3):
        count = len(t) - degree - 1
        width = (t[degree + 1 : degree + count] - t[1:count]) / degree
        step = diags([-1 / width, 1 / width], [0, 1], shape=(count - 1, count))
        derivative = step if derivative is None else step @ derivative
        degree, t = degree - 1, t[1:-1]
    nodes, weights = np.polynomial.legendre.leggauss(3)
    middle, half = (breaks[1:] + breaks[:-1]) / 2, np.diff(breaks) / 2
    at, weight = (middle[:, None] + half[:, None] * nodes).ravel(), (half[:, None] * weights).ravel()
    third = BSpline.design_matrix(at, t, degree) @ derivative
    return third.T @ third.multiply(weight[:, None]).tocsr()


def _fine(spline: Any) -> np.ndarray:
    """Parameters between which the curve is nearly straight."""
    breaks = np.unique(spline.t)
    parts = max(4, -(-512 // (len(breaks) - 1)))
    inner = breaks[:-1, None] + np.diff(breaks)[:, None] * (np.arange(parts) / parts)
    return np.append(inner.ravel(), breaks[-1])


def _by_arc_length(spline: Any, wavelength: float, origin: np.ndarray) -> Curve:
    from scipy.interpolate import CubicHermiteSpline

    u = _fine(spline)
    s = _arc_lengths(spline, u)
    speed = np.linalg.norm(spline(u, 1), axis=1)
    if not (np.diff(s) > 0).all() or not speed.all():
        raise TrackError("turns back on itself within a point: give more points there, or a smoothing")
    return Curve(spline, float(s[-1]), wavelength, CubicHermiteSpline(s, u, 1 / speed), origin)


def _arc_lengths(spline: Any, u: np.ndarray) -> np.ndarray:
    """Arc lengths [n] at increasing parameters [n] from the first, by Gauss's rule on parts that are fine."""
    fine = np.union1d(_fine(spline), u)
    nodes, weights = np.polynomial.legendre.leggauss(5)
    half = np.diff(fine) / 2
    at = (fine[:-1] + half)[:, None] + half[:, None] * nodes
    speed = np.linalg.norm(spline(at.ravel(), 1), axis=1).reshape(at.shape)
    s = np.r_[0.0, np.cumsum(half * (speed @ weights))]
    return s[np.searchsorted(fine, u)]

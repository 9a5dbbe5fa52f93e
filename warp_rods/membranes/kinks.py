"""Places where the membrane of a formula has a kink, a tip or an edge: the singular points of φ that lie on φ = 0.

φ is smooth except where the argument of a root, a logarithm, a negative power, tan or atan2 is singular. Such places
are curves or points of the surface, which samples on a grid miss. They are found by Newton's method for φ = 0 together
with the argument = 0. Whether the surface is smooth there is then decided from its normals on circles around the place,
since √(u²) may as well be a smooth function, and √(x² + y²) is one away from the axis.
"""

from __future__ import annotations

import numpy as np

from warp_rods.membranes.formula_fields import Singular, singular
from warp_rods.membranes.surface import Surface

__all__ = ["kinks"]

ITERATIONS = 60
"""Newton steps; at a double root of the argument each halves the distance."""
STARTS = 400
"""Points of the surface from which places are searched."""
FOUND = 1e-6
"""A place counts as found where the last step is shorter than this fraction of the box."""
RADII = (1e-3, 1e-4, 1e-5)
"""Radii of the circles around a place, as fractions of the box."""
BESIDE = 1e-10
"""Distance at which derivatives are taken beside a singular point, as a fraction of the box."""
KINK = 0.01
"""Angle in radians between normals on the smallest circle from which on the surface has a kink; on a smooth surface it
is the curvature times the diameter, and falls with it."""


def kinks(surface: Surface, points: np.ndarray) -> np.ndarray:
    """Places [n, 3] of kinks of the surface of a formula; ``points`` [n, 3] on it, from which they are searched."""
    arguments = singular(surface.values["phi"], tuple(sorted(surface.values["parameters"])))
    places = _places(surface, points, arguments)
    return places[[_is_kink(surface, place) for place in places]] if len(places) else places


def _places(surface: Surface, points: np.ndarray, arguments: Singular) -> np.ndarray:
    """Points [n, 3] of the surface at which one of the arguments is zero."""
    count = len(arguments(points[:1], surface.parameters))
    if not count:
        return np.empty((0, 3))
    low, high = surface.box
    size = float(np.linalg.norm(high - low))
    start = points[:: max(1, len(points) // STARTS)]
    found = []
    for index in range(count):
        x, step = _newton(surface, arguments, index, start, size)
        near = np.linalg.norm(step, axis=-1) < FOUND * size
        inside = ((x >= low) & (x <= high)).all(axis=-1)
        found.append(x[near & inside & _on_surface(surface, x, size)])
    places = np.concatenate(found)
    return _distinct(np.where(np.abs(places) < FOUND * size, 0.0, places), size)


def _newton(
    surface: Surface, arguments: Singular, index: int, x: np.ndarray, size: float
) -> tuple[np.ndarray, np.ndarray]:
    """Points [n, 3] after the shortest Newton steps towards φ = 0 and argument = 0, and the last steps [n, 3]."""
    step = np.full_like(x, np.inf)
    with np.errstate(all="ignore"):
        for _ in range(ITERATIONS):
            phi, normal = _row(surface.phi(x), _gradient(surface, x, size))
            value, *gradient = arguments(x, surface.parameters)[index]
            other, direction = _row(value, np.stack(gradient, axis=-1))
            rows, targets = np.stack([normal, direction], axis=1), np.stack([phi, other], axis=-1)
            good = np.isfinite(rows).all(axis=(1, 2)) & np.isfinite(targets).all(axis=1)
            change = np.zeros_like(x)
            change[good] = -np.einsum("nij,nj->ni", np.linalg.pinv(rows[good], rcond=1e-6), targets[good])
            length = np.linalg.norm(change, axis=-1, keepdims=True)
            change *= np.minimum(1.0, 0.1 * size / np.maximum(length, np.finfo(float).tiny))
            step = np.where(good[:, None], change, step)
            x = x + change
    return x, step


def _gradient(surface: Surface, x: np.ndarray, size: float) -> np.ndarray:
    """∇φ at points [n, 3]; beside a point that is singular itself."""
    g = surface.gradient(x)
    beside = surface.gradient(x + BESIDE * size * np.array([0.6, 0.5, 0.4]))
    return np.where(np.isfinite(g).all(axis=-1, keepdims=True), g, beside)


def _row(value: np.ndarray, gradient: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Value and gradient divided by the size of the gradient; where both vanish, the value is zero already."""
    size = np.linalg.norm(gradient, axis=-1)
    zero = (size == 0) & (value == 0)
    size = np.where(zero, 1.0, size)
    return value / size, gradient / size[..., None]


def _on_surface(surface: Surface, x: np.ndarray, size: float) -> np.ndarray:
    """Whether φ = 0 at points [n, 3], or at points beside them where φ has no derivative there."""
    with np.errstate(all="ignore"):
        beside = x[:, None] + 1e-7 * size * _directions()
        phi, g, _H = surface.derivatives(np.concatenate([x[:, None], beside], axis=1))
        distance = np.abs(phi) / np.linalg.norm(g, axis=-1)
    return np.nanmin(np.where(np.isfinite(distance), distance, np.inf), axis=1) < FOUND * size


def _directions() -> np.ndarray:
    """Unit vectors [26, 3] to the faces, edges and corners of a cube."""
    grid = np.stack(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    grid = grid[np.any(grid != 0, axis=1)]
    turn = np.array([[2.0, -2.0, 1.0], [1.0, 2.0, 2.0], [-2.0, -1.0, 2.0]]) / 3  # not along the axes
    return (grid / np.linalg.norm(grid, axis=1, keepdims=True)) @ turn


def _is_kink(surface: Surface, place: np.ndarray) -> bool:
    """Whether normals on smaller and smaller circles around a place do not become parallel, or φ jumps there."""
    size = float(np.linalg.norm(np.subtract(*surface.box)))
    angles = []
    for radius in RADII:
        around = place + radius * size * _directions()
        with np.errstate(all="ignore"):
            foot = surface.project(around, 3)
            phi, g, _H = surface.derivatives(foot)
            n = g / np.linalg.norm(g, axis=-1, keepdims=True)
            off = np.abs(phi) / np.linalg.norm(g, axis=-1)
        near = np.isfinite(n).all(axis=-1) & (np.linalg.norm(foot - place, axis=-1) < 3 * radius * size)
        near &= off < 1e-3 * radius * size
        if near.sum() < 4:
            return True  # the surface ends here, in a tip or at a jump of φ
        cosine = np.clip(n[near] @ n[near].T, -1.0, 1.0)
        angles.append(float(np.arccos(cosine.min())))
    return angles[-1] > KINK and angles[-1] > 0.3 * angles[0]


def _distinct(x: np.ndarray, size: float) -> np.ndarray:
    """Some of the points [n, 3], no two closer than a hundredth of the box."""
    kept: list[np.ndarray] = []
    for point in x:
        if all(np.linalg.norm(point - other) > 0.01 * size for other in kept):
            kept.append(point)
        if len(kept) == 100:
            break
    return np.array(kept).reshape(-1, 3)

"""Random points on a surface, uniform in area, and random directions there, isotropic in angle."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.membranes.surface import Surface

LINES = 500
"""Number of random lines in one batch."""
SAMPLES = 256
"""Points on each line at which the sign of φ is evaluated."""


class Part(NamedTuple):
    """A part of a surface."""

    low: np.ndarray
    """Lower corner [3] of a box around it."""
    high: np.ndarray
    contains: Callable[[np.ndarray], np.ndarray]
    """Which points [n, 3] of the surface belong to it."""


def uniform_points(surface: Surface, count: int, rng: np.random.Generator, part: Part | None = None) -> np.ndarray:
    """Points [count, 3] on the surface (for an open one: on the part in its box), or on a part, uniform in area.

    Crofton's formula: random straight lines, isotropic and with uniform offset, intersect every part of a surface in
    proportion to its area. Raises SceneError where no line through the box intersects the surface.
    """
    found: list[np.ndarray] = []
    wanted = 4 * count  # a quarter is kept, so that few points share a line
    while sum(map(len, found)) < wanted:
        points = _crossings(surface, LINES, rng, part)
        found.append(points)
        if len(found) == 10 and not sum(map(len, found)):
            low, high = surface.box if part is None else part[:2]
            raise SceneError(f"placement: no point of φ = 0 was found in the box {low.tolist()} to {high.tolist()}")
    return rng.choice(np.concatenate(found), size=count, replace=False)


def _crossings(surface: Surface, lines: int, rng: np.random.Generator, part: Part | None) -> np.ndarray:
    """Intersections [n, 3] of random lines with φ = 0 inside the box of the surface or of a part."""
    low, high = surface.box
    if part is not None:
        spare = 0.05 * (part.high - part.low).max()
        low, high = np.maximum(low, part.low - spare), np.minimum(high, part.high + spare)
    centre, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
    d = _unit(rng.normal(size=(lines, 3)))
    e1, e2 = _normals(d)
    rho, angle = radius * np.sqrt(rng.uniform(size=lines)), rng.uniform(0, 2 * np.pi, size=lines)
    foot = centre + rho[:, None] * (np.cos(angle)[:, None] * e1 + np.sin(angle)[:, None] * e2)
    t = np.linspace(-radius, radius, SAMPLES)
    positive = surface.phi(foot[:, None] + t[:, None] * d[:, None]) > 0
    line, cell = np.nonzero(positive[:, 1:] != positive[:, :-1])
    a, b, outside = t[cell], t[cell + 1], positive[line, cell + 1]
    for _ in range(50):
        middle = (a + b) / 2
        beyond = (surface.phi(foot[line] + middle[:, None] * d[line]) > 0) == outside
        a, b = np.where(beyond, a, middle), np.where(beyond, middle, b)
    points = foot[line] + a[:, None] * d[line]
    points = points[((points >= low) & (points <= high)).all(axis=1)]
    return points if part is None or not len(points) else points[part.contains(points)]


def isotropic_directions(surface: Surface, points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Unit tangents [count, 3] at points on the surface, isotropic in the tangent plane."""
    e1, e2 = _normals(surface.normal(points))
    angle = rng.uniform(0, 2 * np.pi, size=(len(points), 1))
    return np.cos(angle) * e1 + np.sin(angle) * e2


def _unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def _normals(d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors [n, 3] normal to each unit vector d [n, 3] and to each other."""
    e1 = _unit(np.cross(d, np.eye(3)[np.argmin(np.abs(d), axis=-1)]))
    return e1, np.cross(d, e1)

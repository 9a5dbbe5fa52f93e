"""Random points on a surface, uniform in area, and random directions there, isotropic in angle."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.membranes.level_set import Box
from warp_rods.membranes.surface import Surface

LINES = 500
"""Number of random lines in one batch."""
FEW = 0.05
"""Intersections per line below which only lines through cells near the surface are drawn."""
MOST_CELLS, NEAR, CELL_SAMPLES = 256, 1.0, 32
"""Cells along the longest edge of the box; distance in diagonals up to which a cell is near; samples on a line."""
SAMPLES = 256
"""Points on each line at which the sign of φ is evaluated."""


class Part(NamedTuple):
    """A part of a surface."""

    low: np.ndarray
    """Lower corner [3] of a box around it."""
    high: np.ndarray
    contains: Callable[[np.ndarray], np.ndarray]
    """Which points [n, 3] of the surface belong to it."""


ROUNDS, KEPT, FIRST_SHIFT, NARROWED = 7, 20, 0.05, 0.4
"""Of the search for curved points: rounds, points kept and draws about each, first shift in sizes of the box, and the
factor from round to round."""

Lines = Callable[[Box, int, np.random.Generator], tuple[np.ndarray, np.ndarray, np.ndarray]]


def uniform_points(surface: Surface, count: int, rng: np.random.Generator, part: Part | None = None) -> np.ndarray:
    """Points [count, 3] on the surface (for an open one: on the part in its box), or on a part, uniform in area.

    Crofton's formula: random straight lines, isotropic and with uniform offset, intersect every part of a surface in
    proportion to its area. Raises SceneError where no line through the box intersects the surface.
    """
    found: list[np.ndarray] = []
    wanted = 4 * count  # a quarter is kept, so that few points share a line
    box = _box_of(surface, part)
    draw: Lines = _lines
    while sum(map(len, found)) < wanted:
        points = _crossings(surface, box, LINES, rng, draw)
        if draw is _lines and not found and len(points) < FEW * LINES:
            draw = _lines_in_cells(surface, box)  # a flat or long box, which few lines through its sphere meet
            continue
        if part is not None and len(points):
            points = points[part.contains(points)]
        found.append(points)
        if len(found) == 10 and not sum(map(len, found)):
            low, high = surface.box if part is None else part[:2]
            raise SceneError(f"placement: no point of φ = 0 was found in the box {low.tolist()} to {high.tolist()}")
    return rng.choice(np.concatenate(found), size=count, replace=False)


def _box_of(surface: Surface, part: Part | None) -> Box:
    """The box of the surface, or a slightly larger one than that of the part."""
    low, high = surface.box
    if part is None:
        return low, high
    spare = 0.05 * (part.high - part.low).max()
    return np.maximum(low, part.low - spare), np.minimum(high, part.high + spare)


def _lines(box: Box, lines: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Feet and directions [line, 3] of random lines through the sphere around the box; positions [line, SAMPLES]."""
    low, high = box
    centre, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
    d = _unit(rng.normal(size=(lines, 3)))
    e1, e2 = _normals(d)
    rho, angle = radius * np.sqrt(rng.uniform(size=lines)), rng.uniform(0, 2 * np.pi, size=lines)
    foot = centre + rho[:, None] * (np.cos(angle)[:, None] * e1 + np.sin(angle)[:, None] * e2)
    return foot, d, np.broadcast_to(np.linspace(-radius, radius, SAMPLES), (lines, SAMPLES))


def _lines_in_cells(surface: Surface, box: Box) -> Lines:
    """A function like ``_lines`` for a flat or long box: lines of the same density, through cells near the surface.

    The box is divided into cells about as wide as its shortest edge. A line counts in the cell through which it was
    drawn only, so the density is the same in all of them.
    """
    low, high = box
    edge = max(float((high - low).min()), float((high - low).max()) / MOST_CELLS)
    parts = np.ceil((high - low) / edge).astype(int)
    size = (high - low) / parts
    corners = np.stack(np.meshgrid(*map(np.arange, parts), indexing="ij"), axis=-1).reshape(-1, 3) * size + low
    phi, g, _ = surface.derivatives(corners + size / 2)
    near = ~(np.abs(phi) > NEAR * np.linalg.norm(g, axis=-1) * np.linalg.norm(size))
    corners = corners[near] if near.any() else corners

    def draw(box: Box, lines: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        foot, d, length = _through_boxes(size, lines, rng)
        return foot + corners[rng.integers(len(corners), size=lines)], d, length * np.linspace(0.0, 1.0, CELL_SAMPLES)

    return draw


def _through_boxes(size: np.ndarray, lines: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Isotropic lines with uniform offset through a box from 0 to ``size`` [3]: feet, directions [line, 3], lengths.

    Feet are uniform on the faces; directions have a density proportional to the cosine to the face. Lengths [line, 1].
    """
    areas = np.repeat(np.prod(size) / size, 2)
    face = rng.choice(6, size=lines, p=areas / areas.sum())
    axis, end = face // 2, face % 2
    foot, row = rng.uniform(size=(lines, 3)) * size, np.arange(lines)
    foot[row, axis] = end * size[axis]
    sine, angle = np.sqrt(rng.uniform(size=lines)), rng.uniform(0, 2 * np.pi, size=lines)
    d = np.empty((lines, 3))
    d[row, axis] = np.sqrt(1 - sine**2) * (1 - 2 * end)
    d[row, (axis + 1) % 3], d[row, (axis + 2) % 3] = sine * np.cos(angle), sine * np.sin(angle)
    with np.errstate(divide="ignore", invalid="ignore"):
        exits = np.where(d > 0, size - foot, -foot) / d
    return foot, d, np.where(d == 0, np.inf, exits).min(axis=1)[:, None]


def _crossings(surface: Surface, box: Box, lines: int, rng: np.random.Generator, draw: Lines) -> np.ndarray:
    """Intersections [n, 3] of random lines with φ = 0 inside the box."""
    low, high = box
    foot, d, t = draw(box, lines, rng)
    positive = surface.phi(foot[:, None] + t[..., None] * d[:, None]) > 0
    line, cell = np.nonzero(positive[:, 1:] != positive[:, :-1])
    a, b, outside = t[line, cell], t[line, cell + 1], positive[line, cell + 1]
    for _ in range(50):
        middle = (a + b) / 2
        beyond = (surface.phi(foot[line] + middle[:, None] * d[line]) > 0) == outside
        a, b = np.where(beyond, a, middle), np.where(beyond, middle, b)
    points = foot[line] + a[:, None] * d[line]
    return points[((points >= low) & (points <= high)).all(axis=1)]


def curved_points(surface: Surface, points: np.ndarray) -> np.ndarray:
    """Points [n, 3] where the curvature of the surface is largest: a search uphill from the most curved of ``points``.

    Each round keeps the most curved points and draws others about them, ever closer. The number of the generator is
    fixed, so the result depends on the surface and the points only.
    """
    low, high = surface.box
    size, rng = float(np.linalg.norm(high - low)), np.random.default_rng(1)
    found, sharpness = points, _sharpness(surface, points)
    for k in range(ROUNDS):
        top = np.argsort(-sharpness, kind="stable")[:KEPT]
        best, sharpest = found[top], sharpness[top]
        shift = FIRST_SHIFT * size * NARROWED**k * rng.normal(size=(len(best), KEPT, 3))
        with np.errstate(all="ignore"):
            new = surface.project((best[:, None] + shift).reshape(-1, 3), 6)
            distance = np.abs(surface.phi(new)) / np.linalg.norm(surface.gradient(new), axis=-1)
        new = new[(distance < 1e-9 * size) & ((new >= low) & (new <= high)).all(axis=-1)]
        found, sharpness = np.concatenate([best, new]), np.concatenate([sharpest, _sharpness(surface, new)])
    return found


def _sharpness(surface: Surface, points: np.ndarray) -> np.ndarray:
    """The larger principal curvature, by size, at points [n, 3]."""
    return np.abs(np.linalg.eigvalsh(surface.second_form(points)[2])).max(axis=-1)


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

"""Random points on a surface, uniform in area, and random directions there, isotropic in angle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.membranes.level_set import Box
from warp_rods.membranes.surface import Surface

LINES = 500
"""Number of random lines in one batch."""
FEW = 0.05
"""Intersections per line below which only lines through cells near the surface are drawn."""
ENOUGH, MOST_CELLS, MOST_DIVISIONS = 0.12, 50_000, 24
"""Cells are divided until that many of the lines through them intersect the surface, which is then a few times thinner
than they are wide; or until they are that many, or divided that often."""
CELL_LINES, CELL_SAMPLES = 4000, 32
"""Lines through cells in one batch, and samples on each."""
AREA_CROSSINGS, MOST_LINES = 4000, 100_000
"""Of the estimate of an area: intersections that are enough for a few per cent, and the largest number of lines."""
THIN = 4.0
"""Boxes with an edge shorter than that many distances between samples are thin."""
SAMPLES = 256
"""Points on each line at which the sign of φ is evaluated."""
FRUITLESS = 10
"""Batches without a point of the surface after which it is given up."""


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

Lines = Callable[[Box, np.random.Generator], tuple[np.ndarray, np.ndarray, np.ndarray]]


def uniform_points(surface: Surface, count: int, rng: np.random.Generator, part: Part | None = None) -> np.ndarray:
    """Points [count, 3] on the surface (for an open one: on the part in its box), or on a part, uniform in area.

    Crofton's formula: random straight lines, isotropic and with uniform offset, intersect every part of a surface in
    proportion to its area. Raises SceneError where no line through the box intersects the surface.
    """
    search, found = _Search(surface, part, rng), [np.empty((0, 3))]
    wanted = 4 * count  # a quarter is kept, so that few points share a line
    while (left := wanted - sum(map(len, found))) > 0:
        found.append(search.points(left, np.inf if left < wanted else FRUITLESS))
        if search.batches >= FRUITLESS and not sum(map(len, found)):
            low, high = surface.box if part is None else part[:2]
            raise SceneError(f"placement: no point of φ = 0 was found in the box {low.tolist()} to {high.tolist()}")
    return rng.choice(np.concatenate(found), size=count, replace=False)


def area(surface: Surface, part: Part | None = None, crossings: int = AREA_CROSSINGS) -> float:
    """The area of a surface (for an open one: of the part in its box), or of a part; length².

    Crofton's formula again: n random lines through a convex body whose faces have the area S intersect what a surface
    has of its area A inside the body 2 n A/S times. The error is about 1.5/√crossings, a few per cent by default.
    """
    search, found = _Search(surface, part, np.random.default_rng(0)), 0
    most = -(-MOST_LINES // search.lines)
    while found < crossings and search.batches < most:
        found += len(search.points(crossings - found, most))
    return search.faces * found / (2 * search.lines * search.batches)


class _Crossed(NamedTuple):
    """Pieces of lines in which φ changes its sign."""

    foot: np.ndarray
    """A point [n, 3] of each line."""
    direction: np.ndarray
    begin: np.ndarray
    """Where the piece begins, and where it ends [n], along the line."""
    end: np.ndarray
    outside: np.ndarray
    """Whether φ > 0 at its end [n]."""


class _Search:
    """Intersections of random lines with a surface, or a part of it, in batches of lines.

    lines: of a batch. batches: drawn so far. faces: the area of the faces of the body through which they are drawn.
    """

    def __init__(self, surface: Surface, part: Part | None, rng: np.random.Generator) -> None:
        self._surface, self._part, self._rng, self._box = surface, part, rng, _box_of(surface, part)
        self._draw: Lines = _lines
        self.lines, self.faces = LINES, np.pi * float(np.sum((self._box[1] - self._box[0]) ** 2))  # of its sphere
        self._ready = _crossings(surface, self._box, [self._batch()])
        if len(self._ready) < FEW * LINES or _is_thin(self._box):
            self._draw, self.faces = _lines_in_cells(surface, self._box)
            self.lines, self._ready = CELL_LINES, _crossings(surface, self._box, [self._batch()])
        self.batches = 1

    def _batch(self) -> _Crossed:
        return _crossed(self._surface, *self._draw(self._box, self._rng), self._box)

    def points(self, enough: int, most: float) -> np.ndarray:
        """The next intersections [n, 3]: about ``enough`` of them, or fewer after ``most`` batches in all.

        As many batches are drawn as have enough changes of sign; the zeros of φ there are then found all at once.
        """
        points, crossed, found = self._ready, list[_Crossed](), len(self._ready)
        while found < enough and self.batches < most:
            crossed.append(self._batch())
            found += len(crossed[-1].begin)
            self.batches += 1
        if crossed:
            points = np.concatenate([points, _crossings(self._surface, self._box, crossed)])
        self._ready = np.empty((0, 3))
        return points if self._part is None or not len(points) else points[self._part.contains(points)]


def _is_thin(box: Box) -> bool:
    """Whether samples on lines through the sphere around a box are too far apart for its shortest edge."""
    size = box[1] - box[0]
    return float(size.min()) < THIN * float(np.linalg.norm(size)) / SAMPLES


def _box_of(surface: Surface, part: Part | None) -> Box:
    """The box of the surface, or a slightly larger one than that of the part."""
    low, high = surface.box
    if part is None:
        return low, high
    spare = 0.05 * (part.high - part.low).max()
    return np.maximum(low, part.low - spare), np.minimum(high, part.high + spare)


def _lines(box: Box, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Feet and directions [line, 3] of random lines through the sphere around the box; positions [line, SAMPLES]."""
    lines = LINES
    low, high = box
    centre, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
    d = _unit(rng.normal(size=(lines, 3)))
    e1, e2 = _normals(d)
    rho, angle = radius * np.sqrt(rng.uniform(size=lines)), rng.uniform(0, 2 * np.pi, size=lines)
    foot = centre + rho[:, None] * (np.cos(angle)[:, None] * e1 + np.sin(angle)[:, None] * e2)
    return foot, d, np.broadcast_to(np.linspace(-radius, radius, SAMPLES), (lines, SAMPLES))


def _lines_in_cells(surface: Surface, box: Box) -> tuple[Lines, float]:
    """A function like ``_lines`` for a surface that few lines through the sphere around its box meet.

    Lines of the same density are drawn through the cells near it. A line counts in the cell through which it was drawn
    only. Also the area of the faces of all these cells.
    """
    low, size = box[0][None], box[1] - box[0]
    for division in range(1, MOST_DIVISIONS + 1):
        low, size = _divided(surface, low, size)
        faces = 2 * float(np.sum(size * np.roll(size, 1)))

        def draw(
            box: Box, rng: np.random.Generator, low: np.ndarray = low, size: np.ndarray = size
        ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            foot, d, length = _through_boxes(size, CELL_LINES, rng)
            which = rng.integers(len(low), size=CELL_LINES)
            return foot + low[which], d, length * np.linspace(0.0, 1.0, CELL_SAMPLES)

        found = len(_crossings(surface, box, [_crossed(surface, *draw(box, np.random.default_rng(0)), box)]))
        if found >= ENOUGH * CELL_LINES or len(low) > MOST_CELLS or division == MOST_DIVISIONS:
            break
    return draw, len(low) * faces


def _divided(surface: Surface, low: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The parts near the surface of cells with corners ``low`` [n, 3] and edges ``size`` [3], cut across long edges.

    A part is near if φ changes sign in it, or is smaller there than its largest gradient allows it to change.
    """
    parts = np.where(size > size.max() / 2, 2, 1)
    size = size / parts
    corners = np.stack(np.meshgrid(*map(np.arange, parts), indexing="ij"), axis=-1).reshape(-1, 3) * size
    low = (low[:, None] + corners).reshape(-1, 3)
    inner = np.stack(np.meshgrid(*[[0.0, 0.5, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * size
    near = [_is_near(surface, some[:, None] + inner, size) for some in np.array_split(low, -(-len(low) // 1000))]
    kept = low[np.concatenate(near)]
    return (kept if len(kept) else low), size


def _is_near(surface: Surface, x: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Whether the surface may be in cells with these points [n, 27, 3]."""
    phi, g, _ = surface.derivatives(x)
    steepest = np.linalg.norm(g, axis=-1).max(axis=1)
    return ~(np.abs(phi).min(axis=1) > steepest * np.linalg.norm(size) / 2)


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


def _crossed(surface: Surface, foot: np.ndarray, d: np.ndarray, t: np.ndarray, box: Box) -> _Crossed:
    """Where φ changes sign between the samples ``t`` [line, sample] of lines, as far as these are near the box."""
    found = surface.crossings(foot, d, t, *_near_box(foot, d, t, box))
    on, sample = np.nonzero(found)
    return _Crossed(foot[on], d[on], t[on, sample], t[on, sample + 1], found[on, sample] < 0)


def _near_box(foot: np.ndarray, d: np.ndarray, t: np.ndarray, box: Box) -> tuple[np.ndarray, np.ndarray]:
    """Where lines [line] are in the box, or within two samples ``t`` [line, sample] of it: from and to."""
    spare = 2 * (t[:, 1] - t[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = np.stack([(side - foot) / d for side in box])
    # Along a face (0/0) a line is inside as far as that face tells.
    enter, leave = np.nan_to_num(sides.min(axis=0), nan=-np.inf), np.nan_to_num(sides.max(axis=0), nan=np.inf)
    return enter.max(axis=-1) - spare, leave.min(axis=-1) + spare


def _crossings(surface: Surface, box: Box, crossed: Sequence[_Crossed]) -> np.ndarray:
    """The zeros [n, 3] of φ in pieces of lines, by bisection, as far as they are in the box."""
    foot, d, a, b, outside = (np.concatenate(parts) for parts in zip(*crossed, strict=True))
    if not len(foot):
        return foot
    phi = surface.phi_again(len(foot))
    for _ in range(50):
        middle = (a + b) / 2
        beyond = (phi(foot + middle[:, None] * d) > 0) == outside
        a, b = np.where(beyond, a, middle), np.where(beyond, middle, b)
    points = foot + a[:, None] * d
    return points[((points >= box[0]) & (points <= box[1])).all(axis=1)]


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

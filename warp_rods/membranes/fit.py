"""From closed triangles to a smooth φ on a grid, whose spacing and smoothing follow from the finest part."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warp_rods.kernels.surface.spline import spline
from warp_rods.membranes import distance
from warp_rods.membranes.bodies import Bodies, oriented
from warp_rods.membranes.distance import Grid3D
from warp_rods.membranes.files import MOST_NODES, FileError
from warp_rods.membranes.level_set import LevelSet
from warp_rods.membranes.triangles import iso_surface

__all__ = ["PAD", "Fit", "Raw", "Shape", "fitted", "interpolated", "shape_of"]

PAD = 8
"""Nodes added on each side by linear continuation of φ, so that effects of the ends of the spline are outside."""
FINE, FINEST = 0.2, 0.35
"""Widths of the smoothing in units of half the finest part: without need no larger than the first, which changes the
curvature of a tube by a few per cent; where facets or voxels need it, up to the second, which moves it by 1 %."""
CELLS = 64
"""Largest spacing: a fraction of the longest side."""
ENOUGH = 3.0
"""Width of the smoothing in grid spacings beyond which a finer grid shows nothing more."""
RESOLVED = 1.2
"""Smallest width of the smoothing in grid spacings."""
MARGIN = 3.0
"""Distance of the membrane from the ends of its grid in units of the width."""
AVERAGED = 2
"""Rounds by which normals of triangles are averaged for the finest part."""
AGREE = 0.02
"""Largest relative change of volume, area and finest part by the smoothing without a warning."""
ROUNDS = 2
"""Times that the spacing is reduced where the membrane before and after does not agree."""


class Shape(NamedTuple):
    """What is compared before and after the smoothing."""

    volume: float
    area: float
    bodies: int
    finest: float
    """Half the smallest width of a body (in a neck: its radius); infinite where no ray finds one."""
    gap: float
    """Half the smallest width of a gap between parts."""

    def changes(self, before: Shape) -> dict[str, float]:
        """Relative changes by name."""
        pairs = {
            "volume": (before.volume, self.volume),
            "area": (before.area, self.area),
            "finest part": (before.finest, self.finest),
            "narrowest gap": (before.gap, self.gap),
        }
        return {name: b / a - 1 for name, (a, b) in pairs.items() if np.isfinite([a, b]).all()}

    def distance(self, before: Shape) -> float:
        """The largest relative change; infinite where the number of bodies is another one."""
        return np.inf if self.bodies != before.bodies else max(map(abs, self.changes(before).values()))


class Raw(NamedTuple):
    """Closed triangles from a file, and what is known of them."""

    bodies: Bodies
    shape: Shape
    roughness: float
    """Width of the smoothing that its facets or voxels need."""
    low: np.ndarray
    """Lower corner [3] of the box that the data fill; −∞ where the membrane ends before."""
    high: np.ndarray


class Fit(NamedTuple):
    """A level set made from triangles."""

    level_set: LevelSet
    wider: LevelSet
    """The same with √2 times the width of the smoothing, to estimate the error of curvature."""
    bodies: Bodies
    shape: Shape
    spacing: np.ndarray
    width: float


def shape_of(bodies: Bodies, rounds: int, box: tuple[np.ndarray, np.ndarray], volume: float | None = None) -> Shape:
    """The shape of the part in a box; ``rounds``: by which normals are averaged."""
    triangles = bodies.triangles
    middles = triangles.corners().mean(axis=0)
    within = ((middles >= box[0]) & (middles <= box[1])).all(axis=-1)
    return Shape(
        float(triangles.volumes().sum()) if volume is None else volume,
        float(triangles.areas()[within].sum()),
        len(np.unique(bodies.of_points[triangles.faces[within, 0]])),
        triangles.opposite(rounds, box=box) / 2,
        triangles.opposite(rounds, outside=True, box=box) / 2,
    )


def interpolated(phi: np.ndarray, spacing: np.ndarray, origin: np.ndarray, **more) -> LevelSet:
    """The surface of the cubic spline through φ [x, y, z] at nodes origin + (i, j, k) spacing."""
    grid = ndimage.spline_filter(np.pad(phi, PAD, mode="reflect", reflect_type="odd"), order=3, mode="mirror")
    numbers = np.concatenate([origin - PAD * spacing, spacing])
    box = (np.array(origin), origin + (np.array(phi.shape) - 1) * spacing)
    return LevelSet(spline, numbers, box, closed=None, grid=grid, **more)


def fitted(raw: Raw, spacing: np.ndarray | None, refine: bool = True) -> Fit:
    """The level set of these triangles on a grid of this spacing [3], or of one that resolves the finest part.

    refine: reduce spacing and smoothing as long as the membrane differs from the triangles. Raises FileError where the
    grid would have too many nodes.
    """
    finest = min(raw.shape.finest, raw.shape.gap, raw.bodies.triangles.size / 2)
    if spacing is not None:
        width = max(min(raw.roughness, FINEST * finest), RESOLVED * float(spacing.max()))
        if (count := _grid(raw, spacing, width).count.prod(dtype=float)) > MOST_NODES:
            raise FileError(f"with spacing = {list(spacing)} needs {count:.2g} nodes; at most {MOST_NODES:.0g}")
        return _on_grid(raw, spacing, width)
    h = raw.bodies.triangles.size / CELLS
    width, best = min(max(raw.roughness, min(RESOLVED * h, FINE * finest)), FINEST * finest), None
    h = max(h, width / ENOUGH)
    for _ in range(1 + (ROUNDS if refine else 0)):
        h = _affordable(raw, min(h, width / RESOLVED), width)
        found = _on_grid(raw, np.full(3, h), max(width, RESOLVED * h))
        if best is None or found.shape.distance(raw.shape) < best.shape.distance(raw.shape):
            best = found
        width *= 0.7
        if found.shape.distance(raw.shape) <= AGREE or found.width > 1.5 * width or width < raw.roughness:
            break
    assert best
    return best


def _grid(raw: Raw, spacing: np.ndarray, width: float) -> Grid3D:
    """A grid around the membrane with a margin, or, where the membrane leaves the data, to the end of the data."""
    margin = MARGIN * width + spacing
    low = np.maximum(raw.bodies.triangles.low - margin, raw.low)
    high = np.minimum(raw.bodies.triangles.high + margin, raw.high)
    count = np.minimum(np.ceil((high - low) / spacing * (1 - 1e-9)), MOST_NODES).astype(int) + 1
    spare = (count - 1) * spacing - (high - low)  # at ends of the data there is none beyond
    first = low - np.where(np.isfinite(raw.low), 0.0, np.where(np.isfinite(raw.high), spare, spare / 2))
    return Grid3D(first, spacing, count)


def _affordable(raw: Raw, spacing: float, width: float) -> float:
    """The spacing, or a larger one for which the grid has no more than ``MOST_NODES`` nodes."""
    while _grid(raw, np.full(3, spacing), width).count.prod(dtype=float) > MOST_NODES:
        spacing *= 1.02
    return spacing


def _on_grid(raw: Raw, spacing: np.ndarray, width: float) -> Fit:
    """The level set on a grid of this spacing, smoothed over this width, with the volume of the data."""
    inner = _grid(raw, spacing, width)
    beyond = np.ceil(MARGIN * width / spacing).astype(int)
    outer = Grid3D(inner.first - beyond * spacing, spacing, inner.count + 2 * beyond)
    signed = distance.signed_distance(raw.bodies.triangles, outer, MARGIN * width)
    kept = tuple(slice(b, b + n) for b, n in zip(beyond, inner.count, strict=True))
    phi, wider = (
        _with_volume(distance.smoothed(signed, w / spacing)[kept], spacing, raw, w) for w in (width, 2**0.5 * width)
    )
    level_set = interpolated(phi, spacing, inner.first)
    box = level_set.box
    points, faces = iso_surface(phi, spacing, inner.first)
    if not len(faces):
        raise FileError(f"would be gone with nodes {spacing.max():.3g} apart: use a finer spacing, or leave it out")
    bodies, _ = oriented(points, faces)
    shape = shape_of(bodies, AVERAGED, box, _volume(phi, spacing))
    return Fit(level_set, interpolated(wider, spacing, inner.first), bodies, shape, spacing, width)


def _volume(phi: np.ndarray, spacing: np.ndarray) -> float:
    """The volume where φ < 0 in the box of the nodes; |∇φ| = 1. The step is spread over one and over two spacings, and
    the error, proportional to the square of that width, is eliminated."""
    one, two = (np.clip(0.5 - phi / (n * spacing.mean()), 0.0, 1.0) for n in (1, 2))
    inside = (4 * one - two) / 3
    for axis in range(3):  # nodes at the ends stand for half a cell
        inside = np.moveaxis(inside, axis, 0)
        inside[[0, -1]] /= 2
        inside = np.moveaxis(inside, 0, axis)
    return float(inside.sum() * spacing.prod())


def _with_volume(phi: np.ndarray, spacing: np.ndarray, raw: Raw, width: float) -> np.ndarray:
    """φ shifted by a constant, a quarter of the width at most, such that the volume is that of the data."""
    lost = (raw.shape.volume - _volume(phi, spacing)) / raw.shape.area
    return phi - np.clip(lost, -width / 4, width / 4)

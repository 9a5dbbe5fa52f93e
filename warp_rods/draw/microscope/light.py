"""Rods as sources of light, and the photons that each pixel expects of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

__all__ = ["WIDE", "Field", "Sources", "at_once", "expected", "expected_in_plane", "sources"]

REACH = 5.0
"""Widths of the point spread function beyond which a source is not seen: 6e-7 of its light are lost."""
AT_ONCE, WIDE = 2e6, 64
"""Pixels that are added at once, those of many sources; pixels across one source above which it is added alone."""


@dataclass(frozen=True)
class Field:
    """The pixels of a stack: rows from high to low y as on a screen, columns along x, planes along z.

    left, top: x and y of the corner of the first pixel; pixel: its edge; heights: z of each plane.
    """

    left: float
    top: float
    pixel: float
    rows: int
    columns: int
    heights: np.ndarray

    @property
    def shape(self) -> tuple[int, int, int]:
        """Planes, rows, columns."""
        return len(self.heights), self.rows, self.columns


@dataclass(frozen=True)
class Sources:
    """Points of light: x, y, z [source, 3], photons of each [source], and the rod that it is on [source]."""

    points: np.ndarray
    photons: np.ndarray
    rod: np.ndarray


def sources(lines: np.ndarray, photons: float, spacing: float) -> Sources:
    """Centre lines [rod, node, 3] as points at most ``spacing`` apart, each with the light of its piece.

    photons: per length. Rods whose nodes are NaN, as those of lost ones, are dark.
    """
    there = np.flatnonzero(np.isfinite(lines).all(axis=(1, 2)))
    first, last = (part.reshape(-1, 3) for part in (lines[there, :-1], lines[there, 1:]))
    length = np.linalg.norm(last - first, axis=1)
    pieces = np.maximum(1, np.ceil(length / spacing).astype(int))
    segment = np.repeat(np.arange(len(pieces)), pieces)
    number = np.arange(len(segment)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    share = ((number + 0.5) / pieces[segment])[:, None]
    points = first[segment] + share * (last - first)[segment]
    rod = np.repeat(there, lines.shape[1] - 1)[segment]
    return Sources(points, photons * (length / pieces)[segment], rod)


def expected(lights: Sources, field: Field, width: float, depth: float) -> np.ndarray:
    """Photons [plane, row, column] that pixels expect: each source is a Gaussian, integrated over the pixels.

    width, depth: its lateral and axial standard deviation. A source at the height of a plane gives it all of its
    photons, one that is Δz off exp(−Δz²/(2 depth²)) of them.
    """
    return np.array([expected_in_plane(lights, field, height, width, depth) for height in field.heights])


def expected_in_plane(lights: Sources, field: Field, height: float, width: float, depth: float) -> np.ndarray:
    """Photons [row, column] that pixels of the plane at this height expect."""
    plane = np.zeros((field.rows, field.columns))
    photons = lights.photons * np.exp(-0.5 * ((lights.points[:, 2] - height) / depth) ** 2)
    for part in at_once(len(photons), _window(width / field.pixel)):
        columns, across = _shares((lights.points[part, 0] - field.left) / field.pixel, width / field.pixel)
        rows, down = _shares((field.top - lights.points[part, 1]) / field.pixel, width / field.pixel)
        down *= photons[part, None]
        if len(rows) == 1:
            (there, y), (here, x) = _inside(rows[0], field.rows), _inside(columns[0], field.columns)
            plane[y, x] += down[0, there, None] * across[0, here]
            continue
        inside = ((rows >= 0) & (rows < field.rows))[:, :, None] & ((columns >= 0) & (columns < field.columns))[:, None]
        pixels = (rows[:, :, None] * field.columns + columns[:, None])[inside]
        np.add.at(plane.reshape(-1), pixels, (down[:, :, None] * across[:, None])[inside])
    return plane


def at_once(count: int, window: int) -> Iterator[slice]:
    """Parts of ``count`` sources that are so many pixels wide: few enough for memory, and wide ones alone."""
    step = 1 if window > WIDE else int(AT_ONCE / window**2)
    for start in range(0, count, step):
        yield slice(start, start + step)


def _inside(numbers: np.ndarray, count: int) -> tuple[slice, slice]:
    """Which of these numbers in a row are from 0 to below ``count``: where they are, and what they are."""
    first = int(numbers[0])
    low, high = max(first, 0), min(first + len(numbers), count)
    return slice(low - first, max(high, low) - first), slice(low, max(high, low))


def _window(width: float) -> int:
    """Pixels across a source of this width in pixels."""
    return 2 * _reach(width) + 1


def _reach(width: float) -> int:
    return int(np.ceil(REACH * width)) + 1


def _shares(place: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Pixels [source, n] near places on a line, in pixels, and the share of the light in each."""
    from scipy.special import ndtr

    reach = _reach(width)
    first = np.floor(place).astype(int) - reach
    edges = first[:, None] + np.arange(2 * reach + 2)
    return edges[:, :-1], np.diff(ndtr((edges - place[:, None]) / width), axis=1)

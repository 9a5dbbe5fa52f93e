"""Rods as sources of light, and the photons that each pixel expects of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["Field", "Sources", "expected", "sources"]

REACH = 5.0
"""Widths of the point spread function beyond which a source is not seen: 6e-7 of its light are lost."""
AT_ONCE = 20_000
"""Sources that are added at once."""


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
    stack = np.zeros((len(field.heights), field.rows * field.columns))
    for start in range(0, len(lights.points), AT_ONCE):
        part = slice(start, start + AT_ONCE)
        columns, across = _shares((lights.points[part, 0] - field.left) / field.pixel, width / field.pixel)
        rows, down = _shares((field.top - lights.points[part, 1]) / field.pixel, width / field.pixel)
        inside = ((rows >= 0) & (rows < field.rows))[:, :, None] & ((columns >= 0) & (columns < field.columns))[:, None]
        light = down[:, :, None] * across[:, None] * lights.photons[part, None, None]
        pixels = (rows[:, :, None] * field.columns + columns[:, None])[inside]
        for plane, height in zip(stack, field.heights, strict=True):
            fading = np.exp(-0.5 * ((lights.points[part, 2] - height) / depth) ** 2)
            plane += np.bincount(pixels, (light * fading[:, None, None])[inside], plane.size)
    return stack.reshape(field.shape)


def _shares(place: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Pixels [source, n] near places on a line, in pixels, and the share of the light in each."""
    from scipy.special import ndtr

    reach = int(np.ceil(REACH * width)) + 1
    first = np.floor(place).astype(int) - reach
    edges = first[:, None] + np.arange(2 * reach + 2)
    return edges[:, :-1], np.diff(ndtr((edges - place[:, None]) / width), axis=1)

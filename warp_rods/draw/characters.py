"""Pictures made of characters, for terminals: curves as bars of eight heights, rods as dots of Braille."""

from __future__ import annotations

import numpy as np

__all__ = ["canvas", "dots_along", "projected", "sparkline"]

BARS, PLAIN_BARS = "▁▂▃▄▅▆▇█", "_.-=*%#@"
"""Heights of bars; the second where a terminal has ASCII only."""
BRAILLE = 0x2800
DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
"""The bits of the dots of a character of Braille, by row and column."""
DOWN, ACROSS = DOTS.shape
MOST_DOTS = 8
"""Dots on a segment of a rod, at most."""


def sparkline(values: np.ndarray, width: int, plain: bool = False) -> str:
    """A curve in ``width`` characters at most: each is the mean of what falls to it; NaN is a space."""
    values = np.asarray(values, dtype=float)
    parts = [part[np.isfinite(part)] for part in np.array_split(values, min(width, len(values)))] if len(values) else []
    means = np.array([part.mean() if len(part) else np.nan for part in parts])
    if not np.isfinite(means).any():
        return " " * len(means)
    low, high = np.nanmin(means), np.nanmax(means)
    heights = np.zeros_like(means) if high == low else (means - low) / (high - low)
    bars = PLAIN_BARS if plain else BARS
    return "".join(" " if np.isnan(h) else bars[min(int(h * len(bars)), len(bars) - 1)] for h in heights)


def projected(position: np.ndarray, period: np.ndarray | None = None) -> tuple[np.ndarray, str]:
    """Rods [rod, node, 3] along the two axes in which they extend farthest [rod, node, 2], and the names of the axes.

    Of a periodic box [3], inf where it is open, each rod is moved as a whole into the box, as in pictures.
    """
    if period is not None:
        from warp_rods.draw.rods import into_box

        position = into_box(position, np.where(np.isfinite(period), period, 0.0))
    extent = np.nanmax(position, axis=(0, 1)) - np.nanmin(position, axis=(0, 1))
    first, second = np.argsort(-extent, kind="stable")[:2]
    return position[..., [first, second]], "xyz"[first] + "xyz"[second]


def dots_along(rods: np.ndarray, columns: int, rows: int) -> np.ndarray:
    """Dots [dot, 2] along rods [rod, node, 2], as column and row from the upper left of a canvas that they just fill.

    All directions have one scale; columns and rows count characters.
    """
    low, high = np.nanmin(rods, axis=(0, 1)), np.nanmax(rods, axis=(0, 1))
    room = np.array([ACROSS * columns - 1, DOWN * rows - 1])
    largest = float(((high - low) / room).max())  # of a dot, in units of the scene
    scale = 1 / largest if largest > max(1e-14 * float(np.abs([low, high]).max()), 1e-290) else 0.0
    scaled = scale * (rods - (low + high) / 2)
    longest = np.nanmax(np.abs(np.diff(scaled, axis=1)), initial=0.0)
    each = int(np.clip(np.ceil(longest), 1, MOST_DOTS))
    between = np.arange(each)[:, None] / each
    along = scaled[:, :-1, None] * (1 - between) + scaled[:, 1:, None] * between
    points = np.concatenate([along.reshape(-1, 2), scaled[:, -1]])
    points = points[np.isfinite(points).all(axis=1)] * [1, -1] + room / 2
    return np.unique(np.rint(points).astype(int), axis=0)


def canvas(dots: np.ndarray, columns: int, rows: int, plain: bool = False) -> list[str]:
    """The lines of a canvas with these dots [dot, 2] (column, row); those outside are left out."""
    across, down = dots[:, 0], dots[:, 1]
    inside = (across >= 0) & (across < ACROSS * columns) & (down >= 0) & (down < DOWN * rows)
    across, down = across[inside], down[inside]
    cells = np.zeros((rows, columns), dtype=int)
    np.bitwise_or.at(cells, (down // DOWN, across // ACROSS), DOTS[down % DOWN, across % ACROSS])
    if plain:
        return ["".join("#" if cell else " " for cell in line) for line in cells]
    return ["".join(chr(BRAILLE + cell) for cell in line) for line in cells]

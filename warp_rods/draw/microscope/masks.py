"""Which pixel belongs to which rod: what a segmentation should find."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warp_rods.draw.microscope.light import Field, at_once, sources

__all__ = ["mask_planes", "masks"]


def masks(lines: np.ndarray, radius: float, field: Field) -> np.ndarray:
    """Labels [plane, row, column] of rods [rod, node, 3]: their number from 1, and 0 beside them.

    A pixel belongs to the nearest rod whose centre line is within ``radius`` of its middle, or within ¾ of a pixel
    where that is more. One plane shows the rods at all heights; of several each shows those that are within the radius
    of it, or ¾ of their distance.
    """
    return np.array(list(mask_planes(lines, radius, field)))


def mask_planes(lines: np.ndarray, radius: float, field: Field) -> Iterator[np.ndarray]:
    """The same labels [row, column] of one plane after the other."""
    within = max(radius, 0.75 * field.pixel)
    points = sources(lines, 1.0, field.pixel / 2)
    apart = np.diff(field.heights[:2])
    kind = np.uint16 if len(lines) < 2**16 else np.uint32
    for height in field.heights:
        off = (points.points[:, 2] - height) / max(radius, 0.75 * apart[0]) if len(apart) else np.zeros(len(points.rod))
        near = off**2 <= 1.0
        yield _plane(points.points[near, :2], off[near] ** 2, points.rod[near], within, field).astype(kind)


def _plane(points: np.ndarray, off: np.ndarray, rod: np.ndarray, within: float, field: Field) -> np.ndarray:
    """Labels [row, column]: each pixel has that of the nearest point; ``off``: squared distances to the plane."""
    labels = np.zeros(field.rows * field.columns, np.uint32)
    nearest = np.full(labels.size, np.inf)
    for part in at_once(len(rod), 2 * int(np.ceil(within / field.pixel)) + 1):
        pixels, squared, number = _near(points[part], off[part], rod[part], within, field)
        order = np.argsort(-squared, kind="stable")  # the last of those who claim a pixel has it: the nearest
        order = order[squared[order] <= nearest[pixels[order]]]
        labels[pixels[order]] = number[order] + 1
        nearest[pixels[order]] = squared[order]
    return labels.reshape(field.rows, field.columns)


def _near(
    points: np.ndarray, off: np.ndarray, rod: np.ndarray, within: float, field: Field
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pixels near each point, their squared distances, and the rods."""
    x, y = (points[:, 0] - field.left) / field.pixel, (field.top - points[:, 1]) / field.pixel
    columns, rows = _around(x, within / field.pixel, field.columns), _around(y, within / field.pixel, field.rows)
    columns, rows = columns[:, None, :], rows[:, :, None]
    across = (columns + 0.5 - x[:, None, None]) ** 2 + (rows + 0.5 - y[:, None, None]) ** 2
    squared = across * (field.pixel / within) ** 2 + off[:, None, None]
    inside = (squared <= 1.0) & (rows >= 0) & (rows < field.rows) & (columns >= 0) & (columns < field.columns)
    number = np.broadcast_to(rod[:, None, None], inside.shape)
    return (rows * field.columns + columns)[inside], squared[inside], number[inside]


def _around(place: np.ndarray, within: float, count: int) -> np.ndarray:
    """Pixels [point, n] within so many of places on a line; of one point only those from 0 to below ``count``."""
    reach = int(np.ceil(within))
    near = np.floor(place).astype(int)[:, None] + np.arange(-reach, reach + 1)
    return near[:, (near[0] >= 0) & (near[0] < count)] if len(near) == 1 else near

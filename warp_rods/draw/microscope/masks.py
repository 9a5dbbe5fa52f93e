"""Which pixel belongs to which rod: what a segmentation should find."""

from __future__ import annotations

import numpy as np

from warp_rods.draw.microscope.light import Field, sources

__all__ = ["masks"]


def masks(lines: np.ndarray, radius: float, field: Field) -> np.ndarray:
    """Labels [plane, row, column] of rods [rod, node, 3]: their number from 1, and 0 beside them.

    A pixel belongs to the nearest rod whose centre line is within ``radius`` of its middle, or within ¾ of a pixel
    where that is more. One plane shows the rods at all heights; of several each shows those that are within the radius
    of it, or ¾ of their distance.
    """
    labels = np.zeros(field.shape, np.uint16 if len(lines) < 2**16 else np.uint32)
    within = max(radius, 0.75 * field.pixel)
    points = sources(lines, 1.0, field.pixel / 2)
    apart = np.diff(field.heights[:2])
    for plane, height in zip(labels, field.heights, strict=True):
        off = (points.points[:, 2] - height) / max(radius, 0.75 * apart[0]) if len(apart) else np.zeros(len(points.rod))
        pixels, squared, rod = _near(points.points, off**2, points.rod, within, field)
        order = np.argsort(-squared, kind="stable")  # the last of those who claim a pixel has it: the nearest
        plane.ravel()[pixels[order]] = rod[order] + 1
    return labels


def _near(
    points: np.ndarray, off: np.ndarray, rod: np.ndarray, within: float, field: Field
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pixels near each point, their squared distances, and the rods; ``off``: squared distances to the plane."""
    near = off <= 1.0
    x, y = (points[near, 0] - field.left) / field.pixel, (field.top - points[near, 1]) / field.pixel
    reach = int(np.ceil(within / field.pixel))
    window = np.arange(-reach, reach + 1)
    columns = np.floor(x).astype(int)[:, None, None] + window[None, None]
    rows = np.floor(y).astype(int)[:, None, None] + window[None, :, None]
    across = (columns + 0.5 - x[:, None, None]) ** 2 + (rows + 0.5 - y[:, None, None]) ** 2
    squared = across * (field.pixel / within) ** 2 + off[near, None, None]
    inside = (squared <= 1.0) & (rows >= 0) & (rows < field.rows) & (columns >= 0) & (columns < field.columns)
    number = np.broadcast_to(rod[near, None, None], inside.shape)
    return (rows * field.columns + columns)[inside], squared[inside], number[inside]

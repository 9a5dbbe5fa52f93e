"""The box of swimmers as it is drawn: its sides, and the lines along its edges."""

from __future__ import annotations

import numpy as np

from warp_rods.scene.box import Box
from warp_rods.scene.scene import Scene

__all__ = ["edges_of", "sides_of"]

_POINTS = 48
"""Points on a circle of a pore, four of which are joined to those at the other end."""


def sides_of(scene: Scene) -> np.ndarray | None:
    """Lengths [3] of the box along the axes; None where there is none, and for a container or infinite walls."""
    box = scene.box
    if box is None or box.surface:
        return None
    size = np.array(scene.period)
    if box.height is not None:
        size[2] = box.height
    elif box.axis is not None:
        across = box.sides or (2 * (box.radius or 0.0),) * 2
        size = np.roll([box.length or 0.0, *across], box.along)
    return size if size.all() else None


def edges_of(scene: Scene) -> np.ndarray:
    """Both ends [line, 2, 3] of the lines along the edges of the box about the origin; none where it has no sides."""
    size = sides_of(scene)
    if size is None or scene.box is None:
        return np.empty((0, 2, 3))
    return _edges_of_pore(scene.box) if scene.box.radius else _edges(size)


def _edges(size: np.ndarray) -> np.ndarray:
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    pairs = [(a, b) for a in range(8) for b in range(a + 1, 8) if (corners[a] != corners[b]).sum() == 1]
    return corners[np.array(pairs)]


def _edges_of_pore(box: Box) -> np.ndarray:
    """Circles at both ends of a pore, and lines along it."""
    assert box.radius is not None and box.length is not None
    angle = np.linspace(0, 2 * np.pi, _POINTS, endpoint=False)
    ring = np.stack([0 * angle, box.radius * np.cos(angle), box.radius * np.sin(angle)], axis=-1)
    first, last = (ring + np.array([x, 0, 0]) for x in (-box.length / 2, box.length / 2))
    around = [np.stack([circle, np.roll(circle, -1, axis=0)], axis=1) for circle in (first, last)]
    along = np.stack([first, last], axis=1)[:: _POINTS // 4]
    return np.roll(np.concatenate([*around, along]), box.along, axis=2)

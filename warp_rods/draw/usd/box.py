"""The box of swimmers in a USD stage: its edges, or the surface of a container."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw.usd.curves import linear_curves, set_points
from warp_rods.draw.usd.materials import add_translucent_material
from warp_rods.draw.usd.membrane import draw_membrane
from warp_rods.membranes.surfaces import make
from warp_rods.scene.box import Box
from warp_rods.scene.scene import Scene

_OPACITY = 0.12
"""Opacity of a container; low, as the cells are inside."""
_EDGE_RADIUS = 1 / 1000
"""Radius of the edges, in lengths of the longest edge."""
_POINTS = 48
"""Points on a circle of a pore, four of which are joined to those at the other end."""


def draw_box(stage: Any, scene: Scene, material: Any) -> np.ndarray:
    """Draw the box of a scene; returns points [n, 3] of it, none where there is nothing to draw."""
    if scene.box is None:
        return np.empty((0, 3))
    if scene.box.surface:
        surface = make(scene.box.surface.kind, scene.box.surface.parameters)
        translucent = add_translucent_material(stage, "Container", _OPACITY)
        return draw_membrane(stage, surface, np.zeros(1), translucent, "/World/Container")
    size = _sides(scene)
    if not size.all():
        return np.empty((0, 3))  # infinite walls have no edges
    corners, ends = _edges_of_pore(scene.box) if scene.box.radius else _edges(size)
    curves = linear_curves(stage, "/World/Box", np.full(len(ends), 2), material)
    radius = _EDGE_RADIUS * size.max()
    curves.CreateWidthsAttr([2 * radius])
    curves.SetWidthsInterpolation("constant")
    set_points(curves, None, corners[np.ravel(ends)], radius)
    return corners


def _sides(scene: Scene) -> np.ndarray:
    """Lengths [3] of the box along the axes, 0 where it is infinite."""
    box = scene.box
    assert box is not None
    size = np.array(scene.period)
    if box.height is not None:
        size[2] = box.height
    elif box.axis is not None:
        across = box.sides or (2 * (box.radius or 0.0),) * 2
        size = np.roll([box.length or 0.0, *across], box.along)
    return size


def _edges(size: np.ndarray) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Corners [8, 3] of a box about the origin, and the pairs of them that are ends of an edge."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    return corners, [(a, b) for a in range(8) for b in range(a + 1, 8) if (corners[a] != corners[b]).sum() == 1]


def _edges_of_pore(box: Box) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Points [n, 3] on the circles at both ends of a pore, and pairs of them that are ends of a line."""
    assert box.radius is not None and box.length is not None
    angle = np.linspace(0, 2 * np.pi, _POINTS, endpoint=False)
    ring = np.stack([0 * angle, box.radius * np.cos(angle), box.radius * np.sin(angle)], axis=-1)
    points = np.concatenate([ring + np.array([x, 0, 0]) for x in (-box.length / 2, box.length / 2)])
    around = [(first + k, first + (k + 1) % _POINTS) for first in (0, _POINTS) for k in range(_POINTS)]
    along = [(k, k + _POINTS) for k in range(0, _POINTS, _POINTS // 4)]
    return np.roll(points, box.along, axis=1), around + along


def into_box(position: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Rods [rod, node, 3], each shifted as a whole so that its middle is in the box; ``period`` [3] is 0 where open."""
    divisor = np.where(period > 0, period, np.inf)
    middle = position[:, position.shape[1] // 2, None]
    return position - np.where(period > 0, period, 0.0) * np.rint(middle / divisor)

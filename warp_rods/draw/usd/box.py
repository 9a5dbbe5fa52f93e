"""The box of swimmers in a USD stage: its edges, or the surface of a container."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw.usd.curves import linear_curves, set_points
from warp_rods.draw.usd.materials import add_translucent_material
from warp_rods.draw.usd.membrane import draw_membrane
from warp_rods.membranes.surfaces import make
from warp_rods.scene.scene import Scene

_OPACITY = 0.12
"""Opacity of a container; low, as the cells are inside."""
_EDGE_RADIUS = 1 / 1000
"""Radius of the edges, in lengths of the longest edge."""


def draw_box(stage: Any, scene: Scene, material: Any) -> np.ndarray:
    """Draw the box of a scene; returns points [n, 3] of it, none where there is nothing to draw."""
    if scene.box is None:
        return np.empty((0, 3))
    if scene.box.surface:
        surface = make(scene.box.surface.kind, scene.box.surface.parameters)
        translucent = add_translucent_material(stage, "Container", _OPACITY)
        return draw_membrane(stage, surface, np.zeros(1), translucent, "/World/Container")
    size = np.array(scene.period)
    if scene.box.height is not None:
        size[2] = scene.box.height
    if not size.all():
        return np.empty((0, 3))  # infinite walls have no edges
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    ends = [(a, b) for a in range(8) for b in range(a + 1, 8) if (corners[a] != corners[b]).sum() == 1]
    curves = linear_curves(stage, "/World/Box", np.full(len(ends), 2), material)
    radius = _EDGE_RADIUS * size.max()
    curves.CreateWidthsAttr([2 * radius])
    curves.SetWidthsInterpolation("constant")
    set_points(curves, None, corners[np.ravel(ends)], radius)
    return corners


def into_box(position: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Rods [rod, node, 3], each shifted as a whole so that its middle is in the box; ``period`` [3] is 0 where open."""
    divisor = np.where(period > 0, period, np.inf)
    middle = position[:, position.shape[1] // 2, None]
    return position - np.where(period > 0, period, 0.0) * np.rint(middle / divisor)

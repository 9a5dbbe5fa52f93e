"""The box of swimmers in a USD stage: its edges, or the surface of a container."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw.content import Content
from warp_rods.draw.usd.curves import linear_curves, set_points
from warp_rods.draw.usd.materials import add_translucent_material
from warp_rods.draw.usd.membrane import draw_membrane

_OPACITY = 0.12
"""Opacity of a container; low, as the cells are inside."""
_EDGE_RADIUS = 1 / 1000
"""Radius of the edges, in lengths of the longest edge."""


def draw_box(stage: Any, shown: Content, material: Any) -> np.ndarray:
    """Draw the box of a scene; returns points [n, 3] of it, none where there is nothing to draw."""
    if shown.container:
        translucent = add_translucent_material(stage, "Container", _OPACITY)
        return draw_membrane(stage, shown.container, shown.frames, translucent, "/World/Container")
    size = shown.box
    if size is None:
        return np.empty((0, 3))
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    ends = [(a, b) for a in range(8) for b in range(a + 1, 8) if (corners[a] != corners[b]).sum() == 1]
    curves = linear_curves(stage, "/World/Box", np.full(len(ends), 2), material)
    radius = _EDGE_RADIUS * size.max()
    curves.CreateWidthsAttr([2 * radius])
    curves.SetWidthsInterpolation("constant")
    set_points(curves, None, corners[np.ravel(ends)], radius)
    return corners

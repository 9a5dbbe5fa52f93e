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
        return draw_membrane(stage, shown.container, range(1), translucent, "/World/Container")
    size = shown.box
    if size is None:
        return np.empty((0, 3))
    ends = shown.edges
    curves = linear_curves(stage, "/World/Box", np.full(len(ends), 2), material)
    radius = _EDGE_RADIUS * size.max()
    curves.CreateWidthsAttr([2 * radius])
    curves.SetWidthsInterpolation("constant")
    set_points(curves, None, ends.reshape(-1, 3), radius)
    return ends.reshape(-1, 3)

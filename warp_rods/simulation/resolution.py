"""Warnings where the nodes of rods are too far apart for their surface, their shape or their motion."""

from __future__ import annotations

import math

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.membranes.surface import Surface
from warp_rods.scene.filaments import FilamentsTable
from warp_rods.scene.swimmers import SwimmersTable

LARGEST_ANGLE = 0.3
"""Bending in radians per cell up to which the discretisation error is about a per cent."""
BUCKLING = 0.5
"""Largest spacing of a swimmer's nodes in units of β⊥^(1/3), the length on which it buckles. At 0.62 the energy of a
waving swimmer is 30 % off, at 0.31 it is right to some per cent."""
NODES_PER_ARC, FEWEST_PER_ARC = 6, 2
"""Cells per half-wave of a beam mode below which its shape is warned of, and refused."""


def unresolved_filaments(surface: Surface, table: FilamentsTable, points: np.ndarray) -> list[str]:
    """A warning if the spacing of nodes is too large for the curvature of the surface or the intrinsic curvature."""
    spacing = float(np.max(table.length)) / (table.nodes - 1)
    principal = np.abs(np.linalg.eigvalsh(surface.second_form(points)[2])).max()
    largest = max(float(principal), float(np.abs(table.intrinsic).max()))
    if spacing * largest <= LARGEST_ANGLE:
        return []
    nodes = math.ceil(float(np.max(table.length)) * largest / LARGEST_ANGLE) + 1
    return [
        f"{table.name}: nodes are {spacing:.3g} apart and curvatures reach {largest:.3g}: bending by more than "
        f"{LARGEST_ANGLE} radians per cell is not well resolved; use {nodes} nodes or more"
    ]


def unresolved_swimmers(table: SwimmersTable) -> list[str]:
    """Warnings if the nodes of swimmers do not resolve their buckling, or their shape at the start.

    Raises SceneError for a beam mode that the nodes cannot represent.
    """
    found, spacing, shortest = [], 1 / (table.nodes - 1), float(np.min(table.bend)) ** (1 / 3)
    if spacing > BUCKLING * shortest:
        nodes = 2 * math.ceil(1 / (2 * BUCKLING * shortest)) + 1
        found.append(
            f"{table.name}: nodes are {spacing:.3g} apart, and the softest swimmer buckles on the length β⊥^(1/3) = "
            f"{shortest:.3g}: nodes more than half of it apart do not resolve its motion; use {nodes} nodes or more"
        )
    arcs = (table.shape.mode or 0) + 1.5
    if table.shape.kind == "mode" and table.nodes - 1 < NODES_PER_ARC * arcs:
        nodes = 2 * math.ceil(NODES_PER_ARC * arcs / 2) + 1
        text = f"{table.nodes} nodes for the {arcs:g} half-waves of the mode {table.shape.mode}: use {nodes} or more"
        if table.nodes - 1 < FEWEST_PER_ARC * arcs:
            raise SceneError(f"shape.mode = {table.shape.mode}: {text}")
        found.append(f"{table.name}: {text}")
    return found

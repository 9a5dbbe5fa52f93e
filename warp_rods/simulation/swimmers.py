"""Swimmers of a scene: their number of nodes and their places."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from warp_rods.rods.free.rods import FreeRods
from warp_rods.scene.swimmers import SwimmersTable
from warp_rods.simulation.criteria import criteria_of_swimmers
from warp_rods.simulation.resolution import Resolution, resolution

if TYPE_CHECKING:
    from warp_rods.simulation.layout import Layout


def nodes_of(layout: Layout, table: SwimmersTable) -> Resolution:
    """The number of nodes of a table."""
    return resolution(table, criteria_of_swimmers(table, layout.scene.steric))


def build(layout: Layout, table: SwimmersTable) -> None:
    """Add an ensemble of swimmers to the layout."""
    placed: dict[str, np.ndarray] = {}
    if isinstance(table.placement, str):
        if table.placement not in layout.arranged:
            layout.arranged[table.placement] = _arranged(layout, table.placement)
        placed = layout.arranged[table.placement][table.name]
    elif table.placement is not None:
        from warp_rods.contact.arrangements import given_poses

        placed = given_poses(table.placement.position, table.placement.direction)
    layout.ensembles[table.name] = _free_rods(layout, table, **placed)
    wall = layout.scene.box and layout.scene.box.wall
    if not (table.symmetric or layout.scene.steric or wall):
        layout.notes += _symmetric_start(table, layout.ensembles[table.name])


def _free_rods(layout: Layout, table: SwimmersTable, **placed) -> FreeRods:
    names = ("bend", "twist", "moment", "drag_ratio", "rotational_drag", "symmetric")
    return FreeRods(
        table.count,
        table.node_count,
        **{name: getattr(table, name) for name in names},
        flagella=table.flagella.model_dump(),
        shape=table.shape.model_dump(exclude_none=True) | {"seed": layout.seed(table.name)},
        **placed,
        device=layout.device,
    )


def _arranged(layout: Layout, arrangement: str) -> dict[str, dict[str, np.ndarray]]:
    """Middle points and frames of all swimmers with this placement, which are placed together, by name."""
    from warp_rods.contact.arrangements import arranged_poses

    tables = [table for table in layout.scene.swimmers if table.placement == arrangement]
    shapes = {table.name: _free_rods(layout, table).position for table in tables}
    rng = layout.random(arrangement)
    poses, note = arranged_poses(arrangement, layout.scene, layout.container, shapes, layout.lines, rng)
    layout.notes.append(f"{', '.join(shapes)}: placed {arrangement}; {note}")
    return poses


def _symmetric_start(table: SwimmersTable, rods: FreeRods) -> list[str]:
    """A note if nothing but round-off can break the symmetry of swimmers."""
    count = int(rods.symmetric_start.sum())
    if not count:
        return []
    return [
        f"{table.name}: {count} of {table.count} rods start with the symmetry under rotation by π, which the equations "
        f"keep: where such a shape is unstable, round-off chooses the side to which it breaks, and the direction of "
        f"swimming, and another step may reverse it. shape.perturbation = 1e-3 lets the seed choose; symmetric = true "
        f"keeps the symmetry of even shapes"
    ]

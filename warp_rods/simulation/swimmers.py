"""Swimmers of a scene: their number of nodes and their places."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any
from zlib import crc32

import numpy as np

from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import Parts, perturbed
from warp_rods.rods.per_rod import each_rod
from warp_rods.scene.along import given_along
from warp_rods.scene.ends import given_end
from warp_rods.scene.swimmers import NaturalBend, SwimmersTable
from warp_rods.simulation.criteria import criteria_of_swimmers
from warp_rods.simulation.resolution import Resolution, resolution

if TYPE_CHECKING:
    from warp_rods.simulation.layout import Layout


def nodes_of(layout: Layout, table: SwimmersTable) -> Resolution:
    """The number of nodes of a table."""
    return resolution(table, criteria_of_swimmers(table, layout.scene.steric, layout.bending_at_start(table.name)))


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
    elif table.shape.from_file:
        arrays = layout.start_of(table)
        placed = {name: arrays[name] for name in ("position", "rotation")}
    layout.ensembles[table.name] = _free_rods(layout, table, **placed)
    wall = layout.scene.box and layout.scene.box.wall
    if not (table.symmetric or layout.scene.steric or wall or any(layout.outside(table.name).values())):
        layout.notes += _symmetric_start(table, layout.ensembles[table.name])


def _free_rods(layout: Layout, table: SwimmersTable, **placed) -> FreeRods:
    seeds = [[seed, *table.name.encode()] for seed in layout.seeds]
    seed = Parts(seeds) if seeds else layout.seed(table.name)
    shape: Any = table.shape.model_dump(exclude_none=True) | {"seed": seed}
    flagella = table.flagella.model_dump()
    if table.shape.from_file:
        arrays, size = layout.start_of(table), table.shape.perturbation or 0.0
        shape = perturbed(arrays["strain"], size, each_rod(table.moment, table.count), shape["seed"])
        flagella |= {"profile": arrays["activity"]} if "activity" in arrays else {}
    return FreeRods(
        table.count,
        table.node_count,
        moment=table.moment,
        symmetric=table.symmetric,
        **_along(table),
        parameters=table.parameters,
        flagella=flagella,
        **_behaviour(layout, table),
        shape=shape,
        **layout.outside(table.name),
        **placed,
        device=layout.device,
    )


def _behaviour(layout: Layout, table: SwimmersTable) -> dict[str, Any]:
    """What the rods do at random times, in streams that depend on the name of the ensemble and the number of a rod.

    Rods of a part have the numbers, and the seed, of a scene of its own.
    """
    if table.behaviour is None:
        return {}
    seeds = layout.seeds or (layout.scene.seed,)
    rods = table.count // len(seeds)
    numbers = np.tile(np.arange(rods, dtype=np.uint64), len(seeds))
    streams = (crc32(table.name.encode()) << 32) + numbers
    return {"behaviour": table.behaviour.behaviours, "seed": np.repeat(seeds, rods), "streams": streams}


def _along(table: SwimmersTable) -> dict[str, Any]:
    """What a table gives along the rods and at their ends."""
    names = ("bend", "twist", "drag_ratio", "drag_along", "rotational_drag", "natural_twist", "couple")
    given = {name: given_along(value) for name in names if (value := getattr(table, name)) is not None}
    natural = table.natural_bend
    if isinstance(natural, NaturalBend):
        given["natural_bend"] = {"second": given_along(natural.second), "third": given_along(natural.third)}
    elif natural is not None:
        given["natural_bend"] = given_along(natural)
    if table.ends is not None:
        given["ends"] = [given_end(end) for end in table.ends]
    return given


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
        f"keeps the symmetry of shapes with even bend2 and odd bend1"
    ]

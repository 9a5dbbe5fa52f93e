"""Filaments of a scene on its membrane: their number of nodes and their places."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods.contact.capacity import area_for, refuse_crowd_on
from warp_rods.contact.overlap import without_overlap
from warp_rods.contact.segments import OccupiedSpace
from warp_rods.errors import SceneError
from warp_rods.membranes import sampling as placement
from warp_rods.membranes.built_in import SPARE
from warp_rods.membranes.surface import Surface, ends_of
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.per_rod import each_node, each_rod
from warp_rods.rods.status import Status
from warp_rods.scene.components import numbers_of, rows_of
from warp_rods.scene.filaments import FilamentsTable, GrowthTable
from warp_rods.simulation.criteria import criteria_of_filaments
from warp_rods.simulation.resolution import Resolution, largest_length, resolution
from warp_rods.simulation.samples import samples_of, times_of
from warp_rods.simulation.surfaces import part_of

if TYPE_CHECKING:
    from warp_rods.simulation.layout import Layout

ROUGH_AREA = 400
"""Intersections from which an area is known to about a tenth."""
MOST_ROUNDS = 200
"""Rounds of drawing filaments again that stick out of the box of an open surface."""


def nodes_of_filaments(layout: Layout, table: FilamentsTable) -> Resolution:
    """The number of nodes of a table, by the curvatures of the membrane where its filaments may be."""
    surface, end = layout.surface, layout.scene.time.end
    assert surface is not None  # a scene of filaments without a surface is refused
    for time in times_of(surface, end):
        _check_length(surface.at(time), table)
    samples = samples_of(surface, end, part_of(surface, table.bodies))
    return resolution(table, criteria_of_filaments(table, samples, layout.scene.steric, end))


def build_filaments(layout: Layout, table: FilamentsTable) -> None:
    """Add an ensemble of filaments to the layout."""
    surface = layout.surface
    assert surface is not None

    def build(position: np.ndarray, direction: np.ndarray, rods: Any = slice(None), **placed) -> BoundRods:
        parameters: dict[str, Any] = {
            "length": each_rod(table.length, table.count)[rods],
            **{k: _along(getattr(table, k), table.count, rods) for k in ("stiffness", "intrinsic", "drag")},
        }
        growth = None if table.growth is None else _growth_of(table.growth, rods, table.count)
        return BoundRods(
            surface, position, direction, nodes=table.node_count, ends=table.ends, growth=growth, device=layout.device,
            **parameters, **placed,
        )  # fmt: skip

    part = part_of(surface, table.bodies)
    if table.placement == "random":
        position, direction = _random(layout, table, part, build)
        rods = build(position, direction)
    else:
        p = table.placement
        geodesic = each_node(p.geodesic_curvature, table.count, table.node_count)
        rods = build(np.array(p.position), np.array(p.direction), at=p.at, geodesic_curvature=geodesic)
        if len(lost := np.flatnonzero(rods.status)):
            what = Status(int(rods.status[lost[0]])).words
            raise SceneError(f"placement: rod {lost[0]} {what}: place it elsewhere, or shorten it")
    layout.ensembles[table.name] = rods


def _along(value: Any, count: int, rods: Any) -> Any:
    """Components of some of the rods."""
    if numbers_of(value):
        return each_rod(value, count, 3)[rods]
    rows = rows_of(value)
    return [rows[rod] for rod in np.arange(count)[rods]] if len(rows) == count else rows[0]


def _growth_of(growth: GrowthTable, rods: Any, count: int) -> dict[str, Any]:
    """The growth of some of the rods."""
    whole = growth.model_dump(exclude_none=True)
    each = {key: each_rod(whole[key], count)[rods] for key in ("rate", "until", "start") if key in whole}
    rows = {key: np.array(whole[key]) for key in ("time", "length") if key in whole}
    return whole | each | {key: values[rods] if values.ndim == 2 else values for key, values in rows.items()}


def _check_length(surface: Surface, table: FilamentsTable) -> None:
    low, high = surface.box
    circumference = math.pi * float((high - low).max()) / SPARE
    length = largest_length(table)
    if surface.closed and length > circumference:
        raise SceneError(
            f"length = {length:g}: larger than the circumference of the {surface.kind}, {circumference:.4g}: the "
            f"filament would overlap itself; use a shorter filament or a larger surface"
        )


def _refuse_crowd(surface: Surface, part: placement.Part | None, table: FilamentsTable, clearance: float) -> None:
    """Raises SceneError where the filaments of a table cannot fit; where half the room would do a glance is enough."""
    lengths = each_rod(table.length, table.count)
    rough = _room(surface, part, table, clearance, ROUGH_AREA)
    if area_for(lengths, clearance) > rough / 2:
        refuse_crowd_on(lengths, clearance, _room(surface, part, table, clearance, placement.AREA_CROSSINGS))


def _room(
    surface: Surface, part: placement.Part | None, table: FilamentsTable, clearance: float, crossings: int
) -> float:
    """An upper bound of the area that filaments can use; on an open surface they may reach beyond its box."""
    found = placement.area(surface, part, crossings)
    if surface.closed or np.isfinite(ends_of(surface)).all():
        return found
    sides = np.subtract(*surface.box[::-1])
    wider = np.sort(1 + (float(np.max(table.length)) + clearance) / sides)
    return found * float(np.prod(wider[1:]))


def _random(
    layout: Layout, table: FilamentsTable, part: placement.Part | None, build: Callable
) -> tuple[np.ndarray, np.ndarray]:
    """Uniform in area, isotropic in angle; with steric forces at least the core and a node spacing apart."""
    surface, rng, steric = layout.surface, layout.random(table.name), layout.scene.steric
    assert surface is not None
    has_end = bool(np.isfinite(ends_of(surface)).all())

    def drawn(count: int) -> tuple[np.ndarray, np.ndarray]:
        position = placement.uniform_points(surface, count, rng, part)
        return position, placement.isotropic_directions(surface, position, rng)

    def inside(rods: np.ndarray) -> tuple[tuple[np.ndarray, np.ndarray], Any]:
        """Poses and filaments, which lie inside the box in which φ is given."""
        position, direction = drawn(len(rods))
        made = build(position, direction, rods)
        for _ in range(MOST_ROUNDS):
            if not len(out := np.flatnonzero(made.status == Status.LEFT_DATA)):
                return (position, direction), made
            position[out], direction[out] = drawn(len(out))
            made = build(position, direction, rods)
        raise SceneError(f"length = {np.max(table.length):g}: no place was found where the filament is in the box")

    if steric is None:
        return inside(np.arange(table.count))[0] if has_end else drawn(table.count)
    spacing = float(np.max(table.length)) / (table.node_count - 1)

    def draw(rods: np.ndarray) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
        poses, made = inside(rods)
        return poses, made.position

    clearance = max(steric.core, spacing)
    _refuse_crowd(surface, part, table, clearance)
    space = OccupiedSpace(layout.lines, np.array(layout.scene.period))
    found = without_overlap(table.count, draw, clearance, space)
    layout.notes.append(f"{table.name}: {table.count} placed at random, uniform in area; {found.note}")
    position, direction = found.poses
    return position, direction

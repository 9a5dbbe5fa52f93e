"""Filaments of a scene on its membrane: their number of nodes and their places."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods.contact.capacity import area_for, refuse_crowd_on
from warp_rods.errors import SceneError
from warp_rods.membranes import sampling as placement
from warp_rods.membranes.built_in import SPARE
from warp_rods.membranes.surface import Surface, ends_of
from warp_rods.rods.bound.centre_lines import centre_lines
from warp_rods.rods.bound.checks import along_rods
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.per_rod import each_node, each_rod, named_numbers
from warp_rods.rods.status import Status
from warp_rods.scene.components import numbers_of, rows_of
from warp_rods.scene.filaments import FilamentsTable, GrowthTable
from warp_rods.simulation.criteria import criteria_of_filaments
from warp_rods.simulation.resolution import Resolution, largest_length, resolution
from warp_rods.simulation.samples import times_of
from warp_rods.simulation.surfaces import part_of

if TYPE_CHECKING:
    from warp_rods.simulation.layout import Layout

ROUGH_AREA = 400
"""Intersections from which an area is known to about a tenth."""
ROUGH_NODES = 65
"""Nodes with which lengths from files are known well, before the number of nodes is chosen."""
MOST_ROUNDS = 200
"""Rounds of drawing filaments again that stick out of the box of an open surface."""

Poses = tuple[np.ndarray, np.ndarray]


def nodes_of(layout: Layout, table: FilamentsTable) -> Resolution:
    """The number of nodes of a table, by the curvatures of the membrane where its filaments may be."""
    surface, end = layout.surface, layout.scene.time.end
    assert surface is not None  # a scene of filaments without a surface is refused
    table, bent = _with_length(layout, table), layout.bending_at_start(table.name)
    for time in times_of(surface, end):
        _check_length(surface.at(time), table)
    criteria = criteria_of_filaments(table, layout.samples(table.bodies), layout.scene.steric, bent, end)
    return resolution(table, criteria)


def _with_length(layout: Layout, table: FilamentsTable) -> FilamentsTable:
    """The table with the lengths of its shape, if that is from a file."""
    if table.shape is None:
        return table
    arrays, _ = layout.starts[table.name].at(ROUGH_NODES if isinstance(table.nodes, str) else table.nodes)
    return table.model_copy(update={"length": tuple(arrays["length"].tolist())})


def build(layout: Layout, table: FilamentsTable) -> None:
    """Add an ensemble of filaments to the layout."""
    surface, table = layout.surface, _with_length(layout, table)
    assert surface is not None

    def made(position: np.ndarray, direction: np.ndarray, **placed) -> BoundRods:
        growth = None if table.growth is None else _growth_of(table.growth, table.count)
        return BoundRods(
            surface, position, direction, nodes=table.node_count, ends=table.ends, growth=growth, device=layout.device,
            **layout.outside(table.name), **_parameters(table), **placed,
        )  # fmt: skip

    part = part_of(surface, table.bodies)
    if table.shape is not None:
        arrays, middle = layout.start_of(table), table.node_count // 2
        placed = {"geodesic_curvature": arrays["geodesic_curvature"]}
        rods = made(arrays["line"][:, middle], arrays["tangent"][:, middle], **placed)
        _refuse_lost(rods, "shape")
    elif (p := table.placement) is None or isinstance(p, str):
        rods = made(*_random(layout, table, part))
    else:
        geodesic: Any = p.geodesic_curvature
        if not isinstance(geodesic, str):
            geodesic = each_node(geodesic, table.count, table.node_count)
        rods = made(np.array(p.position), np.array(p.direction), at=p.at, geodesic_curvature=geodesic)
        _refuse_lost(rods, "placement")
    layout.ensembles[table.name] = rods


def _refuse_lost(rods: BoundRods, key: str) -> None:
    if len(lost := np.flatnonzero(rods.status)):
        what = Status(int(rods.status[lost[0]])).words
        raise SceneError(f"{key}: rod {lost[0]} {what}: place it elsewhere, or shorten it")


def _parameters(table: FilamentsTable) -> dict[str, Any]:
    """Length [rod], and stiffness, intrinsic strains and drag as ``BoundRods`` takes them."""
    threes = {name: _along(getattr(table, name), table.count) for name in ("stiffness", "intrinsic", "drag")}
    return {"length": each_rod(table.known_length, table.count), "parameters": table.parameters, **threes}


def _along(value: Any, count: int) -> Any:
    """Three components of the rods."""
    if numbers_of(value):
        return each_rod(value, count, 3)
    rows = rows_of(value)
    return rows if len(rows) == count else rows[0]


def _at_start(table: FilamentsTable) -> dict[str, np.ndarray]:
    """The same as values [rod] and [rod, 3] or [rod, node, 3] at t = 0."""
    given = _parameters(table)
    length, named = given.pop("length"), named_numbers(given.pop("parameters"), table.count)
    nodes = table.node_count
    found = along_rods(given, table.count, nodes, grows=False, named=named)
    return {"length": length, **{k: p.at(0.0, nodes) if p.varies else p.values for k, p in found.items()}}


def _growth_of(growth: GrowthTable, count: int) -> dict[str, Any]:
    """The growth of each rod."""
    whole = growth.model_dump(exclude_none=True)
    each = {key: each_rod(whole[key], count) for key in ("rate", "until", "start") if key in whole}
    return whole | each | {key: np.array(whole[key]) for key in ("time", "length") if key in whole}


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
    lengths = each_rod(table.known_length, table.count)
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
    wider = np.sort(1 + (float(np.max(table.known_length)) + clearance) / sides)
    return found * float(np.prod(wider[1:]))


def _random(layout: Layout, table: FilamentsTable, part: placement.Part | None) -> tuple[np.ndarray, np.ndarray]:
    """Uniform in area, isotropic in angle; with steric forces at least the core and a node spacing apart."""
    surface, steric = layout.surface, layout.scene.steric
    assert surface is not None
    has_end = bool(np.isfinite(ends_of(surface)).all())
    parameters, clamped = _at_start(table), (table.ends[0] == "clamped", table.ends[1] == "clamped")

    def drawn(rng: np.random.Generator, count: int) -> Poses:
        position = placement.uniform_points(surface, count, rng, part)
        return position, placement.isotropic_directions(surface, position, rng)

    def laid_out(position: np.ndarray, direction: np.ndarray, rods: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        own = {name: values[rods] for name, values in parameters.items()}
        return centre_lines(surface, position, direction, table.node_count, own, clamped, layout.device)

    def inside(rng: np.random.Generator, rods: np.ndarray) -> tuple[Poses, np.ndarray]:
        """Poses and centre lines of filaments that lie inside the box in which φ is given."""
        position, direction = drawn(rng, len(rods))
        lines, status = laid_out(position, direction, rods)
        for _ in range(MOST_ROUNDS):
            if not len(out := np.flatnonzero(status == Status.LEFT_DATA)):
                return (position, direction), lines
            position[out], direction[out] = drawn(rng, len(out))
            lines[out], status[out] = laid_out(position[out], direction[out], rods[out])
        raise SceneError(
            f"length = {np.max(table.known_length):g}: no place was found where the filament is in the box"
        )

    if steric is None:
        parts = layout.parts(table.name, table.count)
        poses = [inside(rng, rods)[0] if has_end else drawn(rng, len(rods)) for rng, rods in parts]
        return np.concatenate([one[0] for one in poses]), np.concatenate([one[1] for one in poses])
    spacing = float(np.max(table.known_length)) / (table.node_count - 1)

    from warp_rods.contact.overlap import without_overlap
    from warp_rods.contact.segments import OccupiedSpace

    clearance = max(steric.core, spacing)
    _refuse_crowd(surface, part, table, clearance)
    space = OccupiedSpace(layout.lines, np.array(layout.scene.period))
    found = without_overlap(table.count, partial(inside, layout.random(table.name)), clearance, space)
    layout.notes.append(f"{table.name}: {table.count} placed at random, uniform in area; {found.note}")
    position, direction = found.poses
    return position, direction

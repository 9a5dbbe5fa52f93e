"""The ensembles of a scene on a device. One row of ``BUILDERS`` for each kind of rod."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from warp_rods.contact.arrangements import arranged_poses, count_outside, given_poses
from warp_rods.contact.barrier import barrier_warnings
from warp_rods.contact.overlap import overlapping, without_overlap
from warp_rods.contact.segments import OccupiedSpace
from warp_rods.errors import SceneError
from warp_rods.membranes import sampling as placement
from warp_rods.membranes.built_in import SPARE
from warp_rods.membranes.catalogue import GIVEN
from warp_rods.membranes.surface import Surface, ends_of
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.per_rod import each_node, each_rod
from warp_rods.rods.status import Status
from warp_rods.rods.step_limits import StepLimit, bent_start_limit, membrane_limit, wall_limit
from warp_rods.scene.filaments import FilamentsTable, GrowthTable
from warp_rods.scene.scene import Scene
from warp_rods.scene.swimmers import SwimmersTable
from warp_rods.scene.tables import Steric
from warp_rods.simulation.criteria import criteria_of_filaments, criteria_of_swimmers
from warp_rods.simulation.memory import check_memory
from warp_rods.simulation.resolution import Resolution, largest_length, resolution
from warp_rods.simulation.samples import Sample, samples_of, times_of
from warp_rods.simulation.surfaces import build_surfaces, lines_on_data, part_of

MOST_ROUNDS = 200
"""Rounds of drawing filaments again that stick out of the box of an open surface."""
CLOSE_START = 0.5
"""Users are warned of rods that start closer than this, in units of the steric core; the force between crossing rods is
largest at about that distance."""


@dataclass
class Layout:
    """Ensembles by name, their bounds on the time step, and lines for the user."""

    scene: Scene
    """With the numbers of nodes that were chosen."""
    device: Any
    surface: Surface | None = None
    """The membrane."""
    container: Surface | None = None
    """The surface of the box."""
    ensembles: dict[str, Any] = field(default_factory=dict)
    limits: dict[str, StepLimit] = field(default_factory=dict)
    samples: dict[str, list[Sample]] = field(default_factory=dict)
    """The membrane where filaments may be, by name."""
    arranged: dict[str, dict[str, dict[str, np.ndarray]]] = field(default_factory=dict)
    """Poses of swimmers that are placed together, by arrangement and name."""
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    def random(self, name: str) -> np.random.Generator:
        """A random generator for one ensemble, so that an additional ensemble does not change the others."""
        return np.random.default_rng(self.seed(name))

    def seed(self, name: str) -> list[int]:
        """The seed of that generator."""
        return [self.scene.seed, *name.encode()]

    @property
    def lines(self) -> list[np.ndarray]:
        """Centre lines [rod, node, 3] of all ensembles so far."""
        return [rods.position for rods in self.ensembles.values()]


def lay_out(scene: Scene, device) -> Layout:
    """Make every ensemble of the scene on the device; raises SceneError naming the table that is impossible."""
    check_memory(scene)
    layout = Layout(scene, device, *build_surfaces(scene))
    for path, surface in (("surface", layout.surface), ("box.surface", layout.container)):
        notes, warnings = lines_on_data(scene, path, surface)
        layout.notes += notes
        layout.warnings += warnings
    if layout.surface and layout.surface.kind in GIVEN and not layout.surface.closed:
        layout.notes.append(
            "surface: φ changes sign on the faces of its box, so the surface is an open patch that ends at the box"
        )
    scene = _choose_nodes(layout)
    check_memory(scene)
    tables = [(kind, index, table) for kind in BUILDERS for index, table in enumerate(getattr(scene, kind))]
    # Given placements come first, because rods placed at random must keep their distance from them.
    for kind, index, table in sorted(tables, key=lambda row: isinstance(row[2].placement, str)):
        with _naming(kind, index):
            BUILDERS[kind].build(layout, table)
    layout.ensembles = {table.name: layout.ensembles[table.name] for _, _, table in tables}
    if any(scene.period):
        sides = " × ".join(f"{side:.4g}" for side in scene.period if side)
        layout.notes.append(f"box: periods {sides}, {sum(t.count for t in scene.swimmers)} swimmers")
    for table in scene.swimmers:
        if out := count_outside(scene, layout.container, layout.ensembles[table.name].position):
            layout.warnings.append(
                f"{table.name}: {out} rods start beyond a wall of the box, which will push them hard; place them inside"
            )
    if scene.steric and scene.steric.strength > 0:
        layout.warnings += _steric_warnings(layout, scene.steric)
    return layout


@contextmanager
def _naming(kind: str, index: int) -> Iterator[None]:
    """Put the name of a table in front of its faults."""
    try:
        yield
    except SceneError as error:
        raise SceneError(f"{kind}[{index}].{error}") from None


def _choose_nodes(layout: Layout) -> Scene:
    """Put the numbers of nodes into the scene, with a note for each one chosen and a warning for each too small."""
    chosen: dict[str, tuple] = {}
    for kind, row in BUILDERS.items():
        tables = []
        for index, table in enumerate(getattr(layout.scene, kind)):
            with _naming(kind, index):
                found = row.resolve(layout, table)
            layout.notes += found.notes
            layout.warnings += found.warnings
            tables.append(table.model_copy(update={"nodes": found.nodes}))
        chosen[kind] = tuple(tables)
    layout.scene = layout.scene.model_copy(update=chosen)
    return layout.scene


def _steric_warnings(layout: Layout, steric: Steric) -> list[str]:
    """Warnings if rods may pass through each other."""
    found = []
    for name, rods in layout.ensembles.items():
        # No spacing: that of the nodes is a criterion of their number.
        found += barrier_warnings(name, 0.0, steric.strength, steric.range, steric.core, isinstance(rods, FreeRods))
    period = min((side for side in layout.scene.period if side), default=np.inf)
    if layout.scene.swimmers and period < 1 + steric.core:
        found.append(
            f"the box is {period:.3g} wide, less than the length of a swimmer plus the core: a swimmer may touch its "
            f"own image; make the box wider"
        )
    pairs = overlapping(layout.lines, CLOSE_START * steric.core, np.array(layout.scene.period))
    if pairs:
        found.append(
            f"{pairs} pairs of rods start closer than {CLOSE_START:g} of the steric core, where the force between them "
            f"is weak, and zero where they coincide: place them farther apart, or at random in a [box]"
        )
    return found


def _filament_nodes(layout: Layout, table: FilamentsTable) -> Resolution:
    surface, end = layout.surface, layout.scene.time.end
    assert surface is not None  # a scene of filaments without a surface is refused
    for time in times_of(surface, end):
        _check_length(surface.at(time), table)
    samples = layout.samples[table.name] = samples_of(surface, end, part_of(surface, table.bodies))
    principal = np.concatenate([sample.principal for sample in samples])
    return resolution(table, criteria_of_filaments(table, principal, layout.scene.steric))


def _filaments(layout: Layout, table: FilamentsTable) -> None:
    surface = layout.surface
    assert surface is not None

    def build(position: np.ndarray, direction: np.ndarray, rods: Any = slice(None), **placed) -> BoundRods:
        parameters: dict[str, Any] = {
            "length": each_rod(table.length, table.count)[rods],
            **{k: each_rod(getattr(table, k), table.count, 3)[rods] for k in ("stiffness", "intrinsic", "drag")},
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
    limits = [bent_start_limit(rods, rods.strain[..., 2])]
    for now in layout.samples[table.name]:
        nodes = rods.position if now.time == 0 else None
        limits.append(membrane_limit(now.surface, rods, nodes, now.uniform, now.curved))
    layout.limits[table.name] = min(limits, key=lambda limit: limit.step)


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

    space = OccupiedSpace(layout.lines, np.array(layout.scene.period))
    found = without_overlap(table.count, draw, max(steric.core, spacing), space)
    layout.notes.append(f"{table.name}: {table.count} placed at random, uniform in area; {found.note}")
    position, direction = found.poses
    return position, direction


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
    tables = [table for table in layout.scene.swimmers if table.placement == arrangement]
    shapes = {table.name: _free_rods(layout, table).position for table in tables}
    rng = layout.random(arrangement)
    poses, note = arranged_poses(arrangement, layout.scene, layout.container, shapes, layout.lines, rng)
    layout.notes.append(f"{', '.join(shapes)}: placed {arrangement}; {note}")
    return poses


def _swimmer_nodes(layout: Layout, table: SwimmersTable) -> Resolution:
    return resolution(table, criteria_of_swimmers(table, layout.scene.steric))


def _swimmers(layout: Layout, table: SwimmersTable) -> None:
    placed: dict[str, np.ndarray] = {}
    if isinstance(table.placement, str):
        if table.placement not in layout.arranged:
            layout.arranged[table.placement] = _arranged(layout, table.placement)
        placed = layout.arranged[table.placement][table.name]
    elif table.placement is not None:
        placed = given_poses(table.placement.position, table.placement.direction)
    layout.ensembles[table.name] = _free_rods(layout, table, **placed)
    layout.limits[table.name] = layout.ensembles[table.name].step_limit
    wall = layout.scene.box and layout.scene.box.wall
    if not (table.symmetric or layout.scene.steric or wall):
        layout.notes += _symmetric_start(table, layout.ensembles[table.name])
    if wall:
        drag = float(np.min(table.drag_ratio))
        layout.limits[f"{table.name} (walls)"] = wall_limit(wall.strength, drag)


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


@dataclass(frozen=True)
class Builder:
    """Functions of the layout and a table: ``resolve`` chooses its number of nodes, ``build`` adds its ensemble."""

    resolve: Callable[[Layout, Any], Resolution]
    build: Callable[[Layout, Any], None]


BUILDERS = {"filaments": Builder(_filament_nodes, _filaments), "swimmers": Builder(_swimmer_nodes, _swimmers)}
"""By the name of the table in the scene."""

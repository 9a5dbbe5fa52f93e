"""The ensembles of a scene on a device. One row of ``BUILDERS`` for each kind of rod."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from warp_rods.contact.arrangements import arranged_poses, count_outside, given_poses
from warp_rods.contact.barrier import barrier_warnings
from warp_rods.contact.overlap import overlapping
from warp_rods.errors import SceneError
from warp_rods.membranes.catalogue import GIVEN
from warp_rods.membranes.surface import Surface
from warp_rods.rods.free.rods import FreeRods
from warp_rods.scene.along import given_along
from warp_rods.scene.ends import given_end
from warp_rods.scene.scene import Scene
from warp_rods.scene.swimmers import NaturalBend, SwimmersTable
from warp_rods.scene.tables import Steric
from warp_rods.simulation.criteria import criteria_of_swimmers
from warp_rods.simulation.estimates import check_memory
from warp_rods.simulation.filaments import build_filaments, nodes_of_filaments
from warp_rods.simulation.resolution import Resolution, resolution
from warp_rods.simulation.surfaces import build_surfaces, lines_on_data

CLOSE_START = 0.5
"""Users are warned of rods that start closer than this, in units of the steric core; the force between crossing rods is
largest at about that distance."""


@dataclass
class Layout:
    """Ensembles by name, and lines for the user."""

    scene: Scene
    """With the numbers of nodes that were chosen."""
    device: Any
    surface: Surface | None = None
    """The membrane."""
    container: Surface | None = None
    """The surface of the box."""
    ensembles: dict[str, Any] = field(default_factory=dict)
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

    def outside(self, name: str) -> dict[str, Any]:
        """What acts on an ensemble from outside, as ensembles take it."""
        scene = self.scene
        forces = [table for table in scene.forces if table.on is None or name in table.on]
        gravity = None if scene.gravity is None else scene.gravity.force
        return {"flow": scene.flow, "gravity": gravity, "forces": forces}

    @property
    def lines(self) -> list[np.ndarray]:
        """Centre lines [rod, node, 3] of all ensembles so far."""
        return [rods.position for rods in self.ensembles.values()]


def lay_out(scene: Scene, device) -> Layout:
    """Make every ensemble of the scene on the device; raises SceneError naming the table that is impossible."""
    check_memory(scene, device)
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
    check_memory(scene, device)
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
        if isinstance(rods, FreeRods):
            found += barrier_warnings(name, steric.strength, steric.range, steric.core)
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


def _free_rods(layout: Layout, table: SwimmersTable, **placed) -> FreeRods:
    return FreeRods(
        table.count,
        table.node_count,
        moment=table.moment,
        symmetric=table.symmetric,
        **_along(table),
        flagella=table.flagella.model_dump(),
        shape=table.shape.model_dump(exclude_none=True) | {"seed": layout.seed(table.name)},
        **layout.outside(table.name),
        **placed,
        device=layout.device,
    )


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
    wall = layout.scene.box and layout.scene.box.wall
    if not (table.symmetric or layout.scene.steric or wall):
        layout.notes += _symmetric_start(table, layout.ensembles[table.name])


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


BUILDERS = {"filaments": Builder(nodes_of_filaments, build_filaments), "swimmers": Builder(_swimmer_nodes, _swimmers)}
"""By the name of the table in the scene."""

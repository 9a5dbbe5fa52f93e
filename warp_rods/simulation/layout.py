"""The ensembles of a scene on a device. One row of ``BUILDERS`` for each kind of rod."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.membranes.catalogue import GIVEN
from warp_rods.membranes.surface import Surface
from warp_rods.scene.scene import Scene
from warp_rods.scene.tables import Steric
from warp_rods.simulation.estimates import check_memory
from warp_rods.simulation.resolution import Resolution, largest_length
from warp_rods.simulation.samples import Sample, samples_of
from warp_rods.simulation.start_arrays import Arrays, Given, largest_bending
from warp_rods.simulation.starts import read_start
from warp_rods.simulation.surfaces import build_surfaces, lines_on_data, part_of
from warp_rods.simulation.units import lines_of_units

NODES_OF_BENDING = 257
"""Nodes at which the curvature of a start from a file is found before its number of nodes is chosen."""
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
    starts: dict[str, Given] = field(default_factory=dict)
    """Shapes that are from files, by the name of the ensemble."""
    sampled: dict[Any, list[Sample]] = field(default_factory=dict)
    """Samples of the membrane, or of some of its bodies, until the end of the run."""
    notes: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    seeds: tuple[int, ...] = ()
    """Of equal parts of each ensemble, placed as in scenes of their own with these seeds; none: one part."""

    def start_of(self, table: Any) -> Arrays:
        """The start of an ensemble from a file, at the nodes of its table; tells what was done with it."""
        arrays, told = self.starts[table.name].at(table.node_count)
        self.notes += [line for line in told if line not in self.notes]
        return arrays

    def bending_at_start(self, name: str) -> float:
        """The largest curvature at a node of a start from a file, 0 of others; 1/length."""
        return largest_bending(self.starts[name].at(NODES_OF_BENDING)[0]) if name in self.starts else 0.0

    def samples(self, bodies: Sequence[int] | None) -> list[Sample]:
        """Samples of the membrane, or of these bodies of it, at some times of the run."""
        assert self.surface is not None
        key = (self.scene.time.end, bodies)
        if key not in self.sampled:
            self.sampled[key] = samples_of(self.surface, self.scene.time.end, part_of(self.surface, bodies))
        return self.sampled[key]

    def parts(self, name: str, count: int) -> list[tuple[np.random.Generator, np.ndarray]]:
        """A random generator for each part of an ensemble, and the numbers of its rods."""
        seeds = self.seeds or (self.scene.seed,)
        rods = np.arange(count).reshape(len(seeds), -1)
        return [(np.random.default_rng([seed, *name.encode()]), part) for seed, part in zip(seeds, rods, strict=True)]

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


def lay_out(scene: Scene, device, seeds: Sequence[int] = ()) -> Layout:
    """Make every ensemble of the scene on the device; raises SceneError naming the table that is impossible.

    seeds: of equal parts of each ensemble that do not feel each other, instead of the seed of the scene.
    """
    check_memory(scene, device)
    layout = Layout(scene, device, *build_surfaces(scene), seeds=tuple(seeds))
    layout.notes += lines_of_units(scene)
    _read_starts(layout)
    _tell_of_surfaces(layout)
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
    if scene.box and scene.box.wall:
        layout.warnings += _beyond_walls(layout)
    if scene.steric and scene.steric.strength > 0:
        layout.warnings += _steric_warnings(layout, scene.steric)
        layout.warnings += _own_images(scene, scene.steric.core)
    return layout


def warnings_of_apart(scenes: Sequence[Scene], surface: Surface | None) -> list[list[str]]:
    """The warnings of ``lay_out`` of scenes whose rods do not feel each other, nor walls, without laying them out.

    surface: the membrane, at rest or moving, of all of them. Raises SceneError as ``lay_out`` does.
    """
    found, sampled = [], dict[Any, list[Sample]]()
    for scene in scenes:
        layout = Layout(scene, None, surface, sampled=sampled)
        _read_starts(layout)
        _tell_of_surfaces(layout)
        _choose_nodes(layout)
        found.append(layout.warnings)
    return found


def _tell_of_surfaces(layout: Layout) -> None:
    """Notes and warnings on the files of the surfaces."""
    for path, surface in (("surface", layout.surface), ("box.surface", layout.container)):
        notes, warnings = lines_on_data(layout.scene, path, surface)
        layout.notes += notes
        layout.warnings += warnings


def _own_images(scene: Scene, core: float) -> list[str]:
    """Warnings of rods that reach their own image in the next period, by the largest length that they will have."""
    period = min((side for side in scene.period if side), default=np.inf)
    reach = {table.name: largest_length(table) + core for kind in BUILDERS for table in getattr(scene, kind)}
    return [
        f"{name}: a rod that lies along a period of the box, {period:.4g}, reaches its own image, as it is "
        f"{length:.4g} long with its core: make the box longer"
        for name, length in reach.items()
        if length > period
    ]


def _beyond_walls(layout: Layout) -> list[str]:
    """Warnings of swimmers that start beyond a wall."""
    from warp_rods.contact.arrangements import count_outside

    found = []
    for table in layout.scene.swimmers:
        if out := count_outside(layout.scene, layout.container, layout.ensembles[table.name].position):
            found.append(
                f"{table.name}: {out} rods start beyond a wall of the box, which will push them hard; place them inside"
            )
    return found


@contextmanager
def _naming(kind: str, index: int) -> Iterator[None]:
    """Put the name of a table in front of its faults."""
    try:
        yield
    except SceneError as error:
        raise SceneError(f"{kind}[{index}].{error}") from None


def _read_starts(layout: Layout) -> None:
    """Read the shapes that are from files."""
    for kind in ("filaments", "swimmers"):
        for index, table in enumerate(getattr(layout.scene, kind)):
            if table.shape is not None and table.shape.from_file:
                with _naming(kind, index):
                    layout.starts[table.name] = read_start(table, layout.scene, layout.surface)


def _choose_nodes(layout: Layout) -> Scene:
    """Put the numbers of nodes into the scene, with a note for each one chosen and a warning for each too small."""
    chosen: dict[str, tuple] = {}
    for kind, row in BUILDERS.items():
        tables = []
        for index, table in enumerate(getattr(layout.scene, kind)):
            with _naming(kind, index):
                found = row.nodes_of(layout, table)
            layout.notes += found.notes
            layout.warnings += found.warnings
            tables.append(table.model_copy(update={"nodes": found.nodes}))
        chosen[kind] = tuple(tables)
    layout.scene = layout.scene.model_copy(update=chosen)
    return layout.scene


def _steric_warnings(layout: Layout, steric: Steric) -> list[str]:
    """Warnings if rods may pass through each other; spacings of nodes are a criterion of their number."""
    from warp_rods.contact.barrier import barrier_warnings
    from warp_rods.contact.overlap import overlapping

    found = []
    for table in layout.scene.swimmers:
        found += barrier_warnings(table.name, steric.strength, steric.range, steric.core)
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


@dataclass(frozen=True)
class Builder:
    """The module beside this one that builds a kind of rod; it is imported with its kernels for scenes that have some.

    Its functions of the layout and a table: ``nodes_of`` chooses the number of nodes, ``build`` adds the ensemble.
    """

    module: str

    @property
    def nodes_of(self) -> Callable[[Layout, Any], Resolution]:
        """The function of this name."""
        return import_module(f"warp_rods.simulation.{self.module}").nodes_of  # type: ignore[no-any-return]

    @property
    def build(self) -> Callable[[Layout, Any], None]:
        """The function of this name."""
        return import_module(f"warp_rods.simulation.{self.module}").build  # type: ignore[no-any-return]


BUILDERS = {kind: Builder(kind) for kind in ("filaments", "swimmers", "cosserat")}
"""By the name of the table in the scene."""

"""How swimmers stand at the start of a crowded scene: one row of ``ARRANGEMENTS`` an arrangement."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import interp1d
from scipy.spatial.transform import Rotation

from warp_rods.contact.overlap import Space, pushed_apart, without_overlap
from warp_rods.errors import SceneError
from warp_rods.membranes.surface import Surface
from warp_rods.scene.scene import Scene

TRIES = 1000
"""Times that rods which stick out of a container are drawn again before giving up."""
CLOSE = (0.5, 0.75)
"""Of the core and of the spacing of nodes: how close swimmers may be drawn that are pushed apart after. Crossing rods
have nodes as close as 0.71 spacings."""
JAMS = 5
"""Times that swimmers are drawn anew when they jam where they are pushed apart."""
LANE = 1.0
"""About how wide a lane is, in lengths of a swimmer."""

Poses = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Room:
    """The part of space that middles of swimmers are drawn from: a box from ``low`` to ``high`` [3], in a container
    what of it lies on the right side of its surface by ``clearance``."""

    low: np.ndarray
    high: np.ndarray
    flat: bool = False
    """Whether swimmers lie in planes of equal z: in a slab."""
    container: Surface | None = None
    clearance: float = 0.0

    @classmethod
    def of(cls, scene: Scene, container: Surface | None, clearance: float) -> Room:
        """The room that a scene's box leaves; raises SceneError for one without bounds."""
        box, period = scene.box, np.array(scene.period)
        assert box is not None  # a scene is refused that arranges swimmers without one
        if container:
            if box.side == "outside" or not container.closed:
                raise SceneError("placement: this container has no bounds: give position and direction of each rod")
            return cls(*container.box, container=container, clearance=clearance)
        if box.kind == "slab":
            if not period[:2].all():
                raise SceneError("placement: the slab has no bounds: give box.size or box.fraction")
            assert box.height is not None and box.wall is not None
            period[2] = max(box.height - 2 * box.wall.range, 0.0)
        return cls(-period / 2, period / 2, flat=box.kind == "slab")

    def points(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Uniform in the box [count, 3]."""
        return rng.uniform(self.low, self.high, size=(count, 3))

    def draw(self, arrangement: str, shapes: np.ndarray, rng: np.random.Generator) -> tuple[Poses, np.ndarray]:
        """Poses for rods with centre lines ``shapes`` [rod, node, 3], all inside, and those lines in space."""
        arrange = ARRANGEMENTS[arrangement]
        position, rotation = arrange(self, len(shapes), rng)
        lines = _laid_out(position, rotation, shapes)
        for _ in range(TRIES):
            out = np.flatnonzero(~self.holds(lines))
            if not len(out):
                return (position, rotation), lines
            position[out], rotation[out] = arrange(self, len(out), rng)
            lines[out] = _laid_out(position[out], rotation[out], shapes[out])
        raise SceneError(
            f"{len(out)} rods found no place inside the container, which may be too small for their length: place fewer"
        )

    def holds(self, lines: np.ndarray) -> np.ndarray:
        """Whether a container holds all of each centre line [rod, node, 3]; without one, yes [rod]."""
        if self.container is None:
            return np.ones(len(lines), dtype=bool)
        gradient = np.linalg.norm(self.container.gradient(lines), axis=-1)
        return (self.container.phi(lines) < -self.clearance * gradient).all(axis=1)

    def isotropic(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Frames [count, 3, 3] turned at random; those that lie flat about z alone."""
        if self.flat:
            return about_z(rng.uniform(0, 2 * np.pi, count))
        return Rotation.random(count, rng=rng).as_matrix()


def about_z(angle: np.ndarray) -> np.ndarray:
    """Frames [n, 3, 3] along x turned about z by angles [n]."""
    return Rotation.from_euler("z", angle[:, None]).as_matrix()


def random(room: Room, count: int, rng: np.random.Generator) -> Poses:
    """Uniform and isotropic."""
    return room.points(count, rng), room.isotropic(count, rng)


def aligned(room: Room, count: int, rng: np.random.Generator) -> Poses:
    """Uniform, all along x."""
    return room.points(count, rng), about_z(np.zeros(count))


def polar_lanes(room: Room, count: int, rng: np.random.Generator) -> Poses:
    """Lanes along x of about a swimmer's length in y, by turns heading to +x and −x."""
    points = room.points(count, rng)
    width = room.high[1] - room.low[1]
    lanes = 2 * max(1, round(width / (2 * LANE)))
    lane = np.floor((points[:, 1] - room.low[1]) / width * lanes)
    return points, about_z(np.pi * (lane % 2))


def nematic_lanes(room: Room, count: int, rng: np.random.Generator) -> Poses:
    """All along the x axis, each heading to +x or −x by chance."""
    return room.points(count, rng), about_z(np.pi * rng.integers(0, 2, count))


def bands(room: Room, count: int, rng: np.random.Generator) -> Poses:
    """Two bands that meet: those at x < 0 head to +x, the others to −x."""
    points = room.points(count, rng)
    middle = (room.low[0] + room.high[0]) / 2
    return points, about_z(np.where(points[:, 0] < middle, 0.0, np.pi))


ARRANGEMENTS: dict[str, Callable[[Room, int, np.random.Generator], Poses]] = {
    "random": random,
    "aligned": aligned,
    "polar lanes": polar_lanes,
    "nematic lanes": nematic_lanes,
    "bands": bands,
}
"""By ``placement``: functions that draw middle points [count, 3] and frames [count, 3, 3], tangent first."""


def given(position: Any, direction: Any) -> dict[str, np.ndarray]:
    """Middle points [rod, 3], and frames turned from x to directions [rod, 3] by the shortest way, where given."""
    placed = {"position": np.array(position)}
    if direction is not None:
        turns = [Rotation.align_vectors(d[None], [[1.0, 0.0, 0.0]])[0].as_matrix() for d in np.array(direction)]
        placed["rotation"] = np.array(turns)
    return placed


def arranged(
    arrangement: str,
    scene: Scene,
    container: Surface | None,
    shapes: Mapping[str, np.ndarray],
    others: np.ndarray,
    rng: np.random.Generator,
) -> tuple[dict[str, dict[str, np.ndarray]], str]:
    """Middle points and frames of swimmers of several ensembles that find their places together, and a note.

    container: that of the scene's box. shapes: by ensemble, centre lines [rod, node, 3] about their middles. With
    sterics no rod is closer to another, or to points ``others`` [n, 3], than the core and a node spacing. Raises
    SceneError where they do not fit.
    """
    nodes = max(lines.shape[1] for lines in shapes.values())
    # In the order of chance, so that no ensemble gets the better places.
    every = np.concatenate([_resampled(lines, nodes) for lines in shapes.values()])
    order = rng.permutation(len(every))
    room = Room.of(scene, container, scene.steric.core / 2 if scene.steric else 0.0)
    try:
        poses, note = _find(arrangement, room, scene, every[order], others, rng)
    except SceneError as error:
        raise SceneError(f'placement = "{arrangement}": {error}, or make the box larger') from None
    back = np.argsort(order)
    ends = np.cumsum([len(lines) for lines in shapes.values()])[:-1]
    split = [np.split(part[back], ends) for part in poses]
    return {name: {"position": p, "rotation": R} for name, p, R in zip(shapes, *split, strict=True)}, note


def _find(
    arrangement: str, room: Room, scene: Scene, shapes: np.ndarray, others: np.ndarray, rng: np.random.Generator
) -> tuple[Poses, str]:
    """Poses of rods with centre lines ``shapes`` [rod, node, 3], and a note."""
    core = scene.steric.core if scene.steric else 0.0
    spacing = 1 / (shapes.shape[1] - 1)
    clearance = max(core, spacing)

    def draw(rods: np.ndarray) -> tuple[Poses, np.ndarray]:
        return room.draw(arrangement, shapes[rods], rng)

    if scene.steric is None:
        return draw(np.arange(len(shapes)))[0], "there are no sterics, so that they may overlap"
    space = Space(others, np.array(scene.period))
    if arrangement != "random" or room.container:
        found = without_overlap(len(shapes), draw, clearance, space)
        return found.poses, found.note  # type: ignore[return-value]
    close = max(CLOSE[0] * core, CLOSE[1] * spacing)
    # Rods that lie flat cannot be pushed out from under each other: those that cross do so a clearance apart at once.
    squeeze = np.array([1.0, 1.0, close / clearance if room.flat else 1.0])

    def squeezed(rods: np.ndarray) -> tuple[Poses, np.ndarray]:
        poses, lines = draw(rods)
        return poses, lines * squeeze

    for _ in range(JAMS):
        drawn = without_overlap(len(shapes), squeezed, close, Space(others * squeeze, space.period))
        position, rotation = drawn.poses
        heights = (float(room.low[2]), float(room.high[2])) if room.flat else None
        poses = pushed_apart(position, rotation, shapes, clearance, space, heights)
        if poses:
            return poses, f"pushed apart to {clearance:.3g}"
    raise SceneError(f"count = {len(shapes)}: rods jam before they are {clearance:g} apart; place fewer")


def _resampled(lines: np.ndarray, nodes: int) -> np.ndarray:
    """Centre lines [rod, node, 3] at another number of nodes, linear between them."""
    old, new = np.linspace(0, 1, lines.shape[1]), np.linspace(0, 1, nodes)
    return lines if len(old) == nodes else interp1d(old, lines, axis=1)(new)


def outside(scene: Scene, container: Surface | None, lines: np.ndarray) -> int:
    """How many of the rods with centre lines [rod, node, 3] reach through a wall of the scene's box."""
    box = scene.box
    if box is None or box.wall is None:
        return 0
    if container is None:
        assert box.height is not None
        out = np.abs(lines[..., 2]) > box.height / 2
    else:
        phi = container.phi(lines)
        out = phi < 0 if box.side == "outside" else phi > 0
    return int(out.any(axis=1).sum())


def _laid_out(position: np.ndarray, rotation: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """Centre lines [rod, node, 3] in space."""
    return position[:, None] + np.einsum("rij,rnj->rni", rotation, shapes)

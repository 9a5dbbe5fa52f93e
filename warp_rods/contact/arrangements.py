"""Arrangements of swimmers in a box at the start: one row of ``ARRANGEMENTS`` for each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from warp_rods.contact.capacity import extents, refuse_crowd
from warp_rods.contact.overlap import without_overlap
from warp_rods.contact.push import pushed_apart
from warp_rods.contact.rooms import WALLED, Walled, turned_to
from warp_rods.contact.rotations import about_z, isotropic, with_chords_along_x
from warp_rods.contact.segments import OccupiedSpace
from warp_rods.contact.walls import NO_CAPS, caps_of
from warp_rods.errors import SceneError
from warp_rods.membranes.surface import Surface
from warp_rods.scene.scene import Scene

MOST_DRAWS = 1000
"""Rounds of drawing rods again that stick out of a container."""
CLOSE = 0.5
"""Least distance of swimmers before they are pushed apart, in units of the clearance; crossing rods have none."""
MOST_ATTEMPTS = 5
"""Attempts to push swimmers apart, each with new draws."""
VOLUME_POINTS, VOLUME_ERROR = 20_000, 0.01
"""Random points by which the volume of a container is estimated, and three times the standard error of the share of its
box that this leaves."""
LANE = 1.0
"""Approximate width of a lane, in lengths of a swimmer."""

Poses = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Region:
    """The region in which middles of swimmers are drawn: the box from ``low`` to ``high`` [3].

    In a ``container`` whole rods must lie inside its surface, by ``clearance``, and in a ``room`` inside its walls. A
    pore or duct is drawn along x, and then turned to its axis.
    """

    low: np.ndarray
    high: np.ndarray
    flat: bool = False
    """Whether swimmers lie in planes of constant z, as in a slab."""
    container: Surface | None = None
    clearance: float = 0.0
    caps: np.ndarray = field(default_factory=NO_CAPS.copy)
    """Corners [2, 3] of the box whose finite faces close an open container."""
    room: Walled | None = None

    @classmethod
    def of(cls, scene: Scene, container: Surface | None, clearance: float) -> Region:
        """The region inside the box of a scene; raises SceneError for a box without bounds."""
        box, period = scene.box, np.array(scene.period)
        assert box is not None  # a scene that arranges swimmers without a box is refused
        if container:
            caps = caps_of(container, box.side == "outside")
            if box.side == "outside" or not (container.closed or np.isfinite(caps).any()):
                raise SceneError("placement: this container has no bounds: give position and direction of each rod")
            return cls(*container.box, container=container, clearance=clearance, caps=caps)
        if box.kind in WALLED:
            assert box.wall is not None
            clearance = max(clearance, box.wall.range)
            room = WALLED[box.kind](box)
            sides, volume = room.free(clearance)
            if not volume:
                if not box.length:
                    raise SceneError(f"placement: the {box.kind} is endless: give box.length")
                raise SceneError(f"placement: {clearance:g} from all walls is no room: make the {box.kind} wider")
            return cls(-sides / 2, sides / 2, clearance=clearance, room=room)
        if box.kind == "slab":
            if not period[:2].all():
                raise SceneError("placement: the slab has no bounds: give box.size or box.fraction")
            assert box.height is not None and box.wall is not None
            period[2] = max(box.height - 2 * box.wall.range, 0.0)
        return cls(-period / 2, period / 2, flat=box.kind == "slab")

    def volume(self, clearance: float) -> float:
        """An upper bound of the volume that rods with a clearance between them can use, their surroundings included."""
        if self.room:
            return self.room.free(self.clearance - clearance / 2)[1]
        sides = self.high - self.low
        if self.container is None:
            return float(np.prod(sides + np.array([0.0, 0.0, clearance if self.flat else 0.0])))
        points = np.random.default_rng(0).uniform(self.low, self.high, size=(VOLUME_POINTS, 3))
        inside = (self.container.phi(points) < 0).mean()
        return float(np.prod(sides) * (inside + VOLUME_ERROR))

    def points(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Uniform in the box [count, 3]."""
        return rng.uniform(self.low, self.high, size=(count, 3))

    def draw(self, arrangement: str, shapes: np.ndarray, rng: np.random.Generator) -> tuple[Poses, np.ndarray]:
        """Poses of rods with centre lines ``shapes`` [rod, node, 3] about their middles, and these lines in space."""
        position, rotation = self._arranged(arrangement, shapes, rng)
        lines = _in_space(position, rotation, shapes)
        for _ in range(MOST_DRAWS):
            out = np.flatnonzero(~self.contains(lines))
            if not len(out):
                return (position, rotation), lines
            position[out], rotation[out] = self._arranged(arrangement, shapes[out], rng)
            lines[out] = _in_space(position[out], rotation[out], shapes[out])
        raise SceneError(
            f"{len(out)} rods found no place inside the {'container' if self.container else 'box'}, which may be too "
            f"small for their length: place fewer"
        )

    def _arranged(self, arrangement: str, shapes: np.ndarray, rng: np.random.Generator) -> Poses:
        """Poses of rods with centre lines ``shapes`` [rod, node, 3], which may stick out of the region."""
        position, rotation = ARRANGEMENTS[arrangement](self, len(shapes), rng)
        if self.room is None:
            return position, rotation
        if arrangement == "random":  # a rod whose ends are farther apart than the room is wide has few directions
            width = float(np.linalg.norm(self.high[1:] - self.low[1:]))
            rotation = with_chords_along_x(shapes[:, -1] - shapes[:, 0], width, rng)
        turn = turned_to(self.room.axis)
        return position @ turn.T, turn @ rotation

    @property
    def walled(self) -> bool:
        """Whether whole rods must lie inside walls."""
        return self.container is not None or self.room is not None

    def contains(self, lines: np.ndarray) -> np.ndarray:
        """Whether each whole centre line [rod, node, 3] is inside the walls [rod]; true without a container or room."""
        if self.room:
            return np.asarray(self.room.holds(lines, self.clearance).all(axis=1))
        if self.container is None:
            return np.ones(len(lines), dtype=bool)
        gradient = np.linalg.norm(self.container.gradient(lines), axis=-1)
        inside = self.container.phi(lines) < -self.clearance * gradient
        low, high = self.caps + self.clearance * np.array([[1.0], [-1.0]])
        return (inside & (lines >= low).all(axis=-1) & (lines <= high).all(axis=-1)).all(axis=1)

    def isotropic(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Random frames [count, 3, 3]; frames of flat rods are rotated about z only."""
        if self.flat:
            return about_z(rng.uniform(0, 2 * np.pi, count))
        return isotropic(count, rng)


def random(region: Region, count: int, rng: np.random.Generator) -> Poses:
    """Uniform in the region, isotropic."""
    return region.points(count, rng), region.isotropic(count, rng)


def aligned(region: Region, count: int, rng: np.random.Generator) -> Poses:
    """Uniform in the region, all directed to +x."""
    return region.points(count, rng), about_z(np.zeros(count))


def polar_lanes(region: Region, count: int, rng: np.random.Generator) -> Poses:
    """Lanes along x, about a swimmer's length wide, that swim alternately to +x and −x."""
    points = region.points(count, rng)
    width = region.high[1] - region.low[1]
    lanes = 2 * max(1, round(width / (2 * LANE)))
    lane = np.floor((points[:, 1] - region.low[1]) / width * lanes)
    return points, about_z(np.pi * (lane % 2))


def nematic_lanes(region: Region, count: int, rng: np.random.Generator) -> Poses:
    """All along the x axis, each to +x or −x at random."""
    return region.points(count, rng), about_z(np.pi * rng.integers(0, 2, count))


def bands(region: Region, count: int, rng: np.random.Generator) -> Poses:
    """Two bands that meet: swimmers at x < 0 swim to +x, the others to −x."""
    points = region.points(count, rng)
    middle = (region.low[0] + region.high[0]) / 2
    return points, about_z(np.where(points[:, 0] < middle, 0.0, np.pi))


ARRANGEMENTS: dict[str, Callable[[Region, int, np.random.Generator], Poses]] = {
    "random": random,
    "aligned": aligned,
    "polar lanes": polar_lanes,
    "nematic lanes": nematic_lanes,
    "bands": bands,
}
"""Functions that draw middle points [count, 3] and frames [count, 3, 3], tangent first, by name of the placement."""


def given_poses(position: Any, direction: Any) -> dict[str, np.ndarray]:
    """Middle points [rod, 3] and, if directions [rod, 3] are given, frames by the smallest rotation from x to them."""
    poses = {"position": np.array(position)}
    if direction is not None:
        poses["rotation"] = smallest_rotations(np.array(direction, dtype=float))
    return poses


def smallest_rotations(direction: np.ndarray) -> np.ndarray:
    """Frames [rod, 3, 3] by the smallest rotations from x to directions [rod, 3]; for −x by π about z.

    c I + [w]× + (1 − c) w wᵀ/|w|² with w = x × d and c = x·d, for unit vectors d.
    """
    c, y, z = (direction / np.linalg.norm(direction, axis=-1, keepdims=True)).T
    s = np.hypot(y, z)
    along, across = np.where(s > 0, [y, z], [[1.0], [0.0]]) / np.where(s > 0, s, 1.0)
    mixed = -(1 - c) * along * across
    rows = [[c, -y, -z], [y, c + (1 - c) * across**2, mixed], [z, mixed, c + (1 - c) * along**2]]
    return np.moveaxis(np.array(rows), -1, 0)


def arranged_poses(
    arrangement: str,
    scene: Scene,
    container: Surface | None,
    shapes: Mapping[str, np.ndarray],
    others: Sequence[np.ndarray],
    rng: np.random.Generator,
) -> tuple[dict[str, dict[str, np.ndarray]], str]:
    """Middle points and frames of swimmers of several ensembles, placed together, and a line for the user.

    container: the surface of the box. shapes: centre lines [rod, node, 3] about the middles, by ensemble. With steric
    forces the distance between centre lines, and to those of ``others``, is at least the core and a node spacing.
    Raises SceneError if the rods do not fit.
    """
    nodes = max(own.shape[1] for own in shapes.values())
    # In random order, so that no ensemble is preferred.
    lines = np.concatenate([_resampled(own, nodes) for own in shapes.values()])
    order = rng.permutation(len(lines))
    region = Region.of(scene, container, scene.steric.core / 2 if scene.steric else 0.0)
    try:
        poses, note = _find_poses(arrangement, region, scene, lines[order], others, rng)
    except SceneError as error:
        raise SceneError(f'placement = "{arrangement}": {error}, or make the box larger') from None
    original = np.argsort(order)
    ends = np.cumsum([len(own) for own in shapes.values()])[:-1]
    split = [np.split(part[original], ends) for part in poses]
    return {name: {"position": p, "rotation": R} for name, p, R in zip(shapes, *split, strict=True)}, note


def _find_poses(
    arrangement: str,
    region: Region,
    scene: Scene,
    shapes: np.ndarray,
    others: Sequence[np.ndarray],
    rng: np.random.Generator,
) -> tuple[Poses, str]:
    """Poses of rods with centre lines ``shapes`` [rod, node, 3], and a line for the user."""
    core = scene.steric.core if scene.steric else 0.0
    spacing = 1 / (shapes.shape[1] - 1)
    clearance = max(core, spacing)

    def draw(rods: np.ndarray) -> tuple[Poses, np.ndarray]:
        return region.draw(arrangement, shapes[rods], rng)

    if scene.steric is None:
        return draw(np.arange(len(shapes)))[0], "without steric forces, so rods may overlap"
    if region.walled:  # rods that are too long for it are told as such
        region.draw(arrangement, shapes[:1], np.random.default_rng(0))
    refuse_crowd(extents(shapes), core if region.walled else clearance, region.volume(clearance))
    space = OccupiedSpace(others, np.array(scene.period))
    if arrangement != "random" or region.walled:
        found = without_overlap(len(shapes), draw, clearance, space)
        return found.poses, found.note  # type: ignore[return-value]
    close = CLOSE * clearance
    # Flat rods cannot be pushed past each other. Compressed along z, those that cross are drawn a clearance apart.
    compression = np.array([1.0, 1.0, close / clearance if region.flat else 1.0])

    def draw_compressed(rods: np.ndarray) -> tuple[Poses, np.ndarray]:
        poses, lines = draw(rods)
        return poses, lines * compression

    for _ in range(MOST_ATTEMPTS):
        drawn = without_overlap(
            len(shapes), draw_compressed, close, OccupiedSpace([part * compression for part in others], space.period)
        )
        position, rotation = drawn.poses
        heights = (float(region.low[2]), float(region.high[2])) if region.flat else None
        poses = pushed_apart(position, rotation, shapes, clearance, space, heights)
        if poses:
            return poses, f"centre lines pushed apart to {clearance:.3g}"
    raise SceneError(f"count = {len(shapes)}: rods jam before they are {clearance:g} apart; place fewer")


def _resampled(lines: np.ndarray, nodes: int) -> np.ndarray:
    """Centre lines [rod, node, 3] with another number of nodes, by linear interpolation."""
    old, new = np.linspace(0, 1, lines.shape[1]), np.linspace(0, 1, nodes)
    if len(old) == nodes:
        return lines
    after = np.clip(np.searchsorted(old, new), 1, len(old) - 1)
    slope = (lines[:, after] - lines[:, after - 1]) / (old[after] - old[after - 1])[:, None]
    return slope * (new - old[after - 1])[:, None] + lines[:, after - 1]


def count_outside(scene: Scene, container: Surface | None, lines: np.ndarray) -> int:
    """The number of rods with centre lines [rod, node, 3] that extend beyond a wall of the box."""
    box = scene.box
    if box is None or box.wall is None:
        return 0
    if box.kind in WALLED:
        out = ~WALLED[box.kind](box).holds(lines)
    elif container is None:
        assert box.height is not None
        out = np.abs(lines[..., 2]) > box.height / 2
    else:
        phi = container.phi(lines)
        low, high = caps_of(container, box.side == "outside")
        out = phi < 0 if box.side == "outside" else phi > 0
        out |= ((lines < low) | (lines > high)).any(axis=-1)
    return int(out.any(axis=1).sum())


def _in_space(position: np.ndarray, rotation: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """Centre lines [rod, node, 3] in space."""
    return position[:, None] + np.einsum("rij,rnj->rni", rotation, shapes)

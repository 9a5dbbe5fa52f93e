"""Placement of rods at random with a clearance between them: overlapping rods are drawn again, or pushed apart."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from warp_rods.errors import SceneError

MOST_ROUNDS = 200
"""Rounds of drawing overlapping rods again."""
DRAWS = 1000
"""Smallest number of draws in a round after the first, if there are as many rods."""
FIRST_ROUNDS = 10
"""Rounds after which it is estimated whether the rods will fit."""
OPTIMISM = 1.5
"""Factor by which more rods than estimated may find a place before it is given up."""
MOST_PUSHES = 250
"""Rounds of pushing overlapping rods apart."""
TARGET = 1.01
"""Rods are pushed apart to this distance, in units of the clearance; a target of 1 would be approached slowly."""

Poses = tuple[np.ndarray, ...]
Draw = Callable[[np.ndarray], tuple[Poses, np.ndarray]]


class Found(NamedTuple):
    """``poses`` [count, …] that keep the clearance, and the number of rejected draws."""

    poses: Poses
    rejected: int
    clearance: float

    @property
    def note(self) -> str:
        """A line for the user."""
        return f"{self.rejected} draws came closer than {self.clearance:.3g} to another rod and were drawn again"


@dataclass(frozen=True)
class Space:
    """Points ``others`` [n, 3] of other rods, in a box of periods [3], 0 along an axis without a period."""

    others: np.ndarray
    period: np.ndarray

    def tree(self, points: np.ndarray) -> cKDTree:
        """The tree of points [n, 3], periodic along axes with a period."""
        if not np.any(self.period):
            return cKDTree(points)
        divisor = np.where(self.period > 0, self.period, 1.0)
        wrapped = np.where(self.period > 0, np.mod(points, divisor), points)
        wrapped = np.where(
            (self.period > 0) & (wrapped >= divisor), 0.0, wrapped
        )  # a remainder may round to the period
        return cKDTree(wrapped, boxsize=self.period)

    def nearest_image(self, d: np.ndarray) -> np.ndarray:
        """Separations [n, 3] between nearest images."""
        divisor = np.where(self.period > 0, self.period, np.inf)
        return d - np.where(self.period > 0, self.period, 0.0) * np.rint(d / divisor)


def without_overlap(count: int, draw: Draw, clearance: float, space: Space) -> Found:
    """Poses of ``count`` rods with ``clearance`` between them and to other rods, by drawing overlapping rods again.

    draw(rods [n]) draws poses [n, …] for the rods of these numbers and returns them with their centre lines
    [n, node, 3]. Of two overlapping rods the later one is drawn again. Raises SceneError if the rods do not fit.
    """
    placed, left, rejected = space.others.reshape(-1, 3), np.arange(count), 0
    kept: Poses = ()
    done: list[int] = []
    for attempt in range(MOST_ROUNDS):
        # The last rods are the hardest to place: several draws are made for each of them at once.
        drawn = np.resize(left, max(len(left), min(count, DRAWS) if attempt else 0))
        poses, lines = draw(drawn)
        kept = kept or tuple(np.empty((count, *part.shape[1:])) for part in poses)
        good = _fitting(lines, placed, clearance, space)
        good = good[np.unique(drawn[good], return_index=True)[1]]
        for whole, part in zip(kept, poses, strict=True):
            whole[drawn[good]] = part[good]
        placed = np.concatenate([placed, lines[good].reshape(-1, 3)])
        rejected += len(drawn) - len(good)
        left = np.setdiff1d(left, drawn[good])
        if not len(left):
            return Found(kept, rejected, clearance)
        done.append(count - len(left))
        if attempt >= FIRST_ROUNDS and len(left) > OPTIMISM * _still_to_come(done):
            break
    raise SceneError(
        f"count = {count}: after {rejected} draws only {count - len(left)} fit {clearance:g} apart; place fewer"
    )


def _still_to_come(done: Sequence[int]) -> float:
    """An estimate of how many more rods find a place in the rounds left, from those placed after each round so far.

    Random placement jams: the rate of success falls at least as fast as the number of rounds, so that each doubling of
    the rounds places no more rods than the last one.
    """
    doubling = done[-1] - done[len(done) // 2 - 1] + 1
    return doubling * float(np.log2(MOST_ROUNDS / len(done)))


def _fitting(lines: np.ndarray, placed: np.ndarray, clearance: float, space: Space) -> np.ndarray:
    """Indices of the centre lines [rod, node, 3] that keep the clearance to ``placed`` points and to earlier lines."""
    nodes = lines.shape[1]
    tree = space.tree(lines.reshape(-1, 3))
    good = np.ones(len(lines), dtype=bool)
    if len(placed):
        near = space.tree(placed).query(tree.data, distance_upper_bound=clearance)[0] < clearance
        good = ~near.reshape(len(lines), nodes).any(axis=1)
    pairs = np.unique(np.sort(tree.query_pairs(clearance, output_type="ndarray") // nodes, axis=1), axis=0)
    for first, second in pairs[pairs[:, 0] != pairs[:, 1]]:  # sorted by the first, whose result is known then
        good[second] &= not good[first]
    return np.flatnonzero(good)


def pushed_apart(
    position: np.ndarray,
    rotation: np.ndarray,
    shapes: np.ndarray,
    clearance: float,
    space: Space,
    heights: tuple[float, float] | None = None,
) -> tuple[np.ndarray, np.ndarray] | None:
    """Positions [rod, 3] and rotations [rod, 3, 3] of rigid rods that keep the clearance, starting from given ones.

    shapes [rod, node, 3]: centre lines about the middles. Each pair of nodes that is too close is separated by the
    missing distance, through translation and rotation of both rods so that both move least. heights: bounds for the
    middles of flat rods, which rotate about z only; rods that cross are separated in z. Returns None if some rods
    remain jammed.
    """
    nodes, others = shapes.shape[1], space.others.reshape(-1, 3)
    length = np.linalg.norm(np.diff(shapes, axis=1), axis=-1).sum(axis=1)
    for _ in range(MOST_PUSHES):
        arms = np.einsum("rij,rnj->rni", rotation, shapes)
        points = (position[:, None] + arms).reshape(-1, 3)
        first, second, gap = _too_close(np.concatenate([points, others]), len(points), nodes, clearance, space)
        if not len(first):
            return position, rotation
        missing = (TARGET * clearance - np.linalg.norm(gap, axis=-1))[:, None]
        push = gap / np.linalg.norm(gap, axis=-1, keepdims=True) * missing / 2
        shift, turn = _rigid_motions(arms, length, ((first, push), (second, -push)))
        position = position + shift
        if heights:
            turn[:, :2] = 0.0
            position[:, 2] = np.clip(position[:, 2], *heights)
        rotation = Rotation.from_rotvec(turn).as_matrix() @ rotation
    return None


def _rigid_motions(
    arms: np.ndarray, length: np.ndarray, pushes: Iterable[tuple[np.ndarray, np.ndarray]]
) -> tuple[np.ndarray, np.ndarray]:
    """Translations and rotation vectors [rod, 3] that give nodes (numbers, displacements [n, 3]) their ``pushes``.

    arms [rod, node, 3]: nodes from the middles. Each push is shared between translation and rotation as by a force on a
    uniform rod of this length; the motions of a rod are averaged over its pushes.
    """
    rods, nodes = arms.shape[:2]
    shift, turn, count = np.zeros((rods, 3)), np.zeros((rods, 3)), np.zeros(rods)
    for node, push in pushes:
        node, push = node[node < rods * nodes], push[node < rods * nodes]
        rod, arm = node // nodes, arms.reshape(-1, 3)[node]
        inverse_inertia = 12 / length[rod, None] ** 2
        share = push / (1 + inverse_inertia * np.sum(arm * arm, axis=-1, keepdims=True))
        np.add.at(shift, rod, share)
        np.add.at(turn, rod, inverse_inertia * np.cross(arm, share))
        np.add.at(count, rod, 1)
    count = np.maximum(count, 1)[:, None]
    return shift / count, turn / count


def overlapping(lines: Sequence[np.ndarray], clearance: float, period: np.ndarray) -> int:
    """The number of pairs of rods with nodes closer than the clearance; lines: [rod, node, 3] of each ensemble."""
    points = np.concatenate([part.reshape(-1, 3) for part in lines])
    nodes = np.concatenate([np.full(len(part), part.shape[1]) for part in lines])
    rod = np.repeat(np.arange(len(nodes)), nodes)
    points, rod = points[finite := np.isfinite(points).all(axis=1)], rod[finite]
    pairs = rod[Space(points, period).tree(points).query_pairs(clearance, output_type="ndarray")]
    return len(np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0))


def _too_close(
    points: np.ndarray, own: int, nodes: int, clearance: float, space: Space
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of points of different rods that are closer than the clearance, and the separation of the first from the
    second [pair, 3]. At least one point of a pair is among the first ``own``."""
    first, second = space.tree(points).query_pairs(clearance, output_type="ndarray").T
    differ = (first // nodes != second // nodes) & (np.minimum(first, second) < own)
    first, second = first[differ], second[differ]
    return first, second, space.nearest_image(points[first] - points[second])

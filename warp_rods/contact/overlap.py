"""Rods placed at random so that none is closer to another than a clearance: drawn again, or pushed apart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from warp_rods.errors import SceneError

ROUNDS = 200
"""Times that rods in the way of others are drawn again before giving up."""
DRAWS = 1000
"""Draws in a round, at least, of as many rods."""
PUSHES = 250
"""Times that rods are pushed apart before giving up."""
ASIDE = 1.01
"""Of the clearance, that rods in each other's way are pushed apart to, so that they do not creep up on it."""

Poses = tuple[np.ndarray, ...]
Draw = Callable[[np.ndarray], tuple[Poses, np.ndarray]]


class Found(NamedTuple):
    """``poses`` [count, …] and how many draws were thrown away."""

    poses: Poses
    redrawn: int
    clearance: float

    @property
    def note(self) -> str:
        """How they were found, for the user."""
        return f"{self.redrawn} draws came closer than {self.clearance:.3g} to another rod and were drawn again"


@dataclass(frozen=True)
class Space:
    """Points ``others`` [n, 3] that rods keep clear of as of each other, in a box of periods [3], 0 where open."""

    others: np.ndarray
    period: np.ndarray

    def tree(self, points: np.ndarray) -> cKDTree:
        """The tree of points [n, 3], in a periodic box where there is one."""
        if not np.any(self.period):
            return cKDTree(points)
        around = np.where(self.period > 0, self.period, 1.0)
        wrapped = np.where(self.period > 0, np.mod(points, around), points)
        wrapped = np.where((self.period > 0) & (wrapped >= around), 0.0, wrapped)  # a remainder may round to the period
        return cKDTree(wrapped, boxsize=self.period)

    def nearest_image(self, d: np.ndarray) -> np.ndarray:
        """Separations [n, 3] between nearest images."""
        around = np.where(self.period > 0, self.period, np.inf)
        return d - np.where(self.period > 0, self.period, 0.0) * np.rint(d / around)


def without_overlap(count: int, draw: Draw, clearance: float, space: Space) -> Found:
    """Poses of ``count`` rods that keep ``clearance`` from each other and from others, by drawing again.

    draw(rods [n]) draws poses for the rods of these numbers, arrays [n, …], and lays out their centre lines
    [n, node, 3]; of two in each other's way the later is drawn again. Raises SceneError where the rods do not fit.
    """
    taken, left, redrawn = space.others.reshape(-1, 3), np.arange(count), 0
    kept: Poses = ()
    for turn in range(ROUNDS):
        # The last are the hardest to place: then several draws are made for each at once.
        drawn = np.resize(left, max(len(left), min(count, DRAWS) if turn else 0))
        poses, lines = draw(drawn)
        kept = kept or tuple(np.empty((count, *part.shape[1:])) for part in poses)
        good = _apart(lines, taken, clearance, space)
        good = good[np.unique(drawn[good], return_index=True)[1]]
        for whole, part in zip(kept, poses, strict=True):
            whole[drawn[good]] = part[good]
        taken = np.concatenate([taken, lines[good].reshape(-1, 3)])
        redrawn += len(drawn) - len(good)
        left = np.setdiff1d(left, drawn[good])
        if not len(left):
            return Found(kept, redrawn, clearance)
    raise SceneError(
        f"count = {count}: after {redrawn} draws only {count - len(left)} fit {clearance:g} apart; place fewer"
    )


def _apart(lines: np.ndarray, taken: np.ndarray, clearance: float, space: Space) -> np.ndarray:
    """Which of the centre lines [rod, node, 3], taken in turn, keep the clearance from ``taken`` and those before."""
    nodes = lines.shape[1]
    tree = space.tree(lines.reshape(-1, 3))
    good = np.ones(len(lines), dtype=bool)
    if len(taken):
        near = space.tree(taken).query(tree.data, distance_upper_bound=clearance)[0] < clearance
        good = ~near.reshape(len(lines), nodes).any(axis=1)
    pairs = np.unique(np.sort(tree.query_pairs(clearance, output_type="ndarray") // nodes, axis=1), axis=0)
    for first, second in pairs[pairs[:, 0] != pairs[:, 1]]:  # in the order of the first, which is settled by then
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
    """Poses [rod, 3], [rod, 3, 3] of rigid rods ``shapes`` [rod, node, 3] that keep the clearance, from ones near by.

    Each pair of nodes that is closer is pushed aside by what is missing, shared by shift and turn of both rods so
    that both move least. Between heights rods lie flat: they turn about z alone, and their middles stay between these;
    without leave to rise, those that cross would never come apart. None where some stay jammed.
    """
    nodes, others = shapes.shape[1], space.others.reshape(-1, 3)
    length = np.linalg.norm(np.diff(shapes, axis=1), axis=-1).sum(axis=1)
    for _ in range(PUSHES):
        arms = np.einsum("rij,rnj->rni", rotation, shapes)
        points = (position[:, None] + arms).reshape(-1, 3)
        first, second, gap = _too_close(np.concatenate([points, others]), len(points), nodes, clearance, space)
        if not len(first):
            return position, rotation
        missing = (ASIDE * clearance - np.linalg.norm(gap, axis=-1))[:, None]
        push = gap / np.linalg.norm(gap, axis=-1, keepdims=True) * missing / 2
        shift, turn, hits = np.zeros((len(shapes), 3)), np.zeros((len(shapes), 3)), np.zeros(len(shapes))
        for node, way in ((first, push), (second, -push)):
            node, way = node[node < len(points)], way[node < len(points)]
            rod, arm = node // nodes, arms.reshape(-1, 3)[node]
            inertia = 12 / length[rod, None] ** 2
            share = way / (1 + inertia * np.sum(arm * arm, axis=-1, keepdims=True))
            np.add.at(shift, rod, share)
            np.add.at(turn, rod, inertia * np.cross(arm, share))
            np.add.at(hits, rod, 1)
        hits = np.maximum(hits, 1)[:, None]
        position = position + shift / hits
        if heights:
            turn[:, :2] = 0.0
            position[:, 2] = np.clip(position[:, 2], *heights)
        rotation = Rotation.from_rotvec(turn / hits).as_matrix() @ rotation
    return None


def overlapping(lines: Sequence[np.ndarray], clearance: float, period: np.ndarray) -> int:
    """How many pairs of rods, of ensembles of centre lines [rod, node, 3], have nodes closer than the clearance."""
    points = np.concatenate([part.reshape(-1, 3) for part in lines])
    nodes = np.concatenate([np.full(len(part), part.shape[1]) for part in lines])
    owner = np.repeat(np.arange(len(nodes)), nodes)
    points, owner = points[finite := np.isfinite(points).all(axis=1)], owner[finite]
    pairs = owner[Space(points, period).tree(points).query_pairs(clearance, output_type="ndarray")]
    return len(np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0))


def _too_close(
    points: np.ndarray, own: int, nodes: int, clearance: float, space: Space
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of points closer than the clearance, of different rods, one of the first ``own`` at least; and the first
    seen from the second [pair, 3]."""
    first, second = space.tree(points).query_pairs(clearance, output_type="ndarray").T
    differ = (first // nodes != second // nodes) & (np.minimum(first, second) < own)
    first, second = first[differ], second[differ]
    return first, second, space.nearest_image(points[first] - points[second])

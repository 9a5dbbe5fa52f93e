"""Placement of rods at random with a clearance between them: overlapping rods are drawn again, or pushed apart.

The clearance is the distance of centre lines, which are chains of straight segments between nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from warp_rods.contact.segments import Close, OccupiedSpace, Segments
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
PROGRESS, FIRST_PUSHES, FASTER, FEW_LEFT = 10, 30, 1.2, 0.1
"""Every so many rounds, but not before so many, it is estimated whether the rods will come apart: their overlap falls
about exponentially, or faster by this factor in the exponent. A few overlaps, so many clearances for each rod, come and
go."""
TARGET = 1.01
"""Rods are pushed apart to this distance, in units of the clearance; a target of 1 would be approached slowly."""

CROSSED = 1e-9
"""Segments closer than this fraction of their length intersect: their separation has no direction."""

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
        return (
            f"{self.rejected} draws had a centre line closer than {self.clearance:.3g} to another and were drawn again"
        )


def without_overlap(count: int, draw: Draw, clearance: float, space: OccupiedSpace) -> Found:
    """Poses of ``count`` rods with ``clearance`` between them and to other rods, by drawing overlapping rods again.

    The clearance is that of centre lines.

    draw(rods [n]) draws poses [n, …] for the rods of these numbers and returns them with their centre lines
    [n, node, 3]. Of two overlapping rods the later one is drawn again. Raises SceneError if the rods do not fit.
    """
    placed, left, rejected = list(space.others), np.arange(count), 0
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
        placed.append(lines[good])
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


def _fitting(lines: np.ndarray, placed: Sequence[np.ndarray], clearance: float, space: OccupiedSpace) -> np.ndarray:
    """Indices of the centre lines [rod, node, 3] that keep the clearance to ``placed`` lines and to earlier lines."""
    own, there = Segments.of([lines]), Segments.of(placed)
    good = np.ones(len(lines), dtype=bool)
    if len(there.rod):
        good[own.rod[space.close_between(own, there, clearance).first]] = False
    close = space.close_within(own, clearance)
    pairs = np.unique(np.sort(own.rod[np.stack([close.first, close.second], axis=1)], axis=1), axis=0)
    for first, second in pairs:  # sorted by the first, whose result is known then
        good[second] &= not good[first]
    return np.flatnonzero(good)


def pushed_apart(
    position: np.ndarray,
    rotation: np.ndarray,
    shapes: np.ndarray,
    clearance: float,
    space: OccupiedSpace,
    heights: tuple[float, float] | None = None,
) -> tuple[np.ndarray, np.ndarray] | None:
    """Positions [rod, 3] and rotations [rod, 3, 3] of rigid rods that keep the clearance, starting from given ones.

    shapes [rod, node, 3]: centre lines about the middles. Each pair of segments that is too close is separated by the
    missing distance, through translation and rotation of both rods so that both move least. heights: bounds for the
    middles of flat rods, which rotate about z only; rods that cross are separated in z. Returns None if some rods
    remain jammed. Raises SceneError as soon as the overlap falls so slowly that they are too many.
    """
    from scipy.spatial.transform import Rotation  # slow to import

    length = np.linalg.norm(np.diff(shapes, axis=1), axis=-1).sum(axis=1)
    overlaps: list[float] = []
    for _ in range(MOST_PUSHES):
        arms = np.einsum("rij,rnj->rni", rotation, shapes)
        segments = Segments.of([position[:, None] + arms, *space.others])
        close = space.close_within(segments, clearance)
        own = np.minimum(segments.rod[close.first], segments.rod[close.second]) < len(position)
        if not own.any():
            return position, rotation
        close = Close(*(part[own] for part in close))
        overlaps.append(float((clearance - close.distance).sum()) / clearance)
        if _is_hopeless(overlaps, len(position)):
            raise SceneError(f"count = {len(position)}: too many to be {clearance:g} apart; place fewer")
        push = _directions(segments, close, space) * (TARGET * clearance - close.distance[:, None]) / 2
        first = (close.first, close.along_first, push)
        second = (close.second, close.along_second, -push)
        shift, turn = _rigid_motions(position, segments, length, (first, second))
        position = position + shift
        if heights:
            turn[:, :2] = 0.0
            position[:, 2] = np.clip(position[:, 2], *heights)
        rotation = Rotation.from_rotvec(turn).as_matrix() @ rotation
    return None


def _is_hopeless(overlaps: Sequence[float], rods: int) -> bool:
    """Whether overlaps that fall as in the last rounds do not vanish in the rounds left; in units of the clearance."""
    done = len(overlaps)
    if done < FIRST_PUSHES or done % PROGRESS or overlaps[-1] < FEW_LEFT * rods:
        return False
    factor = overlaps[-1] / overlaps[-1 - PROGRESS]
    return overlaps[-1] * factor ** (FASTER * (MOST_PUSHES - done) / PROGRESS) > TARGET - 1


def _directions(segments: Segments, close: Close, space: OccupiedSpace) -> np.ndarray:
    """Unit vectors [pair, 3] along which to separate close segments; along that of their middles if they intersect."""
    middle = segments.middle
    crossed = close.distance[:, None] < CROSSED * np.maximum(segments.longest, np.finfo(float).tiny)
    gap = np.where(crossed, space.nearest_image(middle[close.first] - middle[close.second]), close.gap)
    return gap / np.maximum(np.linalg.norm(gap, axis=-1, keepdims=True), np.finfo(float).tiny)


def _rigid_motions(
    position: np.ndarray,
    segments: Segments,
    length: np.ndarray,
    pushes: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray]],
) -> tuple[np.ndarray, np.ndarray]:
    """Translations and rotation vectors [rod, 3] that give points of rods about ``position`` [rod, 3] their ``pushes``.

    pushes: numbers of segments, places along them and displacements [n, 3]; those of other rods are left out. Each is
    shared between translation and rotation as by a force on a uniform rod of this length; the motions of a rod are
    averaged over its pushes.
    """
    rods = len(position)
    shift, turn, count = np.zeros((rods, 3)), np.zeros((rods, 3)), np.zeros(rods)
    for which, along, push in pushes:
        own = segments.rod[which] < rods
        which, along, push = which[own], along[own, None], push[own]
        rod = segments.rod[which]
        arm = segments.start[which] + along * (segments.end[which] - segments.start[which]) - position[rod]
        inverse_inertia = 12 / length[rod, None] ** 2
        share = push / (1 + inverse_inertia * np.sum(arm * arm, axis=-1, keepdims=True))
        np.add.at(shift, rod, share)
        np.add.at(turn, rod, inverse_inertia * np.cross(arm, share))
        np.add.at(count, rod, 1)
    count = np.maximum(count, 1)[:, None]
    return shift / count, turn / count


def overlapping(lines: Sequence[np.ndarray], clearance: float, period: np.ndarray) -> int:
    """The number of pairs of rods closer than the clearance; lines: [rod, node, 3] of each ensemble."""
    segments = Segments.of(lines)
    close = OccupiedSpace((), period).close_within(segments, clearance)
    return len(np.unique(np.sort(segments.rod[np.stack([close.first, close.second], axis=1)], axis=1), axis=0))

"""Placement of rods at random with a clearance between them: overlapping rods are drawn again, or pushed apart.

The clearance is the distance of centre lines, which are chains of straight segments between nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from warp_rods.contact.segments import CentreLines, OccupiedSpace
from warp_rods.errors import SceneError

MOST_ROUNDS = 200
"""Rounds of drawing overlapping rods again."""
DRAWS, SHARE = 1000, 2
"""Smallest number of draws in a round after the first: 1000, or half of the rods if that is more, if there are as many.
The number of rounds that are needed then depends on the density, not on the number of rods."""
FIRST_ROUNDS = 10
"""Rounds after which it is estimated whether the rods will fit."""
OPTIMISM = 1.5
"""Factor by which more rods than estimated may find a place before it is given up."""
MOST_PAIRS = 1_000_000
"""Pairs of rods that are too close, of which no more are counted."""

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
    left, rejected, done = np.arange(count), 0, list[int]()
    fewest = min(count, max(DRAWS, count // SHARE))
    kept: Poses = ()
    placed: CentreLines | None = None
    for attempt in range(MOST_ROUNDS):
        # The last rods are the hardest to place: several draws are made for each of them at once.
        drawn = np.resize(left, max(len(left), fewest if attempt else 0))
        poses, lines = draw(drawn)
        kept = kept or tuple(np.empty((count, *part.shape[1:])) for part in poses)
        placed = placed or CentreLines(space, clearance, count + fewest, lines.shape[1])
        good = np.flatnonzero(placed.those_that_fit(lines))
        good = good[np.unique(drawn[good], return_index=True)[1]]
        for whole, part in zip(kept, poses, strict=True):
            whole[drawn[good]] = part[good]
        placed.add(lines[good])
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


def overlapping(lines: Sequence[np.ndarray], clearance: float, period: np.ndarray) -> int:
    """The number of pairs of rods closer than the clearance; lines: [rod, node, 3] of each ensemble.

    Not much more than ``MOST_PAIRS`` where there are more.
    """
    return CentreLines(OccupiedSpace(lines, period), clearance).count_touching(MOST_PAIRS)

"""Portions of a time over which rods take steps of their own, so that a run can be stopped between two frames."""

from __future__ import annotations

import time
from collections.abc import Iterator

__all__ = ["Portions"]

SECONDS = 0.5
"""What a portion should take of the user's time."""
FIRST = 1 / 64
"""The first portion, as a share of the time to be advanced."""
LONGER, SHORTER = 4.0, 0.25
"""Bounds of the ratio of a portion to the one before."""


class Portions:
    """Divides times so that each portion takes about half a second. Bits do not depend on where steps are looked at."""

    def __init__(self) -> None:
        self.longest: float | None = None
        """The longest portion of time; chosen from how long the last one took."""

    def of(self, now: float, end: float) -> Iterator[float]:
        """Times after ``now`` up to ``end``, each to be reached before the next is asked for."""
        longest = FIRST * (end - now) if self.longest is None else self.longest
        while now < end:
            target = end if end - now <= 1.5 * longest else now + longest
            begun = time.perf_counter()
            yield target
            factor = SECONDS / max(time.perf_counter() - begun, 1e-9)
            longest = self.longest = (target - now) * min(max(factor, SHORTER), LONGER)
            now = target

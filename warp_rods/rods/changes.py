"""How fast what is given in time changes, so that no step by error passes over it (docs/model.md §2.11)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

import numpy as np

__all__ = ["Changes", "Sampled", "chosen", "numbers_of_rods"]

Sampled = Callable[[np.ndarray], Iterable[np.ndarray]]
"""Values at times [time]: any number of arrays [time, …]."""

SAMPLES = 10_000
"""Times at which formulas are sampled over a run; what is shorter than one of their intervals is not seen."""
SHARE = 0.05
"""The part of its range by which the rate of what is given may differ, within a step, from a line between its ends."""
INTERVALS = 2.0
"""The largest length of a step in intervals of a table."""
AHEAD = 64
"""Steps for which formulas are sampled where the end of the run is not known."""
MOST_RODS = 64
"""Rods whose own numbers in formulas are looked at; evenly chosen where there are more."""
SHORTER = 0.8
NOTHING = 1e-5
"""Changes of the rate, times the time sampled, that are round-off of values as large as 1."""


class Changes:
    """Bounds for steps from formulas in t, which are sampled, and from tables [times] that are held or periodic."""

    def __init__(self, formulas: Sequence[Sampled], tables: Sequence[tuple[np.ndarray, bool]] = ()):
        self._formulas, self._tables = list(formulas), list(tables)
        self._times, self._turned = np.zeros(2), np.zeros(2)

    def foresee(self, start: float, end: float) -> None:
        """Sample the formulas from a time to another."""
        if not self._formulas:
            return
        self._times = np.linspace(start, end, SAMPLES + 1)
        largest = np.zeros(SAMPLES - 1)
        for formula in self._formulas:
            for values in formula(self._times):
                np.maximum(largest, _turning(values, end - start), out=largest)
        self._turned = np.concatenate([[0.0], np.cumsum(largest), [largest.sum()]])

    @property
    def seen(self) -> tuple[np.ndarray, np.ndarray]:
        """What the formulas were seen to do at which times; setting it forgets what was seen later."""
        return self._times, self._turned

    @seen.setter
    def seen(self, samples: tuple[np.ndarray, np.ndarray]) -> None:
        self._times, self._turned = samples

    def within(self, time: float, end: float) -> bool:
        """Whether the formulas are sampled from a time to another."""
        return bool(self._times[0] <= time and end <= self._times[-1] and self._times[0] < self._times[-1])

    def longest_step(self, time: float, step: float) -> float:
        """The longest step from ``time``, up to ``step``, that passes over nothing."""
        for times, periodic in self._tables:
            step = _in_table(times, periodic, time, step)
        if not self._formulas:
            return step
        if not self.within(time, time + step):
            self.foresee(time, time + AHEAD * step)
        # The largest difference of a function g from the line between the ends of a step h is at most h ∫|g″| dt / 4.
        while step * self._between(time, time + step) > 4 * SHARE:
            step *= SHORTER
        return step

    def _between(self, start: float, end: float) -> float:
        low, high = np.interp([start, end], self._times, self._turned)
        return float(high - low)


def _turning(values: np.ndarray, duration: float) -> np.ndarray:
    """∫|g″| dt over each interval but the first and the last, with g the rate of the values over its range; largest."""
    columns = np.asarray(values, dtype=float).reshape(len(values), -1)
    columns = np.where(np.isfinite(columns), columns, 0.0)
    spacing = duration / (len(columns) - 1)
    rate = np.diff(columns, axis=0) / spacing
    extent = np.ptp(rate, axis=0)
    seen = extent * duration > NOTHING * abs(columns).max(axis=0)
    if not seen.any():
        return np.zeros(len(columns) - 2)
    rate = rate[:, seen] / extent[seen]
    slope = np.diff(rate, axis=0) / spacing
    return abs(np.diff(slope, axis=0, prepend=slope[:1])).max(axis=1)


def _in_table(times: np.ndarray, periodic: bool, time: float, step: float) -> float:
    """A step of at most ``INTERVALS`` of the intervals that it meets."""
    intervals = np.diff(times)
    if periodic:
        length = times[-1] - times[0]
        time = times[0] + (time - times[0]) % length
        times, intervals = np.concatenate([times, times[1:] + length]), np.tile(intervals, 2)
        step = min(step, length)
    first = int(np.clip(np.searchsorted(times, time, "right") - 1, 0, len(intervals)))
    for i in range(first, len(intervals)):
        if times[i] >= time + step:
            break
        # Up to where a shorter interval begins, and a little into it: its own bound counts from the next step on.
        step = min(step, max(INTERVALS * intervals[i], times[i] - time))
    return step


def numbers_of_rods(named: Mapping[str, np.ndarray]) -> Iterator[dict[str, float]]:
    """The numbers by name of each rod, of at most ``MOST_RODS``; once, and empty, where there are none."""
    count = len(next(iter(named.values()))) if named else 1
    for rod in chosen(count):
        yield {name: float(numbers[rod]) for name, numbers in named.items()}


def chosen(count: int) -> np.ndarray:
    """At most ``MOST_RODS`` of this many rods, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, MOST_RODS)).astype(int))

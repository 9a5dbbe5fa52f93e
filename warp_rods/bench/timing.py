"""CPU time of works that are run in turns, so that what disturbs the machine disturbs all of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

LONG_ENOUGH = 0.02
"""Seconds that a measurement takes at least: shorter works are repeated within it."""
COPIED = 2**24
"""Numbers that are copied to measure the bandwidth: 128 MB, beyond every cache."""
REPEATS = 5


class Work(NamedTuple):
    """A work to be timed, and what puts things back ``before`` each time, which is not.

    slow: measured once, without a first run that only warms up.
    """

    run: Callable[[], object]
    before: Callable[[], object] | None = None
    slow: bool = False


class Times(NamedTuple):
    """CPU seconds of one work: the median over repeats, and half the range of the middle half over it."""

    median: float
    spread: float


def cpu_seconds(work: Work) -> float:
    """CPU seconds of one run, of all threads of this process."""
    if work.before is not None:
        work.before()
    start = time.process_time()
    work.run()
    return time.process_time() - start


def in_turns(
    works: Mapping[str, Work],
    repeats: int = REPEATS,
    long_enough: float = LONG_ENOUGH,
    tell: Callable[[str], None] = lambda _name: None,
) -> dict[str, Times]:
    """CPU seconds of each work; every one is run once before, and then all of them in turns, ``repeats`` times."""
    calls, found = dict[str, int](), dict[str, list[float]]()
    for name, work in works.items():
        tell(name)
        first = cpu_seconds(work)  # compiles, fills caches
        found[name] = [first] if work.slow else []
        calls[name] = 0 if work.slow else 1 + int(long_enough / max(cpu_seconds(work), 1e-7))
    for number in range(repeats):
        tell(f"turn {number + 1} of {repeats}")
        for name, work in works.items():
            if calls[name]:
                found[name].append(sum(cpu_seconds(work) for _ in range(calls[name])) / calls[name])
    return {name: times_of(values) for name, values in found.items()}


def ratio_in_turns(work: Work, unit: Work, repeats: int) -> float:
    """CPU time of a work over that of a unit run right after it: the median over ``repeats`` turns, after one more."""
    ratios = [cpu_seconds(work) / cpu_seconds(unit) for _ in range(repeats + 1)]
    return float(np.median(ratios[1:]))


def times_of(seconds: Sequence[float]) -> Times:
    """Median and relative spread of several measurements."""
    low, middle, high = np.quantile(seconds, [0.25, 0.5, 0.75])
    return Times(float(middle), float((high - low) / 2 / middle) if middle else 0.0)


def copy(numbers: int = COPIED) -> Work:
    """A copy of an array that no cache holds; it reads and writes 8 bytes a number."""
    source, target = np.ones(numbers), np.zeros(numbers)
    return Work(lambda: np.copyto(target, source))


def bytes_per_second(seconds: float, numbers: int = COPIED) -> float:
    """The bandwidth of ``copy``: bytes read and written."""
    return 16 * numbers / seconds

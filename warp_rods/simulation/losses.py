"""What a run says of the rods that it loses: a line for each of the first ones, then numbers."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

import numpy as np

from warp_rods.rods.ensemble import Ensemble, Failure
from warp_rods.rods.status import Status

__all__ = ["Losses", "frozen", "in_all", "lines", "summary"]

LISTED = 5
"""Rods of an ensemble that get a line of their own. Of more a run tells whenever their number has doubled."""
NAMED = 8
"""Rods whose numbers a summary gives."""


def frozen(ensembles: Mapping[str, Ensemble]) -> int:
    """The number of rods that are frozen."""
    return sum(int(np.count_nonzero(e.status != Status.OK)) for e in ensembles.values())


def lines(ensembles: Mapping[str, Ensemble]) -> list[str]:
    """A line for each rod that is frozen: when, why, and its parameters."""
    return [_line(name, ensemble, failure) for name, ensemble in ensembles.items() for failure in ensemble.failures()]


def in_all(ensembles: Mapping[str, Ensemble]) -> list[str]:
    """All rods that are frozen: a line for each of a few of an ensemble, or a summary of more."""
    found = []
    for name, ensemble in ensembles.items():
        few = frozen({name: ensemble}) <= LISTED
        found += lines({name: ensemble}) if few else [summary(name, ensemble)]
    return found


def summary(name: str, ensemble: Ensemble) -> str:
    """How many rods of an ensemble are frozen, and why; empty if none is."""
    failures = ensemble.failures()
    if not failures:
        return ""
    rods = defaultdict(list)
    for failure in failures:
        rods[failure.what].append(failure.rod)
    why = "; ".join(f"{len(numbers)} {what} ({_named(numbers)})" for what, numbers in rods.items())
    first, last = min(f.time for f in failures), max(f.time for f in failures)
    when = f"at t = {first:.6g}" if first == last else f"between t = {first:.6g} and {last:.6g}"
    return f"{name}: {len(failures)} of {ensemble.count} rods, {when}: {why}"


class Losses:
    """The rods of a run that are frozen, and what was said of them."""

    def __init__(self) -> None:
        self._known = defaultdict[str, set[int]](set)
        self._said = defaultdict[str, int](int)

    def check(self, ensembles: Mapping[str, Ensemble]) -> list[str]:
        """Lines about the rods that were frozen since the last call."""
        return [line for name, ensemble in ensembles.items() for line in self._new(name, ensemble)]

    def _new(self, name: str, ensemble: Ensemble) -> list[str]:
        known = self._known[name]
        new = [failure for failure in ensemble.failures() if failure.rod not in known]
        known.update(failure.rod for failure in new)
        if not new:
            return []
        if len(known) <= LISTED:
            self._said[name] = len(known)
            return [_line(name, ensemble, failure) for failure in new]
        if len(known) < 2 * self._said[name]:
            return []
        self._said[name] = len(known)
        return [summary(name, ensemble)]


def _line(name: str, ensemble: Ensemble, failure: Failure) -> str:
    rod, when, what = failure
    return f"{name}: rod {rod} {what} at t = {when:.6g}; parameters {ensemble.parameters(rod)}"


def _named(rods: list[int]) -> str:
    more = ", …" if len(rods) > NAMED else ""
    return f"rod{'s' if len(rods) > 1 else ''} {', '.join(map(str, rods[:NAMED]))}{more}"

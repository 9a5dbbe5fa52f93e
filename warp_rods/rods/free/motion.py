"""How a held end of a free rod moves: formulas in t, or a table of times and points (docs/model.md §2.11)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.formula import FormulaError, function_of_arrays
from warp_rods.rods.changes import numbers_of_rods
from warp_rods.rods.free.curve import curve_through
from warp_rods.scene.checks import read_table
from warp_rods.scene.ends import MotionTable

__all__ = ["NUDGE", "Motion"]

NUDGE = 1e-5
"""The time over which velocities of a motion are found, by central differences."""
ALLOWED = "three numbers or formulas in t, for x, y and z, or a table {times, points} or {file}"


class Motion:
    """A vector as a function of time: [3], or [rod, 3] where its formulas have parameters that differ from rod to rod.

    given: three numbers or formulas in t, or what ``MotionTable`` takes. named: parameters of formulas [rod].
    from_start: whether the points of a table count from the one at t = 0. Raises SceneError naming what is wrong.
    """

    def __init__(self, name: str, given: Any, named: Mapping[str, np.ndarray], from_start: bool):
        self.name, self._named = name, named
        self.table: tuple[np.ndarray, bool] | None = None
        """Times of a table, and whether it is periodic; None for formulas."""
        self._parts: list[Callable[..., Any]] = []
        if isinstance(given, (Mapping, MotionTable)):
            table = read_table(MotionTable, given, name)
            self.table = np.array(table.times), table.periodic
            self._function = _through(table, from_start)
        elif isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 3:
            raise arguments.wrong(name, given, ALLOWED)
        else:
            self._function = _of_formulas([_function(f"{name}[{i}]", part, named) for i, part in enumerate(given)])
            self._parts = [function_of_arrays(part, ("t", *named)) for part in given if isinstance(part, str)]

    def __call__(self, time: float) -> np.ndarray:
        """The vector at a time; raises SceneError where it is not finite."""
        found = self._function(time)
        if not np.isfinite(found).all():
            raise SceneError(f"{self.name}: a motion has no finite value at t = {time:g}")
        return found

    def sampled(self, times: np.ndarray) -> Iterator[np.ndarray]:
        """Values [time] of its formulas that change in time, for the numbers of each rod."""
        for part in self._parts:
            if "t" in part.names:  # type: ignore[attr-defined]
                for numbers in numbers_of_rods(self._named):
                    yield part(t=times, **numbers)


def _of_formulas(parts: Sequence[Callable[[float], Any]]) -> Callable[[float], np.ndarray]:
    return lambda time: np.stack(np.broadcast_arrays(*(part(time) for part in parts)), axis=-1)


def _function(name: str, given: Any, named: Mapping[str, np.ndarray]) -> Callable[[float], Any]:
    if not isinstance(given, str):
        value = arguments.real(name, given, arguments.ANY)
        return lambda _time: value
    try:
        function = function_of_arrays(given, ("t", *named))
    except FormulaError as error:
        raise SceneError(f"{name} = {given!r}: {error}") from None
    return lambda time: function(t=np.float64(time), **named)


def _through(table: MotionTable, from_start: bool) -> Callable[[float], np.ndarray]:
    """A curve through the points of a table; held beyond its ends, or periodic.

    It goes on for ``NUDGE`` beyond the ends, so that velocities there are those of the table.
    """
    times, points = np.array(table.times), np.array(table.points)
    if table.periodic:
        points[-1] = points[0]
    spline = curve_through(times, points, table.periodic)
    low, high = (-np.inf, np.inf) if table.periodic else (times[0] - NUDGE, times[-1] + NUDGE)
    start = spline(0.0) if from_start else 0.0
    return lambda time: spline(min(max(time, low), high)) - start

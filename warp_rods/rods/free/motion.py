"""How a held end of a free rod moves: formulas in t, or a table of times and points (docs/model.md §2.11)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.formula import FormulaError, function_of_arrays
from warp_rods.membranes.motion import rate_of_arrays
from warp_rods.rods.changes import numbers_of_rods
from warp_rods.rods.free.curve import curve_through
from warp_rods.scene.checks import read_table
from warp_rods.scene.ends import MotionTable

__all__ = ["Motion"]

ALLOWED = "three numbers or formulas in t, for x, y and z, or a table {times, points} or {file}"
OfTime = Callable[[float], Any]


class _Course(NamedTuple):
    """A quantity as a function of time, and its time derivative."""

    value: OfTime
    rate: OfTime


class Motion:
    """A vector as a function of time: [3], or [rod, 3] where its formulas have parameters that differ from rod to rod.

    given: three numbers or formulas in t, or what ``MotionTable`` takes. named: parameters of formulas [rod].
    from_start: whether it counts from its value at t = 0. Raises SceneError naming what is wrong.
    """

    def __init__(self, name: str, given: Any, named: Mapping[str, np.ndarray], from_start: bool):
        self.name, self._named = name, named
        self.table: tuple[np.ndarray, bool] | None = None
        """Times of a table, and whether it is periodic; None for formulas."""
        self._parts: list[Callable[..., Any]] = []
        if isinstance(given, (Mapping, MotionTable)):
            table = read_table(MotionTable, given, name)
            self.table = np.array(table.times), table.periodic
            self._course = _through(table)
        elif isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 3:
            raise arguments.wrong(name, given, ALLOWED)
        else:
            parts = [_component(f"{name}[{i}]", part, named) for i, part in enumerate(given)]
            self._course = _Course(_together([part.value for part in parts]), _together([part.rate for part in parts]))
            self._parts = [function_of_arrays(part, ("t", *named)) for part in given if isinstance(part, str)]
        self._start = self._found(self._course.value, 0.0, "value") if from_start else 0.0

    def __call__(self, time: float) -> np.ndarray:
        """The vector at a time; raises SceneError where it is not finite."""
        return self._found(self._course.value, time, "value") - self._start

    def rate(self, time: float) -> np.ndarray:
        """Its time derivative, exact; raises SceneError where it is not finite."""
        return self._found(self._course.rate, time, "velocity")

    def _found(self, function: OfTime, time: float, what: str) -> np.ndarray:
        try:
            found = np.asarray(function(time))
        except FormulaError:
            found = np.array(np.nan)
        if not np.isfinite(found).all():
            raise SceneError(f"{self.name}: a motion has no finite {what} at t = {time:g}")
        return found

    def sampled(self, times: np.ndarray) -> Iterator[np.ndarray]:
        """Values [time] of its formulas that change in time, for the numbers of each rod."""
        for part in self._parts:
            if "t" in part.names:  # type: ignore[attr-defined]
                for numbers in numbers_of_rods(self._named):
                    yield part(t=times, **numbers)


def _together(parts: Sequence[OfTime]) -> OfTime:
    return lambda time: np.stack(np.broadcast_arrays(*(part(time) for part in parts)), axis=-1)


def _component(name: str, given: Any, named: Mapping[str, np.ndarray]) -> _Course:
    if not isinstance(given, str):
        value = arguments.real(name, given, arguments.ANY)
        return _Course(lambda _time: value, lambda _time: 0.0)
    try:
        function = function_of_arrays(given, ("t", *named))
    except FormulaError as error:
        raise SceneError(f"{name} = {given!r}: {error}") from None
    return _Course(
        lambda time: function(t=np.float64(time), **named), lambda time: rate_of_arrays(given, time, **named)
    )


def _through(table: MotionTable) -> _Course:
    """A curve through the points of a table; periodic, or straight on beyond its ends."""
    times, points = np.array(table.times), np.array(table.points)
    if table.periodic:
        points[-1] = points[0]
    spline = curve_through(times, points, table.periodic)
    slope = spline.derivative()
    low, high = (-np.inf, np.inf) if table.periodic else (times[0], times[-1])

    def within(time: float) -> float:
        return min(max(time, low), high)

    def value(time: float) -> Any:
        inside = within(time)
        return spline(inside) + (time - inside) * slope(inside)

    return _Course(value, lambda time: slope(within(time)))

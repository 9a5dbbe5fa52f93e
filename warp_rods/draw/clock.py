"""The clock of pictures and of the page: how the times of a run are written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from warp_rods.draw.content import Content

__all__ = ["Clock", "clock_of"]

_PREFIXES = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns"), (1e-12, "ps"))
_SMALL = 1e-3
"""Numbers of runs that end before this time have a power of ten."""
_MORE = 3
"""Digits beyond the first one of the time between frames, at most: those of a third have no end."""
_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


@dataclass(frozen=True)
class Clock:
    """Times multiplied by ``factor``, with so many ``decimals``, and ``unit`` behind them."""

    factor: float
    decimals: int
    unit: str

    def text(self, time: float) -> str:
        """A time as it is written: "t = 0.25 ms"."""
        return f"t = {time * self.factor:.{self.decimals}f}{self.unit}"


def clock_of(shown: Content) -> Clock:
    """One clock for all frames of a run, whichever are chosen: it tells frames apart and gives their times in full.

    In seconds, or a part of a second in which the last time is 1 or more, where the scene has a unit of time.
    """
    times, step = shown.all_times, shown.spacing
    last = float(max(times[-1], step))
    if shown.seconds is not None:
        seconds = last * shown.seconds * (1 + 1e-9)
        one, name = next(((one, name) for one, name in _PREFIXES if seconds >= one), _PREFIXES[-1])
        factor, unit = shown.seconds / one, f" {name}"
    elif last < _SMALL:
        power = int(np.floor(np.log10(last) + 1e-9))
        factor, unit = 10.0**-power, " · 10" + str(power).translate(_RAISED)
    else:
        factor, unit = 1.0, ""
    return Clock(factor, _decimals(times * factor, step * factor), unit)


def _decimals(times: np.ndarray, step: float) -> int:
    """The fewest decimals that give the times to a thousandth of the step between them."""
    first = max(0, int(np.ceil(-np.log10(step) - 1e-9)))
    enough = (k for k in range(first, first + _MORE) if np.abs(np.round(times, k) - times).max() < 1e-3 * step)
    return next(enough, first + 1)

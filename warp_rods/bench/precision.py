"""Work against precision: the time in which a method reaches an error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def front(errors: Sequence[float], seconds: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Errors, falling, and times, rising, of the runs that no other one beats in both."""
    order = np.argsort(seconds)
    kept: list[tuple[float, float]] = []
    for error, time in zip(np.asarray(errors)[order], np.asarray(seconds)[order], strict=True):
        if np.isfinite(error) and (not kept or error < kept[-1][0]):
            kept.append((float(error), float(time)))
    column = np.array(kept).reshape(-1, 2).T
    return column[0], column[1]


def time_at(errors: Sequence[float], seconds: Sequence[float], target: float) -> float | None:
    """The time at which the error is ``target``, between two runs by powers; None where no run is so precise.

    Where the quickest run has a smaller error already, its time.
    """
    error, time = front(errors, seconds)
    if not len(error) or error[-1] > target:
        return None
    return float(np.exp(np.interp(np.log(target), np.log(error[::-1]), np.log(time[::-1]))))

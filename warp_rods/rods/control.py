"""The length of steps that rods take together, from the error of the last ones (docs/model.md §1.5)."""

from __future__ import annotations

import math

import numpy as np

TOLERANCE = 0.01
"""The error of a run that is allowed where nothing else is said."""
SAFETY = 0.85
"""Fraction of the step that the error, or the move, of one that was repeated would allow."""
GOAL = 0.5
"""The error at which steps settle, in units of what is allowed."""
SMALLEST_ERROR = 1e-6
PROPORTIONAL, INTEGRAL = 0.4, 0.7
"""Exponents of a PI controller over the order of the error of a step, 3 (Hairer and Wanner, Solving ODEs II, IV.2)."""
SHORTEN_MOST, LENGTHEN_MOST = 0.1, 2.0
"""Bounds of the ratio of a step to the one before."""
SHORTEN_INVALID = 0.25
"""The ratio of a step to one whose result was not valid."""
SHORTEST, SHORTEST_AT_START = 1e-13, 1e-30
"""The shortest step, in units of the time that is reached and of that to which the steps go."""


class Control:
    """``step``: the next step to try. ``taken`` and ``rejected`` count the tries."""

    def __init__(self, first: float):
        self.step = first
        self.taken = self.rejected = 0
        self._last_error = GOAL

    def accepts(self, dt: float, error: float, move: float, reached: float, target: float) -> bool:
        """Whether a try of ``dt`` counts with ``error`` and ``move``, in units of what is allowed; chooses the next.

        From the time ``reached`` on the way to ``target``. The shortest step counts whatever its error.
        """
        most = SAFETY / max(move, SMALLEST_ERROR)
        if max(error, move) > 1 and dt > SHORTEST * reached + SHORTEST_AT_START * target:
            self.rejected += 1
            by_error = SAFETY * error ** (-1 / 3) if math.isfinite(error) else SHORTEN_INVALID
            self.step = dt * float(np.clip(min(by_error, most), SHORTEN_MOST, SAFETY))
            return False
        self.taken += 1
        error = max(error, SMALLEST_ERROR) if math.isfinite(error) else 1.0
        factor = (error / GOAL) ** (-INTEGRAL / 3) * (self._last_error / GOAL) ** (PROPORTIONAL / 3)
        self._last_error = error
        longer = dt * float(np.clip(min(factor, most), SHORTEN_MOST, LENGTHEN_MOST))
        self.step = longer if dt >= self.step else max(self.step, longer)
        return True

    def state(self) -> np.ndarray:
        """Everything that the next steps depend on [4]."""
        return np.array([self.step, self._last_error, self.taken, self.rejected])

    def restore(self, state: np.ndarray) -> None:
        """Return to a ``state``."""
        self.step, self._last_error = float(state[0]), float(state[1])
        self.taken, self.rejected = int(state[2]), int(state[3])

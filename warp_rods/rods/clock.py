"""The clock of an ensemble: the time, and the next step, on the host and on the device."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.device import Shared
from warp_rods.kernels.layout import per_rod


class Clock:
    """``time`` that is shown, ``reached`` by the steps, and ``array`` [Δt, time reached] for the kernels.

    ``reached`` is infinite where rods have taken steps of their own, each to a time of its own beyond ``time``.
    Steps that a user plans may be divided; ``planned`` are the times reached by the last one and by that before.
    """

    def __init__(self, device: Any):
        self._shared = Shared(per_rod(2, device=device))
        self.array = self._shared.array
        self.time = self.reached = 0.0
        self.planned = (0.0, 0.0)
        self.changing = False
        """Whether the force that is set changed between the last two planned steps."""
        self.step = 0.0
        """Δt of the next steps."""

    def set_step(self, dt: float) -> None:
        """Set the length of the next step."""
        self.step = dt
        self._shared.write([dt, self.reached])

    def tick(self) -> None:
        """Advance the time by one step."""
        self.time = self.reached = self.reached + self.step

    def plan(self) -> None:
        """End a planned step."""
        self.planned = (self.reached, self.planned[0])

    @property
    def share(self) -> float:
        """The time from the last planned step to the end of this step over the length of that planned step, or 0."""
        last, before = self.planned
        return (self.reached + self.step - last) / (last - before) if last > before else 0.0

    def state(self) -> np.ndarray:
        """The whole state of the clock [6]."""
        return np.array([self.time, self.reached, self.step, *self.planned, self.changing])

    def restore(self, state: np.ndarray) -> None:
        """Return to a ``state``."""
        self.time, self.reached, self.step, last, before = (float(value) for value in state[:5])
        self.changing = bool(state[5])
        self.planned = (last, before)

"""The clock of an ensemble: the time, and the next step, on the host and on the device."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.kernels.layout import per_rod


class Clock:
    """``time`` that is shown, ``reached`` by the steps, and ``array`` [Δt, time reached] for the kernels."""

    def __init__(self, device: Any):
        self.array = per_rod(2, device=device)
        self.time = self.reached = 0.0
        self.step = 0.0
        """Δt of the next steps."""

    def set_step(self, dt: float) -> None:
        """Set the length of the next step."""
        self.step = dt
        self.array.assign([dt, self.reached])

    def tick(self) -> None:
        """Advance the time by one step."""
        self.time = self.reached = self.reached + self.step

    def state(self) -> np.ndarray:
        """The whole state of the clock [3]."""
        return np.array([self.time, self.reached, self.step])

    def restore(self, state: np.ndarray) -> None:
        """Return to a ``state``."""
        self.time, self.reached, self.step = (float(value) for value in state)

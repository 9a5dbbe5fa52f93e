"""The clock of an ensemble: the time, the next step and the last one, on the host and on the device."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_rods.kernels.clock import tick
from warp_rods.kernels.layout import per_rod


class Clock:
    """``time``, and ``array`` [Δt, ρ, t] for the kernels; ρ is the ratio of the next step to the last one."""

    def __init__(self, device: Any):
        self.array = per_rod(3, device=device)
        self.time = 0.0
        self._next = self._last = 0.0

    @property
    def step(self) -> float:
        """Δt of the next steps."""
        return self._next

    @property
    def is_new(self) -> bool:
        """Whether no step has been taken."""
        return self._last == 0.0

    def set_step(self, dt: float) -> None:
        """Set the length of the next steps. Only the value set last counts."""
        if dt != self._next:
            ratio = dt / self._last if self._last else 0.0
            self.array.assign([dt, ratio, self.time])
            self._next = dt

    def launch_tick(self) -> None:
        """Advance the time on the device by one step."""
        wp.launch(tick, dim=1, inputs=[self.array], device=self.array.device)

    def tick(self) -> None:
        """Advance the time on the host by one step, after the device has taken it."""
        self.time += self._next
        self._last = self._next

    def state(self) -> np.ndarray:
        """The whole state of the clock [6]."""
        return np.array([self.time, self._next, self._last, *self.array.numpy()])

    def restore(self, state: np.ndarray) -> None:
        """Return to a ``state``."""
        self.time, self._next, self._last = (float(value) for value in state[:3])
        self.array.assign(state[3:])

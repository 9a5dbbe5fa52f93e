"""The times at which a run saves frames, and the steps between them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.scene.tables import Time

MOST_STEPS, MOST_FRAMES = 1e10, 1e6


@dataclass(frozen=True)
class Frames:
    """Times of the frames, and numbers of steps between them."""

    times: np.ndarray
    """[frame]; the first is 0."""
    steps: np.ndarray
    """Steps from the previous frame [frame]; the first is 0."""

    @property
    def last(self) -> int:
        """The index of the last frame."""
        return len(self.times) - 1

    @property
    def longest_step(self) -> float:
        """The longest Δt between any two frames."""
        return float((np.diff(self.times) / self.steps[1:]).max())

    def steps_to(self, frame: int) -> int:
        """Steps from the start to a frame."""
        return int(self.steps[: frame + 1].sum())

    @classmethod
    def of(cls, time: Time) -> Frames:
        """The frames of a run; where no step is given, with one step between them."""
        return cls.plan(time.end, time.save_every, time.step or time.save_every)

    @classmethod
    def plan(cls, end: float, every: float, step: float) -> Frames:
        """Frames at multiples of ``every`` and at ``end``, with equal steps of at most ``step`` between two frames."""
        if not end / every < MOST_FRAMES:
            raise SceneError(f"time.save_every = {every:g}: {end / every:.3g} frames are too many; save less often")
        count = math.floor(end / every + 1e-9)
        times = every * np.arange(count + 1)  # a longer run has the same times
        if times[-1] < end * (1 - 1e-9):
            times = np.append(times, end)
        spans = np.diff(times, prepend=0.0)
        steps = np.ceil(spans / step * (1 - 1e-9))
        if not steps.sum() < MOST_STEPS:
            raise SceneError(f"time.end = {end:g}: {steps.sum():.3g} steps of {step:.3g} are too many")
        return cls(times, steps.astype(int))

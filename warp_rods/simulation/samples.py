"""Points of a membrane at which bounds on the step and on the spacing of nodes are evaluated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_rods.membranes import sampling
from warp_rods.membranes.surface import Surface
from warp_rods.rods.step_limits import SAMPLES

TIMES = 5
"""Times of a run at which a moving membrane is sampled."""


@dataclass(frozen=True)
class Sample:
    """The membrane at a time: points uniform in area, and those where it is most curved [n, 3]."""

    time: float
    surface: Surface
    uniform: np.ndarray
    curved: np.ndarray

    @property
    def principal(self) -> np.ndarray:
        """Principal curvatures at all these points [n, 2], ascending; 1/length."""
        points = np.concatenate([self.uniform, self.curved])
        return np.linalg.eigvalsh(self.surface.second_form(points)[2])


def times_of(surface: Surface, end: float) -> np.ndarray:
    """The times of a run until ``end`` at which the membrane is sampled: only the first if it is at rest."""
    return np.linspace(0.0, end, TIMES) if surface.moving else np.zeros(1)


def samples_of(surface: Surface, end: float, part: sampling.Part | None) -> list[Sample]:
    """The membrane, or a part of it, at these times; raises SceneError where it has no points."""
    found = []
    for time in times_of(surface, end):
        now = surface.at(time)
        points = sampling.uniform_points(now, SAMPLES, np.random.default_rng(0), part)
        found.append(Sample(time, now, points, sampling.curved_points(now, points)))
    return found

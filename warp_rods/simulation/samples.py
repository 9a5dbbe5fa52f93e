"""Points of a membrane at which bounds on the step and on the spacing of nodes are evaluated."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from warp_rods.membranes import sampling
from warp_rods.membranes.surface import Surface

SAMPLES = 400
"""Points uniform in area."""
DIRECTIONS = 12
"""Directions in the tangent plane in which curvature is differentiated."""
SHIFT, SMALL = 0.2, 0.1
"""Distance of the differences, in radii of curvature or in ``SMALL`` sizes of the box where those are smaller."""
TIMES = 5
"""Times of a run at which a moving membrane is sampled."""


@dataclass(frozen=True)
class Sample:
    """The membrane at a time: points uniform in area, and those where it is most curved [n, 3]."""

    time: float
    surface: Surface
    uniform: np.ndarray
    curved: np.ndarray

    @cached_property
    def principal(self) -> np.ndarray:
        """Principal curvatures at all these points [n, 2], ascending; 1/length."""
        return np.linalg.eigvalsh(self.surface.second_form(self._points)[2])

    @cached_property
    def variation(self) -> float:
        """The largest |∂²K11|, |∂²K12| along geodesics over the largest curvature; 1/length².

        By differences in each of some directions, over distances at which a spline, whose curvature has kinks, counts
        as smooth.
        """
        t1, t2, form = self.surface.second_form(self._points)
        sharpest = float(np.abs(np.linalg.eigvalsh(form)).max(initial=0.0))
        if sharpest == 0:
            return 0.0
        alpha = np.linspace(0, np.pi, DIRECTIONS, endpoint=False)[:, None, None]
        q = (np.cos(alpha) * t1 + np.sin(alpha) * t2).reshape(-1, 3)
        x = np.tile(self._points, (DIRECTIONS, 1))
        h = SHIFT * min(1 / sharpest, SMALL * float(np.linalg.norm(np.subtract(*self.surface.box))))
        with np.errstate(all="ignore"):
            before, here, after = (_curvatures(self.surface, x, q, shift) for shift in (-h, 0.0, h))
            second = np.abs(before - 2 * here + after) / h**2
        return float(second.max(initial=0.0, where=np.isfinite(second))) / sharpest

    @property
    def _points(self) -> np.ndarray:
        return np.concatenate([self.uniform, self.curved])


def _curvatures(surface: Surface, x: np.ndarray, q: np.ndarray, shift: float) -> np.ndarray:
    """K11 and K12 [2, n] at distances along geodesics from points x [n, 3] in directions q [n, 3]."""
    n = _normal(surface, x)
    moved = surface.project(x + shift * q, 4)
    _, g, H = surface.derivatives(moved)
    size = np.linalg.norm(g, axis=-1, keepdims=True)
    there = g / size
    # Parallel transport: the smallest rotation that takes one normal to the other.
    axis, cosine = np.cross(n, there), np.sum(n * there, axis=-1, keepdims=True)
    q = q + np.cross(axis, q) + np.cross(axis, np.cross(axis, q)) / (1 + cosine)
    Hq = np.einsum("nij,nj->ni", H, q) / size
    return np.array([-np.sum(q * Hq, axis=-1), -np.sum(np.cross(there, q) * Hq, axis=-1)])


def _normal(surface: Surface, x: np.ndarray) -> np.ndarray:
    g = surface.derivatives(x)[1]
    return g / np.linalg.norm(g, axis=-1, keepdims=True)


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

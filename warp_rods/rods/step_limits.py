"""The largest stable time step, estimated from the parameters (docs/model.md §3.9)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_rods.membranes.sampling import uniform_points
from warp_rods.membranes.surfaces import Surface

SAFETY = 0.75
"""A run without ``time.step`` takes this fraction of the smallest bound."""
SWIMMER_STEP = 1e-3
"""Stable for all swimmers of Figs 4.1 to 4.3; with twice this step that of Fig 4.3b (β⊥ = 8e-5, M = 1.35e-2) fails."""
SAMPLES = 400
"""Points of the surface at which the orientation stiffness is evaluated."""
ANGLES = 72
"""Orientations in the tangent plane at which the energy is evaluated."""


@dataclass(frozen=True)
class StepLimit:
    """The largest stable step, and the formula that gives it."""

    step: float
    reason: str


def orientation_stiffness(surface: Surface, points: np.ndarray, stiffness: np.ndarray, intrinsic: np.ndarray) -> float:
    """The largest e''(α) over ``points`` and angles α; force.

    e = ½B1(K12 − σ1)² + ½B2(K11 + σ2)² is the energy per length of a short geodesic filament at angle α to a principal
    direction; K11 and K12 follow from the principal curvatures.
    """
    k = np.linalg.eigvalsh(surface.second_form(points)[2])
    alpha = np.linspace(0, np.pi, ANGLES, endpoint=False)
    mean, half = k.mean(axis=-1)[:, None], (k[:, 1:] - k[:, :1]) / 2
    K11, K12 = mean + half * np.cos(2 * alpha), -half * np.sin(2 * alpha)
    d11, d12 = -2 * half * np.sin(2 * alpha), -2 * half * np.cos(2 * alpha)
    twist = d12**2 - 4 * half * np.sin(-2 * alpha) * (K12 - intrinsic[0])
    bend = d11**2 - 4 * half * np.cos(2 * alpha) * (K11 + intrinsic[1])
    return float((stiffness[0] * twist + stiffness[1] * bend).max())


def orientation_limit(stiffness: float, geodesic_stiffness: float, drag: float, length: float) -> float:
    """The largest Δt at which a filament is stable at the angle of least energy, a fraction of ζ⊥ L²/e''.

    Stiff filament: the couple e''α acts on the ends. The middle node responds through an Ω that balances the
    extrapolated 2αⁿ − αⁿ⁻¹, and the Adams-Bashforth formula extrapolates a second time. The roots of
    z⁴ − z³ + x(3z² − 5z/2 + 1/2), x = 12 e'' Δt/(ζ⊥ L²), leave the unit circle at x = 0.40; with a single extrapolation
    they would leave it at 4/3. Soft filament: in the linear problem ζ⊥ u2 = e'' α' − B3 α''' the largest stable
    fraction depends on c = e'' L²/B3 only. It drops at c = 15, where the first bending mode becomes unstable first.
    The fraction used here is 0 to 35 % below the stable one, and up to 70 % for 15 < c < 20.
    """
    if stiffness <= 0:
        return np.inf
    couple = stiffness * length**2
    fraction = 1 / 36 if couple <= 15 * geodesic_stiffness else min(1 / 160, 4 / 9 * geodesic_stiffness / couple)
    return fraction * drag * length**2 / stiffness


def filament_limits(surface: Surface, points: np.ndarray, rods) -> StepLimit:
    """The bound on Δt for an ensemble of filaments, the smallest over its rods."""
    smallest = StepLimit(np.inf, "")
    distinct = np.unique(np.column_stack([rods.stiffness, rods.intrinsic, rods.drag, rods.length]), axis=0)
    for row in distinct:
        e2 = orientation_stiffness(surface, points, row[0:3], row[3:6])
        step = orientation_limit(e2, row[2], row[7], row[9])
        if step < smallest.step:
            fraction = step * e2 / (row[7] * row[9] ** 2)
            smallest = StepLimit(step, f"{fraction:.2g} ζ⊥ L²/e'' with orientation stiffness e'' = {e2:.3g}")
    return smallest


def membrane_limit(surface: Surface, rods) -> StepLimit:
    """The bound on Δt for an ensemble of filaments anywhere on a surface."""
    return filament_limits(surface, uniform_points(surface, SAMPLES, np.random.default_rng(0)), rods)


def swimmer_limit(passive: bool) -> StepLimit:
    """The bound on Δt for an ensemble of free rods; none is known for passive ones, whose unit of time is arbitrary."""
    return StepLimit(np.inf, "") if passive else StepLimit(SWIMMER_STEP, "empirical, see docs/model.md §3.9")


def wall_limit(strength: float, drag: float) -> StepLimit:
    """The bound on Δt for a wall of this stiffness k, (4/3) ζ⊥/k (docs/model.md §6.3, §6.4)."""
    return StepLimit(4 / 3 * drag / strength, "(4/3) ζ⊥/k for the wall of the box")

"""How large a step the scheme for bound filaments holds (model §3), from its parameters alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_rods.membranes.surfaces import Surface

SAFETY = 0.75
"""Share of the smallest bound that a run takes when the scene names no step."""
ANGLES = 72


@dataclass(frozen=True)
class StepLimit:
    """A largest stable step and the reason for it."""

    step: float
    reason: str


def orientation_stiffness(surface: Surface, points: np.ndarray, stiffness: np.ndarray, intrinsic: np.ndarray) -> float:
    """Largest e''(α): second derivative of the energy per length of a geodesic piece turned by α, over ``points``.

    e = ½B1(K12 − σ1)² + ½B2(K11 + σ2)², with K11, K12 of principal curvatures at angle α. Force.
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
    """Largest Δt at which the scheme holds a rod at its angle of least energy: a share of ζ⊥ L²/e''.

    The couple e''α acts on the ends, the middle learns of it through an Ω that is in balance with the extrapolated
    2αⁿ − αⁿ⁻¹, and AB2 extrapolates once more: z⁴ − z³ + x(3z² − 5z/2 + 1/2), x = Δt 12e''/ζ⊥L², leaves the unit circle
    at x = 0.40, not at the 4/3 of SBDF2 alone. That is a stiff rod; the largest share of the linear problem
    ζ⊥ u2 = e'' α' − B3 α''' depends on c = e'' L²/B3 alone and drops at c = 15, where the first beam mode takes over.
    The share taken lies 0 to 35 % below it, for 15 < c < 20 up to 70 %.
    """
    if stiffness <= 0:
        return np.inf
    orienting = stiffness * length**2
    share = 1 / 36 if orienting <= 15 * geodesic_stiffness else min(1 / 160, 4 / 9 * geodesic_stiffness / orienting)
    return share * drag * length**2 / stiffness


def filament_limits(surface: Surface, points: np.ndarray, rods) -> StepLimit:
    """The bound on Δt that an ensemble's elasticity sets, the smallest over its rods."""
    worst = StepLimit(np.inf, "")
    distinct = np.unique(np.column_stack([rods.stiffness, rods.intrinsic, rods.drag, rods.length]), axis=0)
    for row in distinct:
        e2 = orientation_stiffness(surface, points, row[0:3], row[3:6])
        step = orientation_limit(e2, row[2], row[7], row[9])
        if step < worst.step:
            share = step * e2 / (row[7] * row[9] ** 2)
            worst = StepLimit(step, f"{share:.2g} ζ⊥ L²/e'' with orientation stiffness e'' = {e2:.3g}")
    return worst


def wall_limit(strength: float, drag: float) -> StepLimit:
    """The bound on Δt that a wall of this stiffness k sets: (4/3) ζ⊥/k, of SBDF2 with the force extrapolated."""
    return StepLimit(4 / 3 * drag / strength, "(4/3) ζ⊥/k of the box's wall")

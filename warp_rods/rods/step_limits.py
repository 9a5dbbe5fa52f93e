"""Bounds on the time step, for stability and accuracy, estimated from the parameters (docs/model.md §2.9, §3.9)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from warp_rods.membranes.sampling import curved_points, uniform_points
from warp_rods.membranes.surfaces import Surface

SAFETY = 0.75
"""A run without ``time.step`` takes this fraction of the smallest bound."""
SAMPLES = 400
"""Points of the surface, uniform in area, at which the bounds of filaments are evaluated."""
ANGLES = 72
"""Orientations in the tangent plane at which the energy is evaluated."""
SLIDING_ANGLES = 12
"""Directions in the tangent plane in which the energy along the surface is evaluated."""
SHIFT = 0.02
"""Distance of the differences along the surface, in radii of curvature."""
SLIDING = 0.1
"""Δt times the largest rate of sliding along. At 0.075 filaments with little drag along are 1 % off, at 0.3 13 %."""
BENDING = 0.1
"""Δt times the rate of the first bending mode. At 0.075 the place to which a bent start relaxes is 1.5 % off."""
FIRST_MODE = 500.56
"""x⁴ of the first beam mode with free ends, x = 4.73004."""
RESOLVED = 1.0
"""Bending in radians per cell up to which places of the surface count; at sharper ones filaments are frozen."""
SWIMMER_STEP = 1e-3
"""Stable for all swimmers of Figs 4.1 to 4.3; with twice this step that of Fig 4.3b (β⊥ = 8e-5, M = 1.35e-2) fails."""
FLAGELLA = 3.0
"""Δt in units of τf. At 3.3 a swimmer is right to 1e-3, at 25 its direction is wrong."""
SOFT = 30.0
"""Δt in units of β⊥ η: the fastest buckling grows at λ²/4β⊥η, and −λ is 1/2 at most."""


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
    return float(turning_stiffness(k, stiffness, intrinsic).max())


def turning_stiffness(principal: np.ndarray, stiffness: np.ndarray, intrinsic: np.ndarray) -> np.ndarray:
    """The largest e''(α) over the angles α at points with these principal curvatures [n, 2], ascending; force [n]."""
    k = principal
    alpha = np.linspace(0, np.pi, ANGLES, endpoint=False)
    mean, half = k.mean(axis=-1)[:, None], (k[:, 1:] - k[:, :1]) / 2
    K11, K12 = mean + half * np.cos(2 * alpha), -half * np.sin(2 * alpha)
    d11, d12 = -2 * half * np.sin(2 * alpha), -2 * half * np.cos(2 * alpha)
    twist = d12**2 - 4 * half * np.sin(-2 * alpha) * (K12 - intrinsic[0])
    bend = d11**2 - 4 * half * np.cos(2 * alpha) * (K11 + intrinsic[1])
    return (stiffness[0] * twist + stiffness[1] * bend).max(axis=-1)


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


def membrane_limit(
    surface: Surface,
    rods: Any,
    nodes: np.ndarray | None = None,
    points: np.ndarray | None = None,
    curved: np.ndarray | None = None,
) -> StepLimit:
    """The bound on Δt for filaments anywhere on a surface, and at their ``nodes`` [rod, node, 3], if given.

    points [n, 3]: uniform in area; drawn where they are not given. They miss thin necks, so more are taken where
    curvature is largest, ``curved`` [n, 3], found where they are not given. The bound from the uniform points is kept
    where these do not reduce it by more than ``SAFETY``, which a chosen step keeps anyway.
    """
    points = uniform_points(surface, SAMPLES, np.random.default_rng(0)) if points is None else points
    sliding = sliding_limit(surface, points, rods)
    coarse = min(filament_limits(surface, points, rods), sliding, key=lambda limit: limit.step)
    curved = curved_points(surface, points) if curved is None else curved
    more = [curved, np.empty((0, 3)) if nodes is None else nodes[:, ::4].reshape(-1, 3)]
    extra = np.concatenate(more)
    spacing = np.min(rods.length) / (rods.nodes - 1)
    extra = extra[np.abs(np.linalg.eigvalsh(surface.second_form(extra)[2])).max(axis=-1) * spacing < RESOLVED]
    if not len(extra):
        return coarse
    found = [filament_limits(surface, extra, rods), sliding_limit(surface, extra, rods)]
    fine = min(found, key=lambda limit: limit.step)
    return fine if fine.step < SAFETY * coarse.step else coarse


def node_limit(curvature: np.ndarray, rods: Any) -> np.ndarray:
    """The bound on Δt for turning of each filament [rod] where it is; curvature: K11, K12, K22 [rod, node, 3]."""
    K = curvature[:, ::4]
    mean, spread = (K[..., 0] + K[..., 2]) / 2, np.hypot((K[..., 0] - K[..., 2]) / 2, K[..., 1])
    principal = np.stack([mean - spread, mean + spread], axis=-1)
    found = []
    for k, B, sigma, drag, length in zip(
        principal, rods.stiffness, rods.intrinsic, rods.drag, rods.length, strict=True
    ):
        e2 = float(turning_stiffness(k, B, sigma).max())
        found.append(orientation_limit(e2, B[2], drag[1], length))
    return np.array(found)


def sliding_limit(surface: Surface, points: np.ndarray, rods: Any) -> StepLimit:
    """The bound on Δt for sliding along: the energy per length e(s) of geodesics restores a filament at e''/ζ∥ at most.

    A filament that is longer than e varies is restored by the difference of e at its ends, at 2 |e'|/(L ζ∥) at most.
    """
    curvatures, shift = curvatures_along(surface, points)
    smallest = StepLimit(np.inf, "")
    for row in np.unique(np.column_stack([rods.stiffness, rods.intrinsic, rods.drag, rods.length]), axis=0):
        e = 0.5 * row[0] * (curvatures[1] - row[3]) ** 2 + 0.5 * row[1] * (curvatures[0] + row[4]) ** 2
        e1 = float(np.max(np.abs(e[2] - e[0]) / (2 * shift), initial=0.0))
        e2 = min(float(np.max((e[0] - 2 * e[1] + e[2]) / shift**2, initial=0.0)), 2 * e1 / row[9])
        if e2 > 0 and (step := SLIDING * row[6] / e2) < smallest.step:
            reason = f"{SLIDING:g} ζ∥/e'' with e'' = {e2:.3g} of the energy per length along the membrane"
            smallest = StepLimit(step, reason)
    return smallest


def curvatures_along(surface: Surface, points: np.ndarray) -> tuple[np.ndarray, float]:
    """K11 and K12 [2, 3, n] of geodesics through points, at −h, 0 and h along them in every direction; and h, length.

    Places whose neighbours are not found on the surface are left out.
    """
    t1, t2, form = surface.second_form(points)
    size = float(np.linalg.norm(np.subtract(*surface.box)))
    sharpest = float(np.abs(np.linalg.eigvalsh(form)).max(initial=0.0))
    h = SHIFT * min(0.1 * size, 1 / sharpest if sharpest else np.inf)
    alpha = np.linspace(0, np.pi, SLIDING_ANGLES, endpoint=False)[:, None, None]
    q = (np.cos(alpha) * t1 + np.sin(alpha) * t2).reshape(-1, 3)
    x = np.tile(points, (SLIDING_ANGLES, 1))
    with np.errstate(all="ignore"):
        found = np.array([_along(surface, surface.project(x + k * h * q, 4), q) for k in (-1, 0, 1)])
    return np.moveaxis(found, 1, 0)[..., np.isfinite(found).all(axis=(0, 1))], h


def _along(surface: Surface, x: np.ndarray, q: np.ndarray) -> np.ndarray:
    """K11 and K12 [2, n] at points [n, 3] for tangents q [n, 3], which are projected into the tangent plane."""
    _, g, H = surface.derivatives(x)
    size = np.linalg.norm(g, axis=-1)
    n = g / size[:, None]
    q = q - n * np.sum(q * n, axis=-1, keepdims=True)
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    Hq = np.einsum("nij,nj->ni", H, q)
    return np.array([-np.sum(q * Hq, axis=-1), -np.sum(np.cross(n, q) * Hq, axis=-1)]) / size


def bent_start_limit(rods: Any, geodesic: np.ndarray) -> StepLimit:
    """The bound on Δt for filaments that start with a geodesic curvature [rod, node] other than σ3 inside.

    The first bending mode relaxes at (B3/ζ⊥)(4.73/L)⁴. Steps that are longer leave the filament at another place.
    """
    bent = (np.abs(geodesic - rods.intrinsic[:, 2:3]) * rods.length[:, None] > 0.01).any(axis=1)
    if not bent.any():
        return StepLimit(np.inf, "")
    rate = float((FIRST_MODE * rods.stiffness[:, 2] / (rods.drag[:, 1] * rods.length**4))[bent].max())
    return StepLimit(
        BENDING / rate, f"{BENDING:g} of the relaxation time {1 / rate:.3g} of their bent start, L⁴ζ⊥/501 B3"
    )


def swimmer_limit(rods: Any, passive: bool = False) -> StepLimit:
    """The bound on Δt for an ensemble of free rods; all but the first depend on their parameters.

    None is known for passive ones, whose unit of time is arbitrary.
    """
    if passive:
        return StepLimit(np.inf, "")
    b, eta = rods.bend, rods.drag_ratio
    bounds = [
        StepLimit(SWIMMER_STEP, "empirical, see docs/model.md §2.9"),
        StepLimit(FLAGELLA * float(rods.relaxation.min()), f"{FLAGELLA:g} τf, the relaxation of the flagella"),
        StepLimit(float((BENDING * eta / (FIRST_MODE * b)).min()), f"{BENDING:g} of the relaxation time η/501 β⊥"),
        StepLimit(float((SOFT * b * eta).min()), f"{SOFT:g} β⊥ η, for soft swimmers that buckle fast"),
    ]
    return min(bounds, key=lambda limit: limit.step)


def wall_limit(strength: float, drag: float) -> StepLimit:
    """The bound on Δt for a wall of this stiffness k, (4/3) ζ⊥/k (docs/model.md §6.3, §6.4)."""
    return StepLimit(4 / 3 * drag / strength, "(4/3) ζ⊥/k for the wall of the box")

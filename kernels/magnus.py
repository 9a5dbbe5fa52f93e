"""Frames over a step from rates that are known at some times: Magnus steps of fourth order (4.29).

S' = S A with A = (ω, u). With A at both Gauss points of a step of length h, from the polynomial through the levels,
S(end) = S(start) exp(h (A₁ + A₂)/2 + (√3/12) h² [A₁, A₂]) (Iserles and Nørsett 1999, for the other side of S).
"""

from typing import Any

import warp as wp

from warp_rods.kernels.layout import Scalars2D, Vectors2D, real
from warp_rods.kernels.lie import ad
from warp_rods.kernels.multistep import Levels, Pace, weights_at

wp.set_module_options({"enable_backward": False})

RATES = wp.constant(4)
"""Levels of rates that are kept."""
GAUSS = wp.constant(real(0.28867513459481287))
"""√3/6, the distance of the Gauss points from the middle of a step of length 1."""
COMMUTATOR = wp.constant(real(0.14433756729740643))
"""√3/12."""


@wp.func
def levels_of_rates(pace: Pace, rod: int, order: int) -> int:
    """Levels at which rates are known, no more than the order needs; not those of the start."""
    return wp.min(wp.min(pace.levels[rod] - 1, order), RATES)


@wp.func
def rate_at(values: Any, rod: int, w: Levels):
    """Σ w_j of the rates at the levels."""
    total = w[0] * values[rod, 0]
    for j in range(1, RATES):
        total += w[j] * values[rod, j]
    return total


@wp.func
def gauss_point(start: real, end: real, side: real):
    """The first (side −1) or second (side 1) Gauss point of an interval."""
    return real(0.5) * (start + end) + side * GAUSS * (end - start)


@wp.func
def mean_over(values: Scalars2D, rod: int, at: Levels, levels: int, start: real, end: real):
    """The mean of a rate over an interval."""
    first = rate_at(values, rod, weights_at(at, levels, gauss_point(start, end, real(-1.0))))
    second = rate_at(values, rod, weights_at(at, levels, gauss_point(start, end, real(1.0))))
    return real(0.5) * (first + second)


@wp.func
def twist_over(omega: Vectors2D, u: Vectors2D, rod: int, at: Levels, levels: int, start: real, end: real):
    """(θ, μ) whose exponential carries the frame from ``start`` to ``end``."""
    w1 = weights_at(at, levels, gauss_point(start, end, real(-1.0)))
    w2 = weights_at(at, levels, gauss_point(start, end, real(1.0)))
    omega1, u1 = rate_at(omega, rod, w1), rate_at(u, rod, w1)
    omega2, u2 = rate_at(omega, rod, w2), rate_at(u, rod, w2)
    theta, mu = ad(omega1, u1, omega2, u2)
    h = end - start
    half = real(0.5) * h
    twist = COMMUTATOR * h * h
    return half * (omega1 + omega2) + twist * theta, half * (u1 + u2) + twist * mu

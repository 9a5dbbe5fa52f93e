"""The drag by which a step treats contact, in the formulas of backward differences (docs/model.md §6.4).

Contact acts at the extrapolated places r*. A node of stiffness K = −∂F/∂r feels from none of it, where its neighbours
move along, up to twice, where they move against it: κ = 2K at most. What is implicit holds it back from leaving r**::

    F(r*) − s (r − r**),     r** = r* + θ (r − r*)ⁿ,     s = a D

(r − r*)ⁿ is how far the last step ended from its r*, for the length of this one: θ = 1 extrapolates by one order more.
s is the smallest for which the step is stable on ζ dr/dt = −κ' r for every κ' from 0 to κ, with a margin. That is
decided by places that change sign in each step, the first to grow. Where s is zero, contact is explicit. A motion that
neighbours share is held back by (1 − θ) s only. θ = 1 is stable for κΔt/ζ up to 5, and damps less from 3 on.
"""

import warp as wp

from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    Pair,
    Vector,
    add,
    div,
    larger,
    mul,
    pair,
    rods_in,
    smaller,
    sqrt,
    sub,
    vector,
    where,
)
from warp_rods.kernels.layout import Integers1D, Scalars1D, real
from warp_rods.kernels.multistep import Pace, Weights

wp.set_module_options({"enable_backward": False})

MARGIN = wp.constant(real(1.2))
"""The κ for which a step is stable over the largest at r*: it changes in the step."""
SOFT, STIFF = wp.constant(real(3.0)), wp.constant(real(10.0))
"""κΔt/ζ up to which θ = 1, and from which θ = 0."""


@wp.struct
class Alternating:
    """The terms of a formula where places are 1, −1, 1 at its levels, newest first, and −1 at its end."""

    foretold: Lanes  # r*
    slope: Lanes  # −dr/dt
    lag: Lanes  # (r − r*)ⁿ times ``ratio``
    ratio: Lanes  # how far a smooth motion ends from r* over how far it did in the last step; 0: not known
    rate: Lanes  # a


@wp.func
def alternating(tile: int, pace: Pace, order: Integers1D, end: Scalars1D, e: Weights, d: Weights, a: Lanes):
    """These terms for steps of order 1 or 2 to the times ``end``, with the weights e and d of the formula and a."""
    terms = Alternating()
    terms.foretold = e[0] - e[1]
    terms.slope = a * (real(1.0) + terms.foretold) - d[0] + d[1]
    terms.rate = a
    ratio, lag = Lanes(), Lanes()
    for lane in range(rods_in(tile, end.shape[0])):
        rod = tile * WIDTH + lane
        if pace.levels[rod] > 2 and order[rod] == 2:
            t, at = end[rod], pace.at[rod, 0]
            last, before = at - pace.at[rod, 1], pace.at[rod, 1] - pace.at[rod, 2]
            growth = (t - at) * (t - pace.at[rod, 1]) / (last * (last + before))
            ratio[lane] = wp.min(growth, real(1.0))
            lag[lane] = real(2.0) * (real(1.0) + last / before) * ratio[lane]
    terms.ratio = ratio
    terms.lag = lag
    return terms


@wp.func
def share_foretold(stiffness: Lanes, drag: Lanes, terms: Alternating) -> Lanes:
    """θ, for the largest κ of a node over its ζ."""
    in_a_step = real(1.5) * stiffness / (terms.rate * drag)
    share = (STIFF - in_a_step) / (STIFF - SOFT)
    return smaller(larger(share, Lanes()), Lanes(real(1.0)))


@wp.func
def drag_for(stiffness: Lanes, drag: Lanes, share: Lanes, terms: Alternating) -> Lanes:
    """D for κ besides a drag ζ, where ``share`` is θ."""
    excess = MARGIN * stiffness * terms.foretold - drag * terms.slope
    return larger(excess, Lanes()) / (terms.rate * (real(1.0) + terms.foretold + share * terms.lag))


@wp.func
def principal(K: Vector) -> Pair:
    """Mean and half difference of the principal values of 2K in a plane; K is (K11, K12, K22)."""
    difference = K[0] - K[2]
    return pair(K[0] + K[2], sqrt(difference * difference + real(4.0) * (K[1] * K[1])))


@wp.func
def drag_in_plane(K: Vector, drag: Lanes, share: Lanes, terms: Alternating) -> Vector:
    """(D11, D12, D22): ``drag_for`` in the principal directions of K."""
    kappa = principal(K)
    most = drag_for(kappa[0] + kappa[1], drag, share, terms)
    least = drag_for(kappa[0] - kappa[1], drag, share, terms)
    slope = where(kappa[1], real(0.5) * (most - least) / kappa[1], Lanes())
    mean, half = real(0.5) * (most + least), slope * (K[0] - K[2])
    return vector(mean + half, real(2.0) * slope * K[1], mean - half)

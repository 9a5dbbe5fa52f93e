"""The implicit part of a step of surface-bound filaments: a pentadiagonal system in the angle (docs/model.md §3.5).

What limits explicit steps turns the filament in its tangent plane, and is local in the angle α of that turn, but not
in Ω. The unknown is δα at half nodes, the turn beyond the extrapolated state; half node j lies between the nodes j and
j + 1 and is stored at j::

    δΩ_j = (δα_j − δα_(j−1))/Δs,     (a − J) δα = g,     J δα = (δu2)'
    Z22 δu2 = −(B3 δΩ)'' + (e″ δα)',   e″ = B1 (K22 − K11)² + 4 B2 K12²

e″ is the stiffness per length against the turn: the Gauss–Newton part of the second derivative of the energy of twist
and normal bending. ``g`` follows from the rates at the extrapolated state, ``g_j − g_(j−1) = Δs (∂Ω/∂t − Σ d Ω)_j``,
and at the tracked node from ω2, or from its clamp.
"""

import warp as wp

from warp_rods.kernels.bound.rod import angular_velocity, is_clamped, resistance_at
from warp_rods.kernels.bound.state import Filaments, Quadruples, Systems
from warp_rods.kernels.lanes import Block, Lanes, Lanes2D, add, block, div, mul, sub  # noqa: F401 (operators)
from warp_rods.kernels.layout import real
from warp_rods.kernels.stencils import half_average

wp.set_module_options({"enable_backward": False})


@wp.func
def turning_stiffness(f: Filaments, tile: int, j: int) -> Lanes:
    """e″ at half node j; 0 beyond the ends."""
    if j < 0 or j >= f.geodesic.shape[1] - 1:
        return Lanes()
    K = half_average(f.curvature, tile, j)
    B = half_average(f.stiffness, tile, j)
    difference = K[2] - K[0]
    return B[0] * difference * difference + real(4.0) * B[1] * K[1] * K[1]


@wp.func
def bending_stiffness(f: Filaments, tile: int, i: int) -> Lanes:
    """−B3/Δs³ at node i; 0 beyond the ends."""
    if i < 0 or i >= f.geodesic.shape[1]:
        return Lanes()
    h = f.spacing[tile]
    return -f.stiffness[tile, i][2] / (h * h * h)


@wp.func
def bending_weights(f: Filaments, i: int, before: Lanes, here: Lanes, after: Lanes) -> Block:
    """Weights of δα at the half nodes i − 2 to i + 1 in −(B3 δΩ)'' at node i; −B3/Δs³ at the nodes i − 1, i, i + 1.

    A free end has δΩ = 0. At a clamped end the angle is zero: δΩ there is twice the angle next to it over Δs.
    """
    last = f.geodesic.shape[1] - 1
    two = real(2.0)
    if i == 0:
        return block(Lanes(), Lanes(), -two * after, two * after)
    if i == last:
        return block(-two * before, two * before, Lanes(), Lanes())
    w0, w1, w2, w3 = -before, two * here + before, -(two * here + after), after
    if i == 1:
        w0 = Lanes()
        w1 = two * here + real(2 * f.start_clamped) * before
    if i == last - 1:
        w2 = -(two * here + real(2 * f.end_clamped) * after)
        w3 = Lanes()
    return block(w0, w1, w2, w3)


@wp.func
def turn_to_velocity(f: Filaments, tile: int, i: int, w: Block, before: Lanes, after: Lanes) -> Block:
    """Weights of δα at the half nodes i − 2 to i + 1 in δu2 at node i.

    w: those of −(B3 δΩ)''; e″ ``before`` and ``after`` the node. At a free end m3' varies by e″ δα with the turn.
    """
    if is_clamped(f, i):
        return Block()
    last = f.geodesic.shape[1] - 1
    h = f.spacing[tile]
    w0, w1, w2, w3 = w[0], w[1], w[2], w[3]
    if i == 0:
        w2 += after / h
        w3 += turning_stiffness(f, tile, 1) / h
    elif i == last:
        w1 -= before / h
        w0 -= turning_stiffness(f, tile, last - 2) / h
    else:
        w1 -= before / h
        w2 += after / h
    mobility = real(1.0) / resistance_at(f, tile, i)[2]
    return block(w0 * mobility, w1 * mobility, w2 * mobility, w3 * mobility)


@wp.func
def find_turn_to_velocity(f: Filaments, tile: int, weights: Quadruples):
    """``turn_to_velocity`` at nodes."""
    before, B_before, B = Lanes(), Lanes(), bending_stiffness(f, tile, 0)
    for i in range(f.geodesic.shape[1]):
        after, B_after = turning_stiffness(f, tile, i), bending_stiffness(f, tile, i + 1)
        weights[tile, i] = turn_to_velocity(f, tile, i, bending_weights(f, i, B_before, B, B_after), before, after)
        before = after
        B_before = B
        B = B_after


@wp.func
def set_angle_rows(f: Filaments, tile: int, rate: Lanes, systems: Systems):
    """Rows of a − J at half nodes; the row after the last half node is that of a given value."""
    last = f.geodesic.shape[1] - 1
    per_length = real(1.0) / f.spacing[tile]
    here = systems.weights[tile, 0]
    for i in range(last):
        after = systems.weights[tile, i + 1]
        systems.lower2[tile, i] = per_length * here[0]
        systems.lower[tile, i] = per_length * (here[1] - after[0])
        systems.diagonal[tile, i] = rate + per_length * (here[2] - after[1])
        systems.upper[tile, i] = per_length * (here[3] - after[2])
        systems.upper2[tile, i] = -per_length * after[3]
        here = after
    systems.diagonal[tile, last] = Lanes(real(1.0))
    systems.lower[tile, last] = Lanes()
    systems.lower2[tile, last] = Lanes()


@wp.func
def set_end_constant(f: Filaments, source: Lanes, a: Lanes, tile: int, rhs: Lanes2D):
    """The constant c in δΩ = −2 δα/Δs + c at the last end, where both are clamped, and its part in δu2 next to it.

    It follows from ``a δΩ − 2 δu2/Δs² = source`` at the end and the row of the last half node, ``a δα + δu2/Δs = g``.
    """
    last = f.geodesic.shape[1] - 1
    h = f.spacing[tile]
    c = (source + real(2.0) * rhs[tile, last - 1] / h) / a
    du2 = -f.stiffness[tile, last][2] * c / (h * h * resistance_at(f, tile, last - 1)[2])
    rhs[tile, last - 1] = rhs[tile, last - 1] - du2 / h
    rhs[tile, last - 2] = rhs[tile, last - 2] + du2 / h
    rhs[tile, last] = c


@wp.func
def set_angle_rhs(f: Filaments, tile: int, slope: Lanes2D, turn_slope: Lanes, rate: Lanes, rhs: Lanes2D):
    """g at half nodes, from the tracked node outwards; ``slope`` is Σ d Ω, ``turn_slope`` Σ d ψ, ``rate`` a.

    After the last half node, ``set_end_constant`` or 0.
    """
    last = f.geodesic.shape[1] - 1
    h = f.spacing[tile]
    half = real(0.5) * h
    node = f.tracked
    source = f.geodesic_rate[tile, node] - slope[tile, node]
    centre = Lanes()
    if not is_clamped(f, node):
        centre = angular_velocity(f, tile, node)[2] - turn_slope
    if node < last:
        g = centre + half * source
        rhs[tile, node] = g
        for j in range(node + 1, last):
            g += h * (f.geodesic_rate[tile, j] - slope[tile, j])
            rhs[tile, j] = g
    if node > 0:
        g = centre - half * source
        rhs[tile, node - 1] = g
        for k in range(node - 1):
            j = node - 1 - k
            g -= h * (f.geodesic_rate[tile, j] - slope[tile, j])
            rhs[tile, j - 1] = g
    rhs[tile, last] = Lanes()
    if f.start_clamped == 1 and f.end_clamped == 1:
        set_end_constant(f, f.geodesic_rate[tile, last] - slope[tile, last], rate, tile, rhs)


@wp.func
def geodesic_increment(f: Filaments, turn: Lanes2D, tile: int, i: int):
    """δΩ at a node."""
    last = f.geodesic.shape[1] - 1
    h = f.spacing[tile]
    if i == 0:
        return real(2 * f.start_clamped) * turn[tile, 0] / h
    if i == last:
        return real(-2 * f.end_clamped) * turn[tile, last - 1] / h + turn[tile, last]
    return (turn[tile, i] - turn[tile, i - 1]) / h


@wp.func
def velocity_increment(turn: Lanes2D, weights: Quadruples, tile: int, i: int):
    """δu2 at a node."""
    last = turn.shape[1] - 1  # one more than the last half node
    w = weights[tile, i]
    total = Lanes()
    for k in range(4):
        j = i - 2 + k
        if j >= 0 and j < last:
            total += w[k] * turn[tile, j]
    return total

"""The implicit part of a step of surface-bound filaments: a pentadiagonal system in the angle (docs/model.md §3.5).

What limits explicit steps turns the filament in its tangent plane, and is local in the angle α of that turn, but not
in Ω. The unknown is δα at half nodes, the turn beyond the extrapolated state; half node j lies between the nodes j and
j + 1 and is stored at j::

    δΩ_j = (δα_j − δα_(j−1))/Δs,     (a − J) δα = g,     J δα = (δu2)'
    Z22 δu2 = −B3 δΩ'' + (e″ δα)',   e″ = B1 (K22 − K11)² + 4 B2 K12²

e″ is the stiffness per length against the turn: the Gauss–Newton part of the second derivative of the energy of twist
and normal bending. ``g`` follows from the rates at the extrapolated state, ``g_j − g_(j−1) = Δs (∂Ω/∂t − Σ d Ω)_j``,
and at the tracked node from ω2, or from its clamp.
"""

import warp as wp

from warp_rods.kernels.bound.rod import angular_velocity, is_clamped, resistance_at
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.layout import Quadruples2D, Scalars1D, Scalars2D, real
from warp_rods.kernels.stencils import half_average

wp.set_module_options({"enable_backward": False})


@wp.func
def turning_stiffness(f: Filaments, rod: int, j: int) -> real:
    """e″ at half node j; 0 beyond the ends."""
    if j < 0 or j >= f.geodesic.shape[1] - 1:
        return real(0.0)
    K = half_average(f.curvature, rod, j)
    B = f.stiffness[rod]
    difference = K[2] - K[0]
    return B[0] * difference * difference + real(4.0) * B[1] * K[1] * K[1]


@wp.func
def bending_weights(f: Filaments, i: int) -> wp.vec4d:
    """Weights of δα at the half nodes i − 2 to i + 1 in Δs³ δΩ'' at node i.

    A free end has δΩ = 0. At a clamped end the angle is zero: δΩ there is twice the angle next to it over Δs.
    """
    last = f.geodesic.shape[1] - 1
    one, two, three, four = real(1.0), real(2.0), real(3.0), real(4.0)
    w = wp.vec4d(-one, three, -three, one)
    if i == 0:
        w = wp.vec4d(real(0.0), real(0.0), -two, two)
    elif i == last:
        w = wp.vec4d(-two, two, real(0.0), real(0.0))
    if i == 1:
        w[1] = two
        if f.start_clamped == 1:
            w[1] = four
        w[0] = real(0.0)
    if i == last - 1:
        w[2] = -two
        if f.end_clamped == 1:
            w[2] = -four
        w[3] = real(0.0)
    return w


@wp.func
def turn_to_velocity(f: Filaments, rod: int, i: int) -> wp.vec4d:
    """Weights of δα at the half nodes i − 2 to i + 1 in δu2 at node i.

    At a free end m3' varies by e″ δα with the turn.
    """
    if is_clamped(f, i):
        return wp.vec4d()
    last = f.geodesic.shape[1] - 1
    h = f.spacing[rod]
    w = -f.stiffness[rod][2] / (h * h * h) * bending_weights(f, i)
    if i == 0:
        w[2] += turning_stiffness(f, rod, 0) / h
        w[3] += turning_stiffness(f, rod, 1) / h
    elif i == last:
        w[1] -= turning_stiffness(f, rod, last - 1) / h
        w[0] -= turning_stiffness(f, rod, last - 2) / h
    else:
        w[1] -= turning_stiffness(f, rod, i - 1) / h
        w[2] += turning_stiffness(f, rod, i) / h
    return w / resistance_at(f, rod, i)[2]


@wp.kernel
def find_turn_to_velocity(f: Filaments, weights: Quadruples2D):
    """``turn_to_velocity`` at nodes."""
    rod, i = wp.tid()
    if f.active[rod] == 1:
        weights[rod, i] = turn_to_velocity(f, rod, i)


@wp.kernel
def set_angle_rows(
    f: Filaments,
    rate: Scalars1D,
    weights: Quadruples2D,
    lower2: Scalars2D,
    lower: Scalars2D,
    diagonal: Scalars2D,
    upper: Scalars2D,
    upper2: Scalars2D,
):
    """Rows of a − J at half nodes; the row after the last half node is that of a given value."""
    rod, i = wp.tid()
    if f.active[rod] == 0:
        return
    if i == f.geodesic.shape[1] - 1:
        diagonal[rod, i] = real(1.0)
        lower[rod, i] = real(0.0)
        lower2[rod, i] = real(0.0)
        return
    per_length = real(1.0) / f.spacing[rod]
    here = weights[rod, i]
    after = weights[rod, i + 1]
    lower2[rod, i] = per_length * here[0]
    lower[rod, i] = per_length * (here[1] - after[0])
    diagonal[rod, i] = rate[rod] + per_length * (here[2] - after[1])
    upper[rod, i] = per_length * (here[3] - after[2])
    upper2[rod, i] = -per_length * after[3]


@wp.func
def set_end_constant(f: Filaments, source: real, a: real, rod: int, rhs: Scalars2D):
    """The constant c in δΩ = −2 δα/Δs + c at the last end, where both are clamped, and its part in δu2 next to it.

    It follows from ``a δΩ − 2 δu2/Δs² = source`` at the end and the row of the last half node, ``a δα + δu2/Δs = g``.
    """
    last = f.geodesic.shape[1] - 1
    h = f.spacing[rod]
    c = (source + real(2.0) * rhs[rod, last - 1] / h) / a
    du2 = -f.stiffness[rod][2] * c / (h * h * resistance_at(f, rod, last - 1)[2])
    rhs[rod, last - 1] = rhs[rod, last - 1] - du2 / h
    rhs[rod, last - 2] = rhs[rod, last - 2] + du2 / h
    rhs[rod, last] = c


@wp.kernel
def set_angle_rhs(
    f: Filaments, rate_of_change: Scalars2D, slope: Scalars2D, turn_slope: Scalars1D, rate: Scalars1D, rhs: Scalars2D
):
    """g at half nodes, from the tracked node outwards; ``slope`` is Σ d Ω, ``turn_slope`` Σ d ψ, ``rate`` a.

    After the last half node, ``set_end_constant`` or 0.
    """
    rod = wp.tid()
    if f.active[rod] == 0:
        return
    last = f.geodesic.shape[1] - 1
    h = f.spacing[rod]
    half = real(0.5) * h
    node = f.tracked
    source = rate_of_change[rod, node] - slope[rod, node]
    centre = real(0.0)
    if not is_clamped(f, node):
        centre = angular_velocity(f, rod, node)[2] - turn_slope[rod]
    if node < last:
        g = centre + half * source
        rhs[rod, node] = g
        for j in range(node + 1, last):
            g += h * (rate_of_change[rod, j] - slope[rod, j])
            rhs[rod, j] = g
    if node > 0:
        g = centre - half * source
        rhs[rod, node - 1] = g
        for k in range(node - 1):
            j = node - 1 - k
            g -= h * (rate_of_change[rod, j] - slope[rod, j])
            rhs[rod, j - 1] = g
    rhs[rod, last] = real(0.0)
    if f.start_clamped == 1 and f.end_clamped == 1:
        set_end_constant(f, rate_of_change[rod, last] - slope[rod, last], rate[rod], rod, rhs)


@wp.func
def geodesic_increment(f: Filaments, turn: Scalars2D, rod: int, i: int):
    """δΩ at a node."""
    last = f.geodesic.shape[1] - 1
    h = f.spacing[rod]
    if i == 0:
        return real(2 * f.start_clamped) * turn[rod, 0] / h
    if i == last:
        return real(-2 * f.end_clamped) * turn[rod, last - 1] / h + turn[rod, last]
    return (turn[rod, i] - turn[rod, i - 1]) / h


@wp.func
def velocity_increment(turn: Scalars2D, weights: Quadruples2D, rod: int, i: int):
    """δu2 at a node."""
    last = turn.shape[1] - 1  # one more than the last half node
    w = weights[rod, i]
    total = real(0.0)
    for k in range(4):
        j = i - 2 + k
        if j >= 0 and j < last:
            total += w[k] * turn[rod, j]
    return total

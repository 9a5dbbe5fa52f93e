"""The two systems of a step of surface-bound filaments: tension, and the increment of Ω (model §3)."""

import warp as wp

from warp_rods.kernels.bound.membrane_motion import shortening
from warp_rods.kernels.bound.rod import coupling, end_tension, is_clamped, transverse_drag
from warp_rods.kernels.bound.state import Filaments, scalars
from warp_rods.kernels.clock import RATIO, STEP, per_clock
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.func
def inner_row(f: Filaments, rod: int, i: int) -> wp.vec4d:
    """(lower, diagonal, upper, right) of (u1(i+½) − u1(i−½))/Δs − Ω u2 = K11 V in λ; zero at the ends."""
    if i == 0 or i == f.geodesic.shape[1] - 1:
        return wp.vec4d()
    K = f.curvature[rod, i]
    turn = f.geodesic[rod, i]
    mobility = turn / transverse_drag(K, f.drag[rod])
    lean = real(0.5) * turn * coupling(K, f.drag[rod])
    ahead = real(1.0) / f.spacing[rod] + lean
    behind = real(1.0) / f.spacing[rod] - lean
    return wp.vec4d(
        -behind * f.to_left[rod, i - 1],
        ahead * f.to_left[rod, i] - behind * f.to_right[rod, i - 1] - mobility * turn,
        ahead * f.to_right[rod, i],
        mobility * f.transverse_force[rod, i]
        - ahead * f.remainder[rod, i]
        + behind * f.remainder[rod, i - 1]
        + shortening(f, rod, i),
    )


@wp.func
def start_row(f: Filaments, rod: int) -> wp.vec4d:
    """λ of a free first end (D.61), or u1 = 0 at the half node next to a clamped one."""
    if f.start_clamped == 0:
        return wp.vec4d(real(0.0), real(1.0), real(0.0), end_tension(f.curvature[rod, 0], f.moment[rod, 0]))
    return wp.vec4d(real(0.0), f.to_left[rod, 0], f.to_right[rod, 0], -f.remainder[rod, 0])


@wp.func
def end_row(f: Filaments, rod: int) -> wp.vec4d:
    """As ``start_row`` for the last end.

    The tension of a straight rod clamped at both ends is undetermined, and has no effect: a factor slightly above 1
    makes the system regular and picks the smallest.
    """
    last = f.geodesic.shape[1] - 1
    if f.end_clamped == 0:
        return wp.vec4d(real(0.0), real(1.0), real(0.0), end_tension(f.curvature[rod, last], f.moment[rod, last]))
    regular = real(1.0) + real(f.start_clamped) * real(1.0e-12)
    left = f.to_left[rod, last - 1]
    return wp.vec4d(-left, -regular * f.to_right[rod, last - 1], real(0.0), f.remainder[rod, last - 1])


@wp.func
def bending_mobility(f: Filaments, rod: int, i: int) -> real:
    """B3/(Z22 Δs⁴): what turns the second difference of Ω into u2/Δs²; none at a clamped end."""
    if is_clamped(f, i):
        return real(0.0)
    h2 = f.spacing[rod] * f.spacing[rod]
    return f.stiffness[rod][2] / (transverse_drag(f.curvature[rod, i], f.drag[rod]) * h2 * h2)


@wp.kernel
def tension_rows(f: Filaments, lower: scalars, diagonal: scalars, upper: scalars, right: scalars):
    """Rows of u1' − Ω u2 = K11 V in λ at inner nodes; at the ends λ given (D.61), or no u1 next to a clamp."""
    rod, i = wp.tid()
    row = inner_row(f, rod, i)
    if i == 0:
        row = start_row(f, rod)
    elif i == f.geodesic.shape[1] - 1:
        row = end_row(f, rod)
    lower[rod, i] = row[0]
    diagonal[rod, i] = row[1]
    upper[rod, i] = row[2]
    right[rod, i] = row[3]


@wp.kernel
def bending_rows(
    f: Filaments,
    clock: per_clock,
    lower2: scalars,
    lower: scalars,
    diagonal: scalars,
    upper: scalars,
    upper2: scalars,
):
    """Rows of c − Δt L, L = −∂²(B3/Z22)∂². The increment is zero at a free end and its slope is: beyond lies its
    mirror image. At a clamped end u2 is zero and mirrored."""
    rod, i = wp.tid()
    last = f.geodesic.shape[1] - 1
    dt = clock[STEP]
    ratio = clock[RATIO]
    before = real(0.0)
    here = real(0.0)
    after = real(0.0)
    if i > 0 and i < last:
        before = dt * bending_mobility(f, rod, i - 1)
        here = dt * bending_mobility(f, rod, i)
        after = dt * bending_mobility(f, rod, i + 1)
    elif i == 0:
        after = real(2 * f.start_clamped) * dt * bending_mobility(f, rod, 1)
    else:
        before = real(2 * f.end_clamped) * dt * bending_mobility(f, rod, last - 1)
    diagonal[rod, i] = (real(1.0) + real(2.0) * ratio) / (real(1.0) + ratio) + before + real(4.0) * here + after
    lower[rod, i] = real(-2.0) * (before + here)
    upper[rod, i] = real(-2.0) * (here + after)
    lower2[rod, i] = before
    upper2[rod, i] = after
    if i == 1:
        diagonal[rod, i] += before
    if i == last - 1:
        diagonal[rod, i] += after

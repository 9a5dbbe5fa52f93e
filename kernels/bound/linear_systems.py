"""The linear system for the tension λ of surface-bound filaments (docs/model.md §3.4)."""

import warp as wp

from warp_rods.kernels.bound.membrane_motion import shortening_rate
from warp_rods.kernels.bound.rod import free_end_tension, resistance_at
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.layout import Scalars2D, real

wp.set_module_options({"enable_backward": False})


@wp.func
def inner_row(f: Filaments, rod: int, i: int) -> wp.vec4d:
    """(lower, diagonal, upper, rhs) of (u1(i+½) − u1(i−½))/Δs − Ω u2 = K11 V in λ; zero at the ends."""
    if i == 0 or i == f.geodesic.shape[1] - 1:
        return wp.vec4d()
    Z = resistance_at(f, rod, i)
    geodesic = f.geodesic[rod, i]
    mobility = geodesic / Z[2]
    half_coupling = real(0.5) * geodesic * Z[1] / Z[2]
    after = real(1.0) / f.spacing[rod] + half_coupling
    before = real(1.0) / f.spacing[rod] - half_coupling
    return wp.vec4d(
        -before * f.u1_left[rod, i - 1],
        after * f.u1_left[rod, i] - before * f.u1_right[rod, i - 1] - mobility * geodesic,
        after * f.u1_right[rod, i],
        mobility * f.transverse_force[rod, i]
        - after * f.u1_constant[rod, i]
        + before * f.u1_constant[rod, i - 1]
        + shortening_rate(f, rod, i),
    )


@wp.func
def start_row(f: Filaments, rod: int) -> wp.vec4d:
    """λ of a free first end (D.61), or u1 = 0 at the half node next to a clamped one."""
    if f.start_clamped == 0:
        return wp.vec4d(real(0.0), real(1.0), real(0.0), free_end_tension(f.curvature[rod, 0], f.moment[rod, 0]))
    return wp.vec4d(real(0.0), f.u1_left[rod, 0], f.u1_right[rod, 0], -f.u1_constant[rod, 0])


@wp.func
def end_row(f: Filaments, rod: int) -> wp.vec4d:
    """The same for the last end.

    A constant tension of a straight rod clamped at both ends is undetermined and has no effect. A factor slightly
    above 1 makes the system regular and selects the smallest tension.
    """
    last = f.geodesic.shape[1] - 1
    if f.end_clamped == 0:
        return wp.vec4d(real(0.0), real(1.0), real(0.0), free_end_tension(f.curvature[rod, last], f.moment[rod, last]))
    regular = real(1.0) + real(f.start_clamped) * real(1.0e-12)
    left = f.u1_left[rod, last - 1]
    return wp.vec4d(-left, -regular * f.u1_right[rod, last - 1], real(0.0), f.u1_constant[rod, last - 1])


@wp.kernel
def set_tension_rows(f: Filaments, lower: Scalars2D, diagonal: Scalars2D, upper: Scalars2D, rhs: Scalars2D):
    """Rows for λ: u1' − Ω u2 = K11 V at inner nodes; at an end λ of (D.61), or u1 = 0 next to a clamped one."""
    rod, i = wp.tid()
    if f.active[rod] == 0:
        return
    row = inner_row(f, rod, i)
    if i == 0:
        row = start_row(f, rod)
    elif i == f.geodesic.shape[1] - 1:
        row = end_row(f, rod)
    lower[rod, i] = row[0]
    diagonal[rod, i] = row[1]
    upper[rod, i] = row[2]
    rhs[rod, i] = row[3]

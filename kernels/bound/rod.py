"""Filaments bound to a surface: velocities from shape (model §3; thesis 5.24-5.42, D.4).

Frame (q, n×q, n) of tangent q and outward normal n; strain (K12, −K11, Ω). The geodesic curvature Ω is the one
dynamic strain. λ, u2 and Ω live at nodes i, u1 at half nodes i + 1/2 (stored at i). With m = B(Ω − σ),

    Z11 u1 + Z12 u2 = λ' + Y1    (half nodes)       Y1 = Ω·m' + f1
    Z12 u1 + Z22 u2 = Ωλ + Y2    (nodes)            Y2 = F2 − Ωλ of (5.42)
    u1' = Ω u2                   (nodes)

u2 is eliminated from the first line at half nodes and from the last at nodes: one tridiagonal system in λ.

A membrane that moves along n with velocity V adds K11 V to the last line, and −ζr K12 V_1, −ζr K22 V_1 to Y1 and Y2
(``bound_motion``).
"""

import warp as wp

from warp_rods.kernels.bound.membrane_motion import (
    membrane_spin,
    membrane_turning,
    roll_drag_across,
    roll_drag_along,
    shortening,
)
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.layout import real
from warp_rods.kernels.stencils import (
    derivative,
    half_average,
    half_difference,
    second_derivative,
    second_derivative_at_end,
    second_derivative_at_start,
    second_difference,
)
from warp_rods.kernels.surface.geometry import gaussian

wp.set_module_options({"enable_backward": False})


@wp.func
def strain(K: wp.vec3d, geodesic: real) -> wp.vec3d:
    """(twist, normal bending, geodesic bending) = (K12, −K11, Ω) (5.17), (5.18)."""
    return wp.vec3d(K[1], -K[0], geodesic)


@wp.func
def end_slope(K: wp.vec3d, m: wp.vec3d) -> real:
    """m3' at a free end (D.60)."""
    return -(real(2.0) * K[1] * m[1] + (K[0] - K[2]) * m[0])


@wp.func
def end_tension(K: wp.vec3d, m: wp.vec3d) -> real:
    """λ at a free end (D.61)."""
    return K[0] * m[1] - K[1] * m[0]


@wp.func
def transverse_drag(K: wp.vec3d, drag: wp.vec3d) -> real:
    """Z22 = ζ⊥ + ζr K22²."""
    return drag[1] + drag[2] * K[2] * K[2]


@wp.func
def coupling(K: wp.vec3d, drag: wp.vec3d) -> real:
    """Z12/Z22: how much of the rotational drag of moving along resists moving across."""
    return drag[2] * K[1] * K[2] / transverse_drag(K, drag)


@wp.func
def is_clamped(f: Filaments, i: int) -> bool:
    """Whether node i is a clamped end."""
    last = f.geodesic.shape[1] - 1
    return (i == 0 and f.start_clamped == 1) or (i == last and f.end_clamped == 1)


@wp.func
def moment_curvature(f: Filaments, rod: int, i: int) -> wp.vec3d:
    """m'' with the free ends' slope of m3 (D.60); only its last component is used."""
    last = f.geodesic.shape[1] - 1
    h = f.spacing[rod]
    slope = wp.vec3d(real(0.0), real(0.0), end_slope(f.curvature[rod, i], f.moment[rod, i]))
    if i == 0 and f.start_clamped == 0:
        return second_derivative_at_start(f.moment, rod, slope, h)
    if i == last and f.end_clamped == 0:
        return second_derivative_at_end(f.moment, rod, slope, h)
    return second_derivative(f.moment, rod, i, h)


@wp.func
def transverse_force(f: Filaments, rod: int, i: int) -> real:
    """Y2 = F2 − Ωλ, F2 of (5.42)."""
    h = f.spacing[rod]
    K = f.curvature[rod, i]
    m = f.moment[rod, i]
    dm = derivative(f.moment, rod, i, h)
    ddm = moment_curvature(f, rod, i)
    f2 = wp.dot(wp.transpose(f.rotation[rod, i]) * f.force[rod, i], wp.vec3d(real(0.0), real(1.0), real(0.0)))
    turning = (K[1] * m[0] + K[2] * m[1]) * f.geodesic[rod, i] + gaussian(K) * m[2]
    push = f2 - roll_drag_across(f, rod, i)
    return -ddm[2] - turning - derivative(f.shear, rod, i, h) - K[1] * dm[1] + K[2] * dm[0] + push


@wp.func
def tangential_force(f: Filaments, rod: int, i: int) -> real:
    """Y1 = Ω·m' + f1 at i + 1/2 (5.41)."""
    h = f.spacing[rod]
    here = strain(f.curvature[rod, i], f.geodesic[rod, i])
    there = strain(f.curvature[rod, i + 1], f.geodesic[rod, i + 1])
    f1 = wp.dot(f.rotation[rod, i] * wp.vec3d(real(1.0), real(0.0), real(0.0)), f.force[rod, i])
    g1 = wp.dot(f.rotation[rod, i + 1] * wp.vec3d(real(1.0), real(0.0), real(0.0)), f.force[rod, i + 1])
    push = real(0.5) * (f1 + g1) - roll_drag_along(f, rod, i)
    return wp.dot(real(0.5) * (here + there), half_difference(f.moment, rod, i, h)) + push


@wp.func
def velocity_along(f: Filaments, rod: int, i: int) -> real:
    """u1 at node i: the mean of its half nodes; at an end carried over half a step by u1' = Ω u2 + K11 V."""
    last = f.geodesic.shape[1] - 1
    half = real(0.5) * f.spacing[rod]
    if i == 0:
        return f.along[rod, 0] - half * f.geodesic[rod, 0] * f.across[rod, 0] - half * shortening(f, rod, 0)
    if i == last:
        flow = f.along[rod, last - 1] + half * f.geodesic[rod, last] * f.across[rod, last]
        return flow + half * shortening(f, rod, last)
    return half_average(f.along, rod, i - 1)


@wp.func
def velocity_across(f: Filaments, rod: int, i: int) -> real:
    """u2 from Z12 u1 + Z22 u2 = Ωλ + Y2; at a free end together with u1' = Ω u2 + K11 V over the last half step."""
    last = f.geodesic.shape[1] - 1
    if is_clamped(f, i):
        return real(0.0)
    K = f.curvature[rod, i]
    pull = (f.geodesic[rod, i] * f.tension[rod, i] + f.transverse_force[rod, i]) / transverse_drag(K, f.drag[rod])
    ratio = coupling(K, f.drag[rod])
    half_turn = real(0.5) * f.spacing[rod] * f.geodesic[rod, i]
    half_squeeze = real(0.5) * f.spacing[rod] * shortening(f, rod, i)
    if i == 0:
        return (pull - ratio * (f.along[rod, 0] - half_squeeze)) / (real(1.0) - ratio * half_turn)
    if i == last:
        return (pull - ratio * (f.along[rod, last - 1] + half_squeeze)) / (real(1.0) + ratio * half_turn)
    return pull - ratio * half_average(f.along, rod, i - 1)


@wp.func
def geodesic_rate(f: Filaments, rod: int, i: int) -> real:
    """∂Ω/∂t = u2'' + (Ω² + 𝒦) u2 + Ω' (u1 + x dL/dt) (D.27), and ``membrane_turning``; a free end keeps Ω = σ3.

    Nodes stay at fixed shares x of a length L that may grow: they move along the material. A clamped end holds
    u2 = u2' = 0: the velocity beyond it is the mirror image.
    """
    last = f.geodesic.shape[1] - 1
    h = f.spacing[rod]
    if i == 0:
        return real(2 * f.start_clamped) * f.across[rod, 1] / (h * h)
    if i == last:
        return real(2 * f.end_clamped) * f.across[rod, last - 1] / (h * h)
    sweep = f.growth_rate[rod] * real(i - f.anchor) / real(last)
    turn = f.geodesic[rod, i]
    bend = second_difference(f.across, rod, i) / (h * h)
    return (
        bend
        + (turn * turn + gaussian(f.curvature[rod, i])) * f.across[rod, i]
        + derivative(f.geodesic, rod, i, h) * (velocity_along(f, rod, i) + sweep)
        + membrane_turning(f, rod, i)
    )


@wp.func
def spin(f: Filaments, rod: int, i: int) -> wp.vec3d:
    """Angular velocity ω in the frame (5.19), (5.20), (5.25), and ``membrane_spin``."""
    K = f.curvature[rod, i]
    u1 = velocity_along(f, rod, i)
    u2 = f.across[rod, i]
    turning = derivative(f.across, rod, i, f.spacing[rod]) + f.geodesic[rod, i] * u1
    return wp.vec3d(K[1] * u1 + K[2] * u2, -K[0] * u1 - K[1] * u2, turning) + membrane_spin(f, rod, i)


@wp.func
def node_velocity(f: Filaments, rod: int, i: int) -> wp.vec3d:
    """u of a node in its frame: (u1, u2, V)."""
    return wp.vec3d(velocity_along(f, rod, i), f.across[rod, i], f.normal_velocity[rod, i])


@wp.kernel
def moments(f: Filaments):
    """m and K11 m1 + K12 m2 at nodes."""
    rod, i = wp.tid()
    K = f.curvature[rod, i]
    m = wp.cw_mul(f.stiffness[rod], strain(K, f.geodesic[rod, i]) - f.intrinsic[rod])
    f.moment[rod, i] = m
    f.shear[rod, i] = K[0] * m[0] + K[1] * m[1]


@wp.kernel
def transverse_forces(f: Filaments):
    """Y2 at nodes."""
    rod, i = wp.tid()
    f.transverse_force[rod, i] = transverse_force(f, rod, i)


@wp.kernel
def tangential_rows(f: Filaments):
    """u1 at half nodes as an affine function of λ at its two nodes: u2 eliminated, M11 and M12 of (5.43)."""
    rod, i = wp.tid()
    if i == f.geodesic.shape[1] - 1:
        return
    K = half_average(f.curvature, rod, i)
    drag = f.drag[rod]
    ratio = coupling(K, drag)
    M11 = real(1.0) / (drag[0] + drag[2] * K[1] * K[1] - ratio * drag[2] * K[1] * K[2])
    h = f.spacing[rod]
    lean = real(-0.5) * ratio
    f.to_left[rod, i] = M11 * (lean * f.geodesic[rod, i] - real(1.0) / h)
    f.to_right[rod, i] = M11 * (lean * f.geodesic[rod, i + 1] + real(1.0) / h)
    f.remainder[rod, i] = M11 * (tangential_force(f, rod, i) - ratio * half_average(f.transverse_force, rod, i))


@wp.kernel
def velocities_along(f: Filaments):
    """u1 at half nodes."""
    rod, i = wp.tid()
    if i < f.geodesic.shape[1] - 1:
        f.along[rod, i] = (
            f.to_left[rod, i] * f.tension[rod, i] + f.to_right[rod, i] * f.tension[rod, i + 1] + f.remainder[rod, i]
        )


@wp.kernel
def velocities_across(f: Filaments):
    """u2 at nodes."""
    rod, i = wp.tid()
    f.across[rod, i] = velocity_across(f, rod, i)


@wp.kernel
def rates(f: Filaments):
    """∂Ω/∂t at nodes."""
    rod, i = wp.tid()
    f.rate[rod, i] = geodesic_rate(f, rod, i)

"""Filaments bound to a surface: forces, velocities and rates of a shape (docs/model.md §3.1 to §3.4; (5.24) to (5.42)).

Frame (q, n×q, n) with tangent q and outward normal n; strain (K12, −K11, Ω). The geodesic curvature Ω is the only
dynamic strain. λ, u2 and Ω live at nodes i; u1 lives at half nodes i + ½ and is stored at i. With m = B(strain − σ),

    Z11 u1 + Z12 u2 = λ' + Y1    (half nodes)       Y1 = strain·m' + f1
    Z12 u1 + Z22 u2 = Ωλ + Y2    (nodes)            Y2 = F2 − Ωλ with F2 of (5.42)
    u1' = Ω u2                   (nodes)

u2 is eliminated from the first line at half nodes, and from the last line at nodes. The result is a tridiagonal system
in λ (``linear_systems.py``). A membrane that moves along n with velocity V adds K11 V to the last line, −ζr K12 V_1 to
Y1, and −ζr K22 V_1 to Y2 (``membrane_motion.py``).
"""

import warp as wp

from warp_rods.kernels.bound.membrane_motion import (
    membrane_angular_velocity,
    membrane_geodesic_rate,
    rotational_drag_across,
    rotational_drag_along,
    shortening_rate,
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
def strain_of(K: wp.vec3d, geodesic: real) -> wp.vec3d:
    """(twist, normal bending, geodesic bending) = (K12, −K11, Ω) (5.17), (5.18)."""
    return wp.vec3d(K[1], -K[0], geodesic)


@wp.func
def free_end_moment_slope(K: wp.vec3d, m: wp.vec3d) -> real:
    """m3' at a free end (D.60)."""
    return -(real(2.0) * K[1] * m[1] + (K[0] - K[2]) * m[0])


@wp.func
def free_end_tension(K: wp.vec3d, m: wp.vec3d) -> real:
    """λ at a free end (D.61)."""
    return K[0] * m[1] - K[1] * m[0]


@wp.func
def resistance(K: wp.vec3d, drag: wp.vec3d, contact: wp.vec3d) -> wp.vec3d:
    """(Z11, Z12, Z22) = (ζ∥ + ζr K12², ζr K12 K22, ζ⊥ + ζr K22²) + C."""
    Z = wp.vec3d(drag[0] + drag[2] * K[1] * K[1], drag[2] * K[1] * K[2], drag[1] + drag[2] * K[2] * K[2])
    return Z + contact


@wp.func
def resistance_at(f: Filaments, rod: int, i: int) -> wp.vec3d:
    """(Z11, Z12, Z22) at node i."""
    return resistance(f.curvature[rod, i], f.drag[rod], f.contact_drag[rod, i])


@wp.func
def half_resistance(f: Filaments, rod: int, i: int) -> wp.vec3d:
    """(Z11, Z12, Z22) at i + ½."""
    return resistance(half_average(f.curvature, rod, i), f.drag[rod], half_average(f.contact_drag, rod, i))


@wp.func
def is_clamped(f: Filaments, i: int) -> bool:
    """Whether node i is a clamped end."""
    last = f.geodesic.shape[1] - 1
    return (i == 0 and f.start_clamped == 1) or (i == last and f.end_clamped == 1)


@wp.func
def moment_second_derivative(f: Filaments, rod: int, i: int) -> wp.vec3d:
    """m'', at free ends with the slope of m3 from (D.60); only the last component is used."""
    last = f.geodesic.shape[1] - 1
    h = f.spacing[rod]
    slope = wp.vec3d(real(0.0), real(0.0), free_end_moment_slope(f.curvature[rod, i], f.moment[rod, i]))
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
    ddm = moment_second_derivative(f, rod, i)
    f2 = wp.dot(wp.transpose(f.rotation[rod, i]) * f.force[rod, i], wp.vec3d(real(0.0), real(1.0), real(0.0)))
    bending = (K[1] * m[0] + K[2] * m[1]) * f.geodesic[rod, i] + gaussian(K) * m[2]
    external = f2 - rotational_drag_across(f, rod, i)
    return -ddm[2] - bending - derivative(f.shear_term, rod, i, h) - K[1] * dm[1] + K[2] * dm[0] + external


@wp.func
def tangential_force(f: Filaments, rod: int, i: int) -> real:
    """Y1 = strain·m' + f1 at i + ½ (5.41)."""
    h = f.spacing[rod]
    here = strain_of(f.curvature[rod, i], f.geodesic[rod, i])
    next_one = strain_of(f.curvature[rod, i + 1], f.geodesic[rod, i + 1])
    f1 = wp.dot(f.rotation[rod, i] * wp.vec3d(real(1.0), real(0.0), real(0.0)), f.force[rod, i])
    f1_next = wp.dot(f.rotation[rod, i + 1] * wp.vec3d(real(1.0), real(0.0), real(0.0)), f.force[rod, i + 1])
    external = real(0.5) * (f1 + f1_next) - rotational_drag_along(f, rod, i)
    return wp.dot(real(0.5) * (here + next_one), half_difference(f.moment, rod, i, h)) + external


@wp.func
def velocity_along_at(f: Filaments, rod: int, i: int) -> real:
    """u1 at node i: the mean of both half nodes; at an end extrapolated over Δs/2 by u1' = Ω u2 + K11 V."""
    last = f.geodesic.shape[1] - 1
    half = real(0.5) * f.spacing[rod]
    if i == 0:
        u1 = f.velocity_along[rod, 0] - half * f.geodesic[rod, 0] * f.velocity_across[rod, 0]
        return u1 - half * shortening_rate(f, rod, 0)
    if i == last:
        u1 = f.velocity_along[rod, last - 1] + half * f.geodesic[rod, last] * f.velocity_across[rod, last]
        return u1 + half * shortening_rate(f, rod, last)
    return half_average(f.velocity_along, rod, i - 1)


@wp.func
def velocity_across_at(f: Filaments, rod: int, i: int) -> real:
    """u2 from Z12 u1 + Z22 u2 = Ωλ + Y2; at a free end together with u1' = Ω u2 + K11 V over the last Δs/2."""
    last = f.geodesic.shape[1] - 1
    if is_clamped(f, i):
        return real(0.0)
    Z = resistance_at(f, rod, i)
    force = f.geodesic[rod, i] * f.tension[rod, i] + f.transverse_force[rod, i]
    u2 = force / Z[2]
    z = Z[1] / Z[2]
    half_angle = real(0.5) * f.spacing[rod] * f.geodesic[rod, i]
    half_shortening = real(0.5) * f.spacing[rod] * shortening_rate(f, rod, i)
    if i == 0:
        return (u2 - z * (f.velocity_along[rod, 0] - half_shortening)) / (real(1.0) - z * half_angle)
    if i == last:
        return (u2 - z * (f.velocity_along[rod, last - 1] + half_shortening)) / (real(1.0) + z * half_angle)
    return u2 - z * half_average(f.velocity_along, rod, i - 1)


@wp.func
def geodesic_rate_at(f: Filaments, rod: int, i: int) -> real:
    """∂Ω/∂t = u2'' + (Ω² + 𝒦) u2 + Ω' (u1 + x dL/dt) (D.27), and ``membrane_geodesic_rate``.

    Nodes have constant fractions x of the length L, so growth moves them along the material. A free end keeps Ω = σ3.
    A clamped end has u2 = u2' = 0: u2 is even beyond it.
    """
    last = f.geodesic.shape[1] - 1
    h = f.spacing[rod]
    if i == 0:
        return real(2 * f.start_clamped) * f.velocity_across[rod, 1] / (h * h)
    if i == last:
        return real(2 * f.end_clamped) * f.velocity_across[rod, last - 1] / (h * h)
    growth = f.growth_rate[rod] * real(i - f.tracked) / real(last)
    geodesic = f.geodesic[rod, i]
    return (
        second_difference(f.velocity_across, rod, i) / (h * h)
        + (geodesic * geodesic + gaussian(f.curvature[rod, i])) * f.velocity_across[rod, i]
        + derivative(f.geodesic, rod, i, h) * (velocity_along_at(f, rod, i) + growth)
        + membrane_geodesic_rate(f, rod, i)
    )


@wp.func
def angular_velocity(f: Filaments, rod: int, i: int) -> wp.vec3d:
    """ω in the frame (5.19), (5.20), (5.25), and ``membrane_angular_velocity``."""
    K = f.curvature[rod, i]
    u1 = velocity_along_at(f, rod, i)
    u2 = f.velocity_across[rod, i]
    omega2 = derivative(f.velocity_across, rod, i, f.spacing[rod]) + f.geodesic[rod, i] * u1
    in_surface = wp.vec3d(K[1] * u1 + K[2] * u2, -K[0] * u1 - K[1] * u2, omega2)
    return in_surface + membrane_angular_velocity(f, rod, i)


@wp.func
def node_velocity(f: Filaments, rod: int, i: int) -> wp.vec3d:
    """u = (u1, u2, V) of a node in its frame."""
    return wp.vec3d(velocity_along_at(f, rod, i), f.velocity_across[rod, i], f.normal_velocity[rod, i])


@wp.kernel
def find_moments(f: Filaments):
    """m and K11 m1 + K12 m2 at nodes."""
    rod, i = wp.tid()
    if f.active[rod] == 0:
        return
    K = f.curvature[rod, i]
    m = wp.cw_mul(f.stiffness[rod], strain_of(K, f.geodesic[rod, i]) - f.intrinsic[rod])
    f.moment[rod, i] = m
    f.shear_term[rod, i] = K[0] * m[0] + K[1] * m[1]


@wp.kernel
def find_transverse_forces(f: Filaments):
    """Y2 at nodes."""
    rod, i = wp.tid()
    if f.active[rod] == 0:
        return
    f.transverse_force[rod, i] = transverse_force(f, rod, i)


@wp.kernel
def find_velocity_coefficients(f: Filaments):
    """Coefficients of u1 at half nodes, which is linear in λ at the two nodes beside it; M11 and M12 of (5.43)."""
    rod, i = wp.tid()
    if f.active[rod] == 0:
        return
    if i == f.geodesic.shape[1] - 1:
        return
    Z = half_resistance(f, rod, i)
    z = Z[1] / Z[2]
    M11 = real(1.0) / (Z[0] - z * Z[1])
    h = f.spacing[rod]
    minus_half_z = real(-0.5) * z
    f.u1_left[rod, i] = M11 * (minus_half_z * f.geodesic[rod, i] - real(1.0) / h)
    f.u1_right[rod, i] = M11 * (minus_half_z * f.geodesic[rod, i + 1] + real(1.0) / h)
    f.u1_constant[rod, i] = M11 * (tangential_force(f, rod, i) - z * half_average(f.transverse_force, rod, i))


@wp.kernel
def find_velocities_along(f: Filaments):
    """u1 at half nodes."""
    rod, i = wp.tid()
    if f.active[rod] == 0:
        return
    if i < f.geodesic.shape[1] - 1:
        f.velocity_along[rod, i] = (
            f.u1_left[rod, i] * f.tension[rod, i] + f.u1_right[rod, i] * f.tension[rod, i + 1] + f.u1_constant[rod, i]
        )


@wp.kernel
def find_velocities_across(f: Filaments):
    """u2 at nodes."""
    rod, i = wp.tid()
    if f.active[rod] == 0:
        return
    f.velocity_across[rod, i] = velocity_across_at(f, rod, i)


@wp.kernel
def find_geodesic_rates(f: Filaments):
    """∂Ω/∂t at nodes."""
    rod, i = wp.tid()
    if f.active[rod] == 0:
        return
    f.geodesic_rate[rod, i] = geodesic_rate_at(f, rod, i)

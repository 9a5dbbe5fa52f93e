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
    turning_rate,
)
from warp_rods.kernels.bound.outside import add_outside, couple_across, couple_along, couple_at
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Lanes,
    Vector,
    add,
    by_component,
    div,
    dot,
    load,
    mul,
    sub,
    vector,
)
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
def strain_of(K: Vector, geodesic: Lanes) -> Vector:
    """(twist, normal bending, geodesic bending) = (K12, −K11, Ω) (5.17), (5.18)."""
    return vector(K[1], -K[0], geodesic)


@wp.func
def free_end_moment_slope(K: Vector, m: Vector) -> Lanes:
    """m3' at a free end (D.60)."""
    return -(real(2.0) * K[1] * m[1] + (K[0] - K[2]) * m[0])


@wp.func
def free_end_tension(K: Vector, m: Vector) -> Lanes:
    """λ at a free end (D.61)."""
    return K[0] * m[1] - K[1] * m[0]


@wp.func
def resistance(K: Vector, drag: Vector, contact: Vector) -> Vector:
    """(Z11, Z12, Z22) = (ζ∥ + ζr K12², ζr K12 K22, ζ⊥ + ζr K22²) + C."""
    Z = vector(drag[0] + drag[2] * K[1] * K[1], drag[2] * K[1] * K[2], drag[1] + drag[2] * K[2] * K[2])
    return Z + contact


@wp.func
def resistance_at(f: Filaments, tile: int, i: int) -> Vector:
    """(Z11, Z12, Z22) at node i."""
    return resistance(f.curvature[tile, i], f.drag[tile, i], f.contact_drag[tile, i])


@wp.func
def half_resistance(f: Filaments, tile: int, i: int) -> Vector:
    """(Z11, Z12, Z22) at i + ½."""
    K, drag = half_average(f.curvature, tile, i), half_average(f.drag, tile, i)
    return resistance(K, drag, half_average(f.contact_drag, tile, i))


@wp.func
def is_clamped(f: Filaments, i: int) -> bool:
    """Whether node i is a clamped end."""
    last = f.geodesic.shape[1] - 1
    return (i == 0 and f.start_clamped == 1) or (i == last and f.end_clamped == 1)


@wp.func
def free_end_slope_at(f: Filaments, tile: int, i: int) -> Lanes:
    """m3' at a free end, an external couple included."""
    return free_end_moment_slope(f.curvature[tile, i], f.moment[tile, i]) - couple_at(f, tile, i)[2]


@wp.func
def moment_second_derivative(f: Filaments, tile: int, i: int) -> Vector:
    """m'', at free ends with the slope of m3 from (D.60); only the last component is used."""
    last = f.geodesic.shape[1] - 1
    h = f.spacing[tile]
    slope = vector(Lanes(), Lanes(), free_end_slope_at(f, tile, i))
    if i == 0 and f.start_clamped == 0:
        return second_derivative_at_start(f.moment, tile, slope, h)
    if i == last and f.end_clamped == 0:
        return second_derivative_at_end(f.moment, tile, slope, h)
    return second_derivative(f.moment, tile, i, h)


@wp.func
def transverse_force(f: Filaments, tile: int, i: int) -> Lanes:
    """Y2 = F2 − Ωλ, F2 of (5.42)."""
    h = f.spacing[tile]
    K = f.curvature[tile, i]
    m = f.moment[tile, i]
    dm = derivative(f.moment, tile, i, h)
    ddm = moment_second_derivative(f, tile, i)
    f2 = f.load[tile, i][1]
    bending = (K[1] * m[0] + K[2] * m[1]) * f.geodesic[tile, i] + gaussian(K) * m[2]
    external = f2 - rotational_drag_across(f, tile, i) + couple_across(f, tile, i)
    return -ddm[2] - bending - derivative(f.shear_term, tile, i, h) - K[1] * dm[1] + K[2] * dm[0] + external


@wp.func
def tangential_force(f: Filaments, tile: int, i: int) -> Lanes:
    """Y1 = strain·m' + f1 at i + ½ (5.41)."""
    h = f.spacing[tile]
    here = strain_of(f.curvature[tile, i], f.geodesic[tile, i])
    next_one = strain_of(f.curvature[tile, i + 1], f.geodesic[tile, i + 1])
    external = half_average(f.load, tile, i)[0] - rotational_drag_along(f, tile, i) + couple_along(f, tile, i)
    return dot(real(0.5) * (here + next_one), half_difference(f.moment, tile, i, h)) + external


@wp.func
def velocity_along_at(f: Filaments, tile: int, i: int) -> Lanes:
    """u1 at node i: the mean of both half nodes; at an end extrapolated over Δs/2 by u1' = Ω u2 + K11 V."""
    last = f.geodesic.shape[1] - 1
    half = real(0.5) * f.spacing[tile]
    if i == 0:
        u1 = f.velocity_along[tile, 0] - half * f.geodesic[tile, 0] * f.velocity_across[tile, 0]
        return u1 - half * shortening_rate(f, tile, 0)
    if i == last:
        u1 = f.velocity_along[tile, last - 1] + half * f.geodesic[tile, last] * f.velocity_across[tile, last]
        return u1 + half * shortening_rate(f, tile, last)
    return half_average(f.velocity_along, tile, i - 1)


@wp.func
def velocity_across_at(f: Filaments, tile: int, i: int) -> Lanes:
    """u2 from Z12 u1 + Z22 u2 = Ωλ + Y2; at a free end together with u1' = Ω u2 + K11 V over the last Δs/2."""
    last = f.geodesic.shape[1] - 1
    if is_clamped(f, i):
        return Lanes()
    Z = resistance_at(f, tile, i)
    force = f.geodesic[tile, i] * f.tension[tile, i] + f.transverse_force[tile, i]
    mobility = real(1.0) / Z[2]
    u2 = force * mobility
    z = Z[1] * mobility
    half_angle = real(0.5) * f.spacing[tile] * f.geodesic[tile, i]
    half_shortening = real(0.5) * f.spacing[tile] * shortening_rate(f, tile, i)
    if i == 0:
        return (u2 - z * (f.velocity_along[tile, 0] - half_shortening)) / (real(1.0) - z * half_angle)
    if i == last:
        return (u2 - z * (f.velocity_along[tile, last - 1] + half_shortening)) / (real(1.0) + z * half_angle)
    return u2 - z * half_average(f.velocity_along, tile, i - 1)


@wp.func
def clamped_geodesic_rate(f: Filaments, tile: int, i: int) -> Lanes:
    """∂Ω/∂t at a clamped end, where u1 = u2 = 0 and u2' = K12 V, by a mirror node beyond it; 0 at a free end."""
    if not is_clamped(f, i):
        return Lanes()
    h = f.spacing[tile]
    inwards = wp.where(i == 0, 1, -1)
    away = f.velocity_across[tile, i + inwards] - real(inwards) * h * turning_rate(f, tile, i)
    return real(2.0) * away / (h * h) + membrane_geodesic_rate(f, tile, i)


@wp.func
def geodesic_rate_at(f: Filaments, tile: int, i: int) -> Lanes:
    """∂Ω/∂t = u2'' + (Ω² + 𝒦) u2 + Ω' (u1 + x dL/dt) (D.27), and ``membrane_geodesic_rate``.

    Nodes have constant fractions x of the length L, so growth moves them along the material. A free end has Ω = σ3.
    """
    last = f.geodesic.shape[1] - 1
    h = f.spacing[tile]
    if i == 0 or i == last:
        return clamped_geodesic_rate(f, tile, i)
    growth = f.growth_rate[tile] * real(i - f.tracked) / real(last)
    geodesic = f.geodesic[tile, i]
    return (
        second_difference(f.velocity_across, tile, i) / (h * h)
        + (geodesic * geodesic + gaussian(f.curvature[tile, i])) * f.velocity_across[tile, i]
        + derivative(f.geodesic, tile, i, h) * (velocity_along_at(f, tile, i) + growth)
        + membrane_geodesic_rate(f, tile, i)
    )


@wp.func
def angular_velocity(f: Filaments, tile: int, i: int) -> Vector:
    """ω in the frame (5.19), (5.20), (5.25), and ``membrane_angular_velocity``."""
    K = f.curvature[tile, i]
    u1 = velocity_along_at(f, tile, i)
    u2 = f.velocity_across[tile, i]
    omega2 = derivative(f.velocity_across, tile, i, f.spacing[tile]) + f.geodesic[tile, i] * u1
    in_surface = vector(K[1] * u1 + K[2] * u2, -K[0] * u1 - K[1] * u2, omega2)
    return in_surface + membrane_angular_velocity(f, tile, i)


@wp.func
def node_velocity(f: Filaments, tile: int, i: int) -> Vector:
    """u = (u1, u2, V) of a node in its frame."""
    return vector(velocity_along_at(f, tile, i), f.velocity_across[tile, i], f.normal_velocity[tile, i])


@wp.func
def in_space(f: Filaments, tile: int, i: int, v: Vector) -> Vector:
    """A vector of the frame of node i in space."""
    return v[0] * f.tangent[tile, i] + v[1] * f.across[tile, i] + v[2] * f.normal[tile, i]


@wp.func
def find_loads(f: Filaments, tile: int):
    """The external force in the frames of the nodes."""
    for i in range(f.geodesic.shape[1]):
        force = load(f.force, tile, i)
        along, across = dot(f.tangent[tile, i], force), dot(f.across[tile, i], force)
        f.load[tile, i] = vector(along, across, dot(f.normal[tile, i], force))
    if f.exposed == 1:
        add_outside(f, tile)


@wp.func
def find_moments(f: Filaments, tile: int):
    """m and K11 m1 + K12 m2 at nodes."""
    for i in range(f.geodesic.shape[1]):
        K = f.curvature[tile, i]
        m = by_component(f.stiffness[tile, i], strain_of(K, f.geodesic[tile, i]) - f.intrinsic[tile, i])
        f.moment[tile, i] = m
        f.shear_term[tile, i] = K[0] * m[0] + K[1] * m[1]
        if f.exposed == 1:
            f.shear_term[tile, i] = f.shear_term[tile, i] + f.couple[tile, i][2]


@wp.func
def find_transverse_forces(f: Filaments, tile: int):
    """Y2 at nodes."""
    for i in range(f.geodesic.shape[1]):
        f.transverse_force[tile, i] = transverse_force(f, tile, i)


@wp.func
def find_velocity_coefficients(f: Filaments, tile: int):
    """Coefficients of u1 at half nodes, which is linear in λ at the two nodes beside it; M11 and M12 of (5.43)."""
    per_length = real(1.0) / f.spacing[tile]
    for i in range(f.geodesic.shape[1] - 1):
        Z = half_resistance(f, tile, i)
        z = Z[1] / Z[2]
        M11 = real(1.0) / (Z[0] - z * Z[1])
        minus_half_z = real(-0.5) * z
        f.u1_left[tile, i] = M11 * (minus_half_z * f.geodesic[tile, i] - per_length)
        f.u1_right[tile, i] = M11 * (minus_half_z * f.geodesic[tile, i + 1] + per_length)
        f.u1_constant[tile, i] = M11 * (tangential_force(f, tile, i) - z * half_average(f.transverse_force, tile, i))


@wp.func
def find_velocities(f: Filaments, tile: int):
    """u1 at half nodes, then u2 at nodes."""
    nodes = f.geodesic.shape[1]
    for i in range(nodes - 1):
        u1 = f.u1_left[tile, i] * f.tension[tile, i] + f.u1_right[tile, i] * f.tension[tile, i + 1]
        f.velocity_along[tile, i] = u1 + f.u1_constant[tile, i]
    for i in range(nodes):
        f.velocity_across[tile, i] = velocity_across_at(f, tile, i)


@wp.func
def find_geodesic_rates(f: Filaments, tile: int):
    """∂Ω/∂t at nodes."""
    for i in range(f.geodesic.shape[1]):
        f.geodesic_rate[tile, i] = geodesic_rate_at(f, tile, i)

"""The load of filaments on their membrane, from the Lagrange multipliers (5.31), (5.32), (D.28) to (D.35)."""

import warp as wp

from warp_rods.kernels.bound.membrane_motion import membrane_angular_velocity
from warp_rods.kernels.bound.outside import couple_at
from warp_rods.kernels.bound.rod import (
    angular_velocity,
    free_end_slope_at,
    free_end_tension,
    in_space,
    is_clamped,
)
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Lanes,
    Lanes2D,
    Vector,
    Vectors,
    add,
    mul,
    store_where,
    sub,
    vector,
)
from warp_rods.kernels.layout import Scalars1D, Vectors2D, real
from warp_rods.kernels.stencils import derivative, trapezoid_weight

wp.set_module_options({"enable_backward": False})


@wp.func
def normal_shear_at(f: Filaments, tile: int, i: int) -> Lanes:
    """λ3 = m2' + Ω m1 − K12 m3 + c1 (D.32), the internal force along n."""
    m = f.moment[tile, i]
    dm = derivative(f.moment, tile, i, f.spacing[tile])
    shear = dm[1] + f.geodesic[tile, i] * m[0] - f.curvature[tile, i][1] * m[2]
    return shear + couple_at(f, tile, i)[1]


@wp.func
def load_moment_at(f: Filaments, tile: int, i: int) -> Lanes:
    """χ = e0·(m' + strain×m) − ζr ω0 + c0 (D.33)."""
    m = f.moment[tile, i]
    dm = derivative(f.moment, tile, i, f.spacing[tile])
    K = f.curvature[tile, i]
    chi = dm[0] - K[0] * m[2] - f.geodesic[tile, i] * m[1] - f.drag[tile, i][2] * angular_velocity(f, tile, i)[0]
    return chi + couple_at(f, tile, i)[0]


@wp.func
def load_at(f: Filaments, normal_shear: Lanes2D, tile: int, i: int) -> Vector:
    """Force per length on the membrane in the frame (q, n×q, n): minus the constraint force on the filament.

    The normal component is p = (∂sλ + strain×λ)·n + f·n − ζ⊥ V; in the surface the load is −χ(K12, K22) (D.35).
    """
    K = f.curvature[tile, i]
    h = f.spacing[tile]
    chi = load_moment_at(f, tile, i)
    shear2 = -derivative(f.moment, tile, i, h)[2] - f.shear_term[tile, i]
    p = derivative(normal_shear, tile, i, h) + K[1] * shear2 + K[0] * f.tension[tile, i] + f.load[tile, i][2]
    p -= f.drag[tile, i][1] * f.normal_velocity[tile, i]
    return vector(-chi * K[1], -chi * K[2], p)


@wp.func
def end_moment_slope(f: Filaments, tile: int, i: int) -> Lanes:
    """m3' at an end: (D.60) at a free one, three points at a clamped one."""
    if is_clamped(f, i):
        return derivative(f.moment, tile, i, f.spacing[tile])[2]
    return free_end_slope_at(f, tile, i)


@wp.func
def end_force_at(f: Filaments, normal_shear: Lanes2D, tile: int, i: int) -> Vector:
    """Internal force (λ, λ2, λ3) of the end section at node i (D.30), (D.32), in the frame."""
    shear2 = -end_moment_slope(f, tile, i) - f.shear_term[tile, i]
    return vector(f.tension[tile, i], shear2, normal_shear[tile, i])


@wp.func
def end_power(f: Filaments, normal_shear: Lanes2D, tile: int, i: int) -> Lanes:
    """m1 V_1 − m2 V' + λ3 V: power of a moving membrane on the end section at node i."""
    m = f.moment[tile, i]
    omega = membrane_angular_velocity(f, tile, i)
    return m[0] * omega[0] + m[1] * omega[1] + normal_shear[tile, i] * f.normal_velocity[tile, i]


@wp.func
def find_normal_shear(f: Filaments, tile: int, normal_shear: Lanes2D):
    """λ3 at nodes."""
    for i in range(f.geodesic.shape[1]):
        normal_shear[tile, i] = normal_shear_at(f, tile, i)


@wp.func
def find_load(f: Filaments, tile: int, normal_shear: Lanes2D, load: Vectors, load_moment: Lanes2D):
    """Force per length on the membrane in space, and moment per length about the tangent, at nodes."""
    for i in range(f.geodesic.shape[1]):
        load_moment[tile, i] = load_moment_at(f, tile, i)
        load[tile, i] = in_space(f, tile, i, load_at(f, normal_shear, tile, i))


@wp.func
def find_end_loads(f: Filaments, tile: int, normal_shear: Lanes2D, end_load: Vectors2D, end_moment: Vectors2D):
    """Force and moment of both end sections on the membrane, in space [rod, end]: (Λ, m) at the first, minus it at
    the last."""
    one = Lanes(real(1.0))
    for end in range(2):
        i = end * (f.geodesic.shape[1] - 1)
        sign = real(1 - 2 * end)
        store_where(end_load, tile, end, one, sign * in_space(f, tile, i, end_force_at(f, normal_shear, tile, i)))
        store_where(end_moment, tile, end, one, sign * in_space(f, tile, i, f.moment[tile, i]))


@wp.func
def find_stretch_force(f: Filaments, tile: int, stretch_force: Lanes2D):
    """λ + K12 m1 − K11 m2 at nodes, the force that does work where a section slides along the membrane."""
    for i in range(f.geodesic.shape[1]):
        stretch_force[tile, i] = f.tension[tile, i] - free_end_tension(f.curvature[tile, i], f.moment[tile, i])


@wp.func
def find_membrane_power(f: Filaments, tile: int, normal_shear: Lanes2D, power: Scalars1D):
    """Power of a moving membrane on each rod: −∫ (p V + χ V_1) ds and the power on the end sections."""
    nodes = f.geodesic.shape[1]
    total = end_power(f, normal_shear, tile, nodes - 1) - end_power(f, normal_shear, tile, 0)
    for i in range(nodes):
        p = load_at(f, normal_shear, tile, i)[2]
        density = p * f.normal_velocity[tile, i] + load_moment_at(f, tile, i) * f.normal_velocity_slope[tile, i]
        total -= trapezoid_weight(i, nodes, f.spacing[tile]) * density
    store_where(power, tile, Lanes(real(1.0)), total)

"""The load of filaments on their membrane, from the Lagrange multipliers (5.31), (5.32), (D.28) to (D.35)."""

import warp as wp

from warp_rods.kernels.bound.membrane_motion import membrane_angular_velocity
from warp_rods.kernels.bound.rod import (
    angular_velocity,
    free_end_moment_slope,
    free_end_tension,
    is_clamped,
)
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.layout import Scalars1D, Scalars2D, Vectors2D, real
from warp_rods.kernels.stencils import derivative, trapezoid_weight
from warp_rods.kernels.surface.geometry import gaussian

wp.set_module_options({"enable_backward": False})


@wp.func
def normal_shear_at(f: Filaments, rod: int, i: int) -> real:
    """λ3 = m2' + Ω m1 − K12 m3 (D.32), the internal force along n."""
    m = f.moment[rod, i]
    dm = derivative(f.moment, rod, i, f.spacing[rod])
    return dm[1] + f.geodesic[rod, i] * m[0] - f.curvature[rod, i][1] * m[2]


@wp.func
def load_moment_at(f: Filaments, rod: int, i: int) -> real:
    """χ = e0·(m' + strain×m) − ζr ω0 (D.33)."""
    m = f.moment[rod, i]
    dm = derivative(f.moment, rod, i, f.spacing[rod])
    K = f.curvature[rod, i]
    return dm[0] - K[0] * m[2] - f.geodesic[rod, i] * m[1] - f.drag[rod][2] * angular_velocity(f, rod, i)[0]


@wp.func
def load_at(f: Filaments, normal_shear: Scalars2D, rod: int, i: int) -> wp.vec3d:
    """Force per length on the membrane in the frame (q, n×q, n): minus the constraint force on the filament.

    The normal component is p = (∂sλ + strain×λ)·n + f·n − ζ⊥ V; in the surface the load is −χ(K12, K22) (D.35).
    """
    K = f.curvature[rod, i]
    h = f.spacing[rod]
    chi = load_moment_at(f, rod, i)
    shear2 = -derivative(f.moment, rod, i, h)[2] - f.shear_term[rod, i]
    f3 = wp.dot(f.rotation[rod, i] * wp.vec3d(real(0.0), real(0.0), real(1.0)), f.force[rod, i])
    p = derivative(normal_shear, rod, i, h) + K[1] * shear2 + K[0] * f.tension[rod, i] + f3
    p -= f.drag[rod][1] * f.normal_velocity[rod, i]
    return wp.vec3d(-chi * K[1], -chi * K[2], p)


@wp.func
def end_moment_slope(f: Filaments, rod: int, i: int) -> real:
    """m3' at an end: (D.60) at a free one, three points at a clamped one."""
    if is_clamped(f, i):
        return derivative(f.moment, rod, i, f.spacing[rod])[2]
    return free_end_moment_slope(f.curvature[rod, i], f.moment[rod, i])


@wp.func
def end_force_at(f: Filaments, normal_shear: Scalars2D, rod: int, i: int) -> wp.vec3d:
    """Internal force (λ, λ2, λ3) of the end section at node i (D.30), (D.32), in the frame."""
    shear2 = -end_moment_slope(f, rod, i) - f.shear_term[rod, i]
    return wp.vec3d(f.tension[rod, i], shear2, normal_shear[rod, i])


@wp.func
def end_power(f: Filaments, normal_shear: Scalars2D, rod: int, i: int) -> real:
    """m1 V_1 − m2 V' + λ3 V: power of a moving membrane on the end section at node i."""
    m = f.moment[rod, i]
    omega = membrane_angular_velocity(f, rod, i)
    return m[0] * omega[0] + m[1] * omega[1] + normal_shear[rod, i] * f.normal_velocity[rod, i]


@wp.kernel
def find_normal_shear(f: Filaments, normal_shear: Scalars2D):
    """λ3 at nodes."""
    rod, i = wp.tid()
    normal_shear[rod, i] = normal_shear_at(f, rod, i)


@wp.kernel
def find_load(f: Filaments, normal_shear: Scalars2D, load: Vectors2D, load_moment: Scalars2D):
    """Force per length on the membrane in space, and moment per length about the tangent, at nodes."""
    rod, i = wp.tid()
    load_moment[rod, i] = load_moment_at(f, rod, i)
    load[rod, i] = f.rotation[rod, i] * load_at(f, normal_shear, rod, i)


@wp.kernel
def find_end_loads(f: Filaments, normal_shear: Scalars2D, end_load: Vectors2D, end_moment: Vectors2D):
    """Force and moment of both end sections on the membrane, in space [rod, end]: (Λ, m) at the first, minus it at
    the last."""
    rod, end = wp.tid()
    i = end * (f.geodesic.shape[1] - 1)
    sign = real(1 - 2 * end)
    end_load[rod, end] = sign * (f.rotation[rod, i] * end_force_at(f, normal_shear, rod, i))
    end_moment[rod, end] = sign * (f.rotation[rod, i] * f.moment[rod, i])


@wp.kernel
def find_stretch_force(f: Filaments, stretch_force: Scalars2D):
    """λ + K12 m1 − K11 m2 at nodes, the force that does work where a section slides along the membrane."""
    rod, i = wp.tid()
    stretch_force[rod, i] = f.tension[rod, i] - free_end_tension(f.curvature[rod, i], f.moment[rod, i])


@wp.kernel
def find_membrane_power(f: Filaments, normal_shear: Scalars2D, power: Scalars1D):
    """Power of a moving membrane on each rod: −∫ (p V + χ V_1) ds and the power on the end sections."""
    rod = wp.tid()
    nodes = f.geodesic.shape[1]
    total = end_power(f, normal_shear, rod, nodes - 1) - end_power(f, normal_shear, rod, 0)
    for i in range(nodes):
        p = load_at(f, normal_shear, rod, i)[2]
        density = p * f.normal_velocity[rod, i] + load_moment_at(f, rod, i) * f.normal_velocity_slope[rod, i]
        total -= trapezoid_weight(i, nodes, f.spacing[rod]) * density
    power[rod] = total


@wp.kernel
def find_midpoint_gauss(f: Filaments, middle: int, gauss: Scalars1D):
    """Gaussian curvature of the surface at the middle node of each rod."""
    rod = wp.tid()
    gauss[rod] = gaussian(f.curvature[rod, middle])

"""What surface-bound filaments do to their membrane: the Lagrange multipliers' force (thesis 5.31, 5.32, D.28-D.34)."""

import warp as wp

from warp_rods.kernels.bound.membrane_motion import membrane_spin
from warp_rods.kernels.bound.rod import spin
from warp_rods.kernels.bound.state import Filaments, per_rod, scalars, vectors
from warp_rods.kernels.layout import real
from warp_rods.kernels.stencils import derivative, trapezoid_weight
from warp_rods.kernels.surface.geometry import gaussian

wp.set_module_options({"enable_backward": False})


@wp.func
def normal_shear(f: Filaments, rod: int, i: int) -> real:
    """λ3 = m2' + Ω m1 − K12 m3 (D.32), the part of the internal force along n."""
    m = f.moment[rod, i]
    dm = derivative(f.moment, rod, i, f.spacing[rod])
    return dm[1] + f.geodesic[rod, i] * m[0] - f.curvature[rod, i][1] * m[2]


@wp.func
def orientation_moment(f: Filaments, rod: int, i: int) -> real:
    """χ = e0·(m' + Ω×m) − ζr ω0 (D.33)."""
    m = f.moment[rod, i]
    dm = derivative(f.moment, rod, i, f.spacing[rod])
    K = f.curvature[rod, i]
    return dm[0] - K[0] * m[2] - f.geodesic[rod, i] * m[1] - f.drag[rod][2] * spin(f, rod, i)[0]


@wp.func
def membrane_load(f: Filaments, shear3: scalars, rod: int, i: int) -> wp.vec3d:
    """Force per length on the membrane in the frame (q, n×q, n): minus the constraint force on the filament.

    Along n it balances (∂sλ + Ω×λ)·n + f·n − ζ⊥ V; in the surface the filament feels χ(K12, K22) (D.35).
    """
    K = f.curvature[rod, i]
    h = f.spacing[rod]
    chi = orientation_moment(f, rod, i)
    shear2 = -derivative(f.moment, rod, i, h)[2] - f.shear[rod, i]
    f3 = wp.dot(f.rotation[rod, i] * wp.vec3d(real(0.0), real(0.0), real(1.0)), f.force[rod, i])
    press = derivative(shear3, rod, i, h) + K[1] * shear2 + K[0] * f.tension[rod, i] + f3
    press -= f.drag[rod][1] * f.normal_velocity[rod, i]
    return wp.vec3d(-chi * K[1], -chi * K[2], press)


@wp.func
def edge_power(f: Filaments, shear3: scalars, rod: int, i: int) -> real:
    """m1 V_1 − m2 V' + λ3 V: what a moving membrane gives to the rod beyond node i, an end, through its section."""
    m = f.moment[rod, i]
    turned = membrane_spin(f, rod, i)
    return m[0] * turned[0] + m[1] * turned[1] + shear3[rod, i] * f.normal_velocity[rod, i]


@wp.kernel
def membrane_powers(f: Filaments, shear3: scalars, power: per_rod):
    """Power of a moving membrane on each rod: −∫ (load·n V + χ V_1) ds and what it does at the ends."""
    rod = wp.tid()
    nodes = f.geodesic.shape[1]
    total = edge_power(f, shear3, rod, nodes - 1) - edge_power(f, shear3, rod, 0)
    for i in range(nodes):
        press = membrane_load(f, shear3, rod, i)[2]
        given = press * f.normal_velocity[rod, i] + orientation_moment(f, rod, i) * f.normal_velocity_slope[rod, i]
        total -= trapezoid_weight(i, nodes, f.spacing[rod]) * given
    power[rod] = total


@wp.kernel
def normal_shears(f: Filaments, shear3: scalars):
    """λ3 at nodes."""
    rod, i = wp.tid()
    shear3[rod, i] = normal_shear(f, rod, i)


@wp.kernel
def membrane_loads(f: Filaments, shear3: scalars, load: vectors, load_moment: scalars):
    """Force per length on the membrane in space, and moment per length about the tangent, at nodes."""
    rod, i = wp.tid()
    load_moment[rod, i] = orientation_moment(f, rod, i)
    load[rod, i] = f.rotation[rod, i] * membrane_load(f, shear3, rod, i)


@wp.kernel
def midpoint_gauss(f: Filaments, middle: int, gauss: wp.array(dtype=wp.float64)):
    """Gaussian curvature under each rod's middle node."""
    rod = wp.tid()
    gauss[rod] = gaussian(f.curvature[rod, middle])

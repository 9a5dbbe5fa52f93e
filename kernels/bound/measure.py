"""Energy, its density and the powers of surface-bound filaments (thesis 5.28; model §3)."""

import warp as wp

from warp_rods.kernels.bound.rod import node_velocity, spin, strain, velocity_along
from warp_rods.kernels.bound.state import Filaments, per_rod, scalars
from warp_rods.kernels.layout import real
from warp_rods.kernels.lie import quaternion
from warp_rods.kernels.stencils import trapezoid_weight

wp.set_module_options({"enable_backward": False})


@wp.func
def elastic_density(f: Filaments, rod: int, i: int) -> real:
    """½ Σ B (Ω − σ)², energy per length."""
    bend = strain(f.curvature[rod, i], f.geodesic[rod, i]) - f.intrinsic[rod]
    return real(0.5) * wp.dot(wp.cw_mul(f.stiffness[rod], bend), bend)


@wp.func
def dissipation_density(f: Filaments, rod: int, i: int) -> real:
    """ζ∥ u1² + ζ⊥ (u2² + V²) + ζr ω0², power per length."""
    u = wp.vec3d(velocity_along(f, rod, i), f.across[rod, i], spin(f, rod, i)[0])
    return wp.dot(f.drag[rod], wp.cw_mul(u, u)) + f.drag[rod][1] * f.normal_velocity[rod, i] * f.normal_velocity[rod, i]


@wp.func
def growth_power(f: Filaments, density: scalars, rod: int) -> real:
    """Energy per time that growth at the tips brings in, dL/dt e(tip): a free middle grows at both ends."""
    last = f.geodesic.shape[1] - 1
    share = real(f.anchor) / real(last)
    return f.growth_rate[rod] * (share * density[rod, 0] + (real(1.0) - share) * density[rod, last])


@wp.kernel
def orientations(f: Filaments, quaternions: wp.array2d(dtype=wp.quatd)):
    """Directors as quaternions x, y, z, w."""
    rod, i = wp.tid()
    quaternions[rod, i] = quaternion(f.rotation[rod, i])


@wp.func
def force_power_density(f: Filaments, rod: int, i: int) -> real:
    """f·u, power per length of the external force."""
    return wp.dot(f.force[rod, i], f.rotation[rod, i] * node_velocity(f, rod, i))


@wp.kernel
def energies(
    f: Filaments, density: scalars, energy: per_rod, dissipation: per_rod, growth: per_rod, force_power: per_rod
):
    """Elastic energy, its density at nodes, dissipation, power of growth and of the external force; trapezoid rule."""
    rod = wp.tid()
    h = f.spacing[rod]
    nodes = f.geodesic.shape[1]
    E = real(0.0)
    D = real(0.0)
    P = real(0.0)
    for i in range(nodes):
        e = elastic_density(f, rod, i)
        w = trapezoid_weight(i, nodes, h)
        density[rod, i] = e
        E += w * e
        D += w * dissipation_density(f, rod, i)
        P += w * force_power_density(f, rod, i)
    energy[rod] = E
    dissipation[rod] = D
    growth[rod] = growth_power(f, density, rod)
    force_power[rod] = P

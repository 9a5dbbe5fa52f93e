"""Energy, its density and the powers of surface-bound filaments (5.28), (docs/model.md §3.7)."""

import warp as wp

from warp_rods.kernels.bound.rod import angular_velocity, node_velocity, strain_of, velocity_along_at
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.layout import Quaternions2D, Scalars1D, Scalars2D, real
from warp_rods.kernels.lie import quaternion
from warp_rods.kernels.stencils import trapezoid_weight

wp.set_module_options({"enable_backward": False})


@wp.func
def elastic_density(f: Filaments, rod: int, i: int) -> real:
    """½ Σ B (strain − σ)², energy per length."""
    bending = strain_of(f.curvature[rod, i], f.geodesic[rod, i]) - f.intrinsic[rod]
    return real(0.5) * wp.dot(wp.cw_mul(f.stiffness[rod], bending), bending)


@wp.func
def dissipation_density(f: Filaments, rod: int, i: int) -> real:
    """ζ∥ u1² + ζ⊥ (u2² + V²) + ζr ω0², power per length."""
    u = wp.vec3d(velocity_along_at(f, rod, i), f.velocity_across[rod, i], angular_velocity(f, rod, i)[0])
    return wp.dot(f.drag[rod], wp.cw_mul(u, u)) + f.drag[rod][1] * f.normal_velocity[rod, i] * f.normal_velocity[rod, i]


@wp.func
def force_power_density(f: Filaments, rod: int, i: int) -> real:
    """f·u, power per length of the external force."""
    return wp.dot(f.force[rod, i], f.rotation[rod, i] * node_velocity(f, rod, i))


@wp.func
def growth_power(f: Filaments, density: Scalars2D, rod: int) -> real:
    """dL/dt e(tip), energy per time of new material at the tips; a rod that is free at both ends grows at both."""
    last = f.geodesic.shape[1] - 1
    share = real(f.tracked) / real(last)
    return f.growth_rate[rod] * (share * density[rod, 0] + (real(1.0) - share) * density[rod, last])


@wp.kernel
def find_energies(
    f: Filaments,
    density: Scalars2D,
    energy: Scalars1D,
    dissipation: Scalars1D,
    growth: Scalars1D,
    force_power: Scalars1D,
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


@wp.kernel
def find_orientations(f: Filaments, quaternions: Quaternions2D):
    """Directors as quaternions x, y, z, w."""
    rod, i = wp.tid()
    quaternions[rod, i] = quaternion(f.rotation[rod, i])

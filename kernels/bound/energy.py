"""Energy, its density and the powers of surface-bound filaments (5.28), (docs/model.md §3.7)."""

import warp as wp

from warp_rods.kernels.bound.outside import surplus_density
from warp_rods.kernels.bound.rod import angular_velocity, node_velocity, strain_of, velocity_along_at
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Lanes,
    Lanes2D,
    add,
    by_component,
    dot,
    mul,
    store_where,
    sub,
    vector,
)
from warp_rods.kernels.layout import Scalars1D, real
from warp_rods.kernels.stencils import trapezoid_weight

wp.set_module_options({"enable_backward": False})


@wp.func
def elastic_density(f: Filaments, tile: int, i: int) -> Lanes:
    """½ Σ B (strain − σ)², energy per length."""
    bending = strain_of(f.curvature[tile, i], f.geodesic[tile, i]) - f.intrinsic[tile, i]
    return real(0.5) * dot(by_component(f.stiffness[tile, i], bending), bending)


@wp.func
def dissipation_density(f: Filaments, tile: int, i: int) -> Lanes:
    """ζ∥ u1² + ζ⊥ (u2² + V²) + ζr ω0², power per length, of the velocities against the fluid."""
    u = vector(velocity_along_at(f, tile, i), f.velocity_across[tile, i], angular_velocity(f, tile, i)[0])
    V = f.normal_velocity[tile, i]
    drag = f.drag[tile, i]
    still = dot(drag, by_component(u, u)) + drag[1] * V * V
    return still + surplus_density(f, tile, i, vector(u[0], u[1], V), u[2])


@wp.func
def force_power_density(f: Filaments, tile: int, i: int) -> Lanes:
    """f·u + c·ω, power per length of external forces and couples, and of a flow, ζ (w − u)·w."""
    u = node_velocity(f, tile, i)
    power = dot(f.load[tile, i], u)
    if f.exposed == 1:
        omega = angular_velocity(f, tile, i)
        power += dot(f.couple[tile, i], omega) + surplus_density(f, tile, i, u, omega[0])
    return power


@wp.func
def growth_power(f: Filaments, density: Lanes2D, tile: int) -> Lanes:
    """dL/dt e(tip), energy per time of new material at the tips; a rod that is free at both ends grows at both."""
    last = f.geodesic.shape[1] - 1
    share = real(f.tracked) / real(last)
    return f.growth_rate[tile] * (share * density[tile, 0] + (real(1.0) - share) * density[tile, last])


@wp.func
def find_energies(
    f: Filaments,
    tile: int,
    density: Lanes2D,
    energy: Scalars1D,
    dissipation: Scalars1D,
    growth: Scalars1D,
    force_power: Scalars1D,
):
    """Elastic energy, its density at nodes, dissipation, power of growth and of the external force; trapezoid rule."""
    h = f.spacing[tile]
    nodes = f.geodesic.shape[1]
    E, D, P = Lanes(), Lanes(), Lanes()
    for i in range(nodes):
        e = elastic_density(f, tile, i)
        w = trapezoid_weight(i, nodes, h)
        density[tile, i] = e
        E += w * e
        D += w * dissipation_density(f, tile, i)
        P += w * force_power_density(f, tile, i)
    one = Lanes(real(1.0))
    store_where(energy, tile, one, E)
    store_where(dissipation, tile, one, D)
    store_where(growth, tile, one, growth_power(f, density, tile))
    store_where(force_power, tile, one, P)

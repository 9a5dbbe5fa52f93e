"""Regularised Yukawa repulsion between all nodes of a scene (model §3, "Steric"; thesis 5.27, 5.39, D.6).

    ρ = √(r² + ε²)     G = g0 e^(−ρ/a) / 4πρ     f_i = g0 Σ_j w_j (ρ + a) e^(−ρ/a) / (4π a ρ³) (r_i − r_j)

with trapezoid weights w: then w_i f_i is minus the gradient of ½ Σ w_i w_j G with respect to r_i, to round-off.
Each node gathers its own sum in the order of the grid: no atomics, the same bits every time.
"""

import warp as wp

from .layout import real
from .stencils import trapezoid_weight

wp.set_module_options({"enable_backward": False})

FOUR_PI = wp.constant(real(12.566370614359172))
REACH = 8.0
"""Pairs farther apart than this many ranges a are left out: what is missed is e⁻⁸/8 of the force scale."""


@wp.struct
class Cloud:
    """Every node of every ensemble in one list [point]."""

    position: wp.array(dtype=wp.vec3d)
    weight: wp.array(dtype=wp.float64)  # trapezoid weight: the length a node stands for
    arc: wp.array(dtype=wp.float64)  # arc length from the start of its rod
    apart: wp.array(dtype=wp.float64)  # pairs of one rod closer than this along it are left out
    rod: wp.array(dtype=wp.int32)  # number of its rod over all ensembles
    force: wp.array(dtype=wp.vec3d)  # force per length
    energy: wp.array(dtype=wp.float64)  # energy per length: half of each pair's


@wp.func
def yukawa(rho: real, strength: real, a: real) -> real:
    """G(ρ) = g0 e^(−ρ/a)/(4πρ)."""
    return strength * wp.exp(-rho / a) / (FOUR_PI * rho)


@wp.func
def push(rho: real, G: real, a: real) -> real:
    """−G'(ρ)/ρ: the force per separation (D.87), from G(ρ)."""
    return (rho + a) * G / (a * rho * rho)


@wp.func
def interacts(cloud: Cloud, i: int, j: int, separation: wp.vec3d, cutoff: real) -> bool:
    """Within reach, and not close neighbours along one rod."""
    if wp.dot(separation, separation) >= cutoff * cutoff:
        return False
    return cloud.rod[i] != cloud.rod[j] or wp.abs(cloud.arc[i] - cloud.arc[j]) >= cloud.apart[i]


@wp.kernel
def gather(grid: wp.uint64, cloud: Cloud, strength: real, a: real, core: real):
    """Force and energy per length at every node."""
    i = wp.hash_grid_point_id(grid, wp.tid())
    x = cloud.position[i]
    cutoff = real(REACH) * a
    force = wp.vec3d()
    energy = real(0.0)
    for j in wp.hash_grid_query(grid, x, cutoff):
        d = x - cloud.position[j]
        if interacts(cloud, i, j, d, cutoff):
            rho = wp.sqrt(wp.dot(d, d) + core * core)
            wG = cloud.weight[j] * yukawa(rho, strength, a)
            force += d * push(rho, wG, a)
            energy += wG
    cloud.force[i] = force
    cloud.energy[i] = real(0.5) * energy


@wp.kernel
def pack(
    position: wp.array2d(dtype=wp.vec3d),
    spacing: wp.array(dtype=wp.float64),
    first: int,
    core: real,
    cloud: Cloud,
):
    """One ensemble's nodes into the list from ``first`` on."""
    rod, i = wp.tid()
    nodes = position.shape[1]
    h = spacing[rod]
    k = first + rod * nodes + i
    cloud.position[k] = position[rod, i]
    cloud.weight[k] = trapezoid_weight(i, nodes, h)
    cloud.arc[k] = h * real(i)
    # A little off the bound, so that round-off does not decide which pairs it leaves out.
    cloud.apart[k] = wp.max(real(2.0) * core, real(4.0) * h) - real(1e-6) * h


@wp.kernel
def unpack(cloud: Cloud, first: int, force: wp.array2d(dtype=wp.vec3d)):
    """The list's forces from ``first`` on back to one ensemble."""
    rod, i = wp.tid()
    force[rod, i] = cloud.force[first + rod * force.shape[1] + i]


@wp.kernel
def rod_energies(cloud: Cloud, first: int, nodes: int, energy: wp.array(dtype=wp.float64)):
    """Each rod's share of the pair energy: ½ Σ w_i w_j G over its nodes."""
    rod = wp.tid()
    total = real(0.0)
    for i in range(nodes):
        k = first + rod * nodes + i
        total += cloud.weight[k] * cloud.energy[k]
    energy[rod] = total

"""Regularised Yukawa repulsion between all nodes of a scene (model §3, "Steric"; thesis 5.27, 5.39, D.6).

    ρ = √(r² + ε²)     G = g0 e^(−ρ/a) / 4πρ     f_i = g0 Σ_j w_j (ρ + a) e^(−ρ/a) / (4π a ρ³) (r_i − r_j)

with trapezoid weights w: then w_i f_i is minus the gradient of ½ Σ w_i w_j G with respect to r_i, to round-off.
A pair beyond the reach is left out, and within it G less its tangent there is taken, G − G_c − G'_c (ρ − ρ_c): where
ε > a contact itself is weak, a force that ended at once would end at a per cent of it, and steps lose their order.
Each node gathers its own sum in the order of its list of neighbours, which is that of their numbers: no atomics, and
the same bits however often lists are made and whatever more they hold.
"""

import warp as wp

from warp_rods.kernels.contact.box import nearest_image
from warp_rods.kernels.contact.neighbour_list import Cloud, Lists
from warp_rods.kernels.contact.reach import REACH as REACH
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.struct
class Pairs:
    """What each node feels of the others [point]."""

    force: wp.array(dtype=wp.vec3d)  # force per length
    energy: wp.array(dtype=wp.float64)  # energy per length: half of each pair's


@wp.struct
class Yukawa:
    """G(ρ) = g0 e^(−ρ/a)/4πρ in numbers that a pair needs, and what it has at the end of the reach."""

    strength: real  # g0/4π
    per_range: real  # 1/a
    core_square: real  # ε²
    reach_square: real
    rho_end: real  # ρ_c
    G_end: real  # G(ρ_c)
    F_end: real  # −G'(ρ_c)


@wp.func
def pair(square: real, y: Yukawa):
    """G and −G'/ρ, the force per separation (D.87), at this square of the distance: both nothing at the reach."""
    rho = wp.sqrt(square + y.core_square)
    per_rho = real(1.0) / rho
    G = y.strength * wp.exp(-rho * y.per_range) * per_rho
    F = (per_rho + y.per_range) * G
    return G - y.G_end + y.F_end * (rho - y.rho_end), (F - y.F_end) * per_rho


@wp.func
def stiffness(square: real, y: Yukawa) -> real:
    """Largest |eigenvalue| of ∂f/∂d for f = P(ρ) d, P = −G'/ρ: across d it is P, along it P − (G'' + P) r²/ρ²."""
    rho_square = square + y.core_square
    rho = wp.sqrt(rho_square)
    _, P = pair(square, y)
    G = y.strength * wp.exp(-rho * y.per_range) / rho
    bend = (y.per_range * y.per_range + real(2.0) * (y.per_range + real(1.0) / rho) / rho) * G
    return wp.max(P, wp.abs(P - (bend + P) * square / rho_square))


@wp.kernel
def gather(cloud: Cloud, lists: Lists, yukawa: Yukawa, first: int, pairs: Pairs):
    """Force and energy per length at every node from ``first`` on."""
    i = first + wp.tid()
    x = cloud.position[i]
    force = wp.vec3d()
    energy = real(0.0)
    for n in range(lists.count[i]):
        j = lists.near[i, n]
        d = nearest_image(x - cloud.position[j], cloud.period)
        square = wp.dot(d, d)
        if square < yukawa.reach_square:
            G, P = pair(square, yukawa)
            w = cloud.weight[j]
            force += d * (w * P)
            energy += w * G
    pairs.force[i] = force
    pairs.energy[i] = real(0.5) * energy


@wp.kernel
def stiffnesses(cloud: Cloud, lists: Lists, yukawa: Yukawa, stiff: wp.array(dtype=wp.float64)):
    """Σ_j w_j |∂f/∂d| of every node, over its drag: how fast contact pulls it back at most; 1/time."""
    i = wp.tid()
    total = real(0.0)
    for n in range(lists.count[i]):
        j = lists.near[i, n]
        d = nearest_image(cloud.position[i] - cloud.position[j], cloud.period)
        square = wp.dot(d, d)
        if square < yukawa.reach_square:
            total += cloud.weight[j] * stiffness(square, yukawa)
    stiff[i] = total / cloud.drag[i]


@wp.kernel
def unpack(pairs: Pairs, first: int, force: wp.array2d(dtype=wp.vec3d)):
    """The list's forces from ``first`` on back to one ensemble."""
    rod, i = wp.tid()
    force[rod, i] = pairs.force[first + rod * force.shape[1] + i]


@wp.kernel
def rod_energies(cloud: Cloud, pairs: Pairs, first: int, nodes: int, energy: wp.array(dtype=wp.float64)):
    """Each rod's share of the pair energy: ½ Σ w_i w_j G over its nodes."""
    rod = wp.tid()
    total = real(0.0)
    for i in range(nodes):
        k = first + rod * nodes + i
        total += cloud.weight[k] * pairs.energy[k]
    energy[rod] = total

"""Regularised Yukawa repulsion between all nodes of a scene (model §3, "Steric"; thesis 5.27, 5.39, D.6).

    ρ = √(r² + ε²)     G = g0 e^(−ρ/a) / 4πρ     f_i = g0 Σ_j w_j (ρ + a) e^(−ρ/a) / (4π a ρ³) (r_i − r_j)

with trapezoid weights w: then w_i f_i is minus the gradient of ½ Σ w_i w_j G with respect to r_i, to round-off.
A pair beyond the reach is left out, and within it G less its tangent there is taken, G − G_c − G'_c (ρ − ρ_c): where
ε > a contact itself is weak, a force that ended at once would end at a per cent of it, and steps lose their order.
Each node gathers its own sum in the order of its list of neighbours, which is that of their numbers: no atomics, and
the same bits however often lists are made and whatever more they hold.
"""

import warp as wp

from .box import nearest_image
from .layout import real
from .neighbour_list import Cloud, Lists

wp.set_module_options({"enable_backward": False})

FOUR_PI = wp.constant(real(12.566370614359172))
REACH = 8.0
"""Pairs farther apart than this many ranges a are left out."""


@wp.struct
class Pairs:
    """What each node feels of the others [point]."""

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
def reach_end(strength: real, a: real, core: real):
    """ρ, G and −G' where the reach ends."""
    cutoff = real(REACH) * a
    rho = wp.sqrt(cutoff * cutoff + core * core)
    G = yukawa(rho, strength, a)
    return rho, G, rho * push(rho, G, a)


@wp.func
def stiffness(square: real, rho: real, G: real, a: real, F_end: real) -> real:
    """Largest |eigenvalue| of ∂f/∂d for f = P(ρ) d, P = −G'/ρ: across d it is P, along it P + P' r²/ρ."""
    inverse = real(1.0) / rho
    P = push(rho, G, a) - F_end * inverse
    bend = (rho * rho + real(3.0) * a * rho + real(3.0) * a * a) * G / (a * a * rho)  # −ρ³ P', but for F_end
    along = P - square * (bend - F_end) * inverse * inverse * inverse
    return wp.max(P, wp.abs(along))


@wp.kernel
def gather(cloud: Cloud, lists: Lists, strength: real, a: real, core: real, first: int, pairs: Pairs):
    """Force and energy per length at every node from ``first`` on."""
    i = first + wp.tid()
    x = cloud.position[i]
    cutoff = real(REACH) * a
    rho_end, G_end, F_end = reach_end(strength, a, core)
    force = wp.vec3d()
    energy = real(0.0)
    for n in range(lists.count[i]):
        j = lists.near[i, n]
        d = nearest_image(x - cloud.position[j], cloud.period)
        square = wp.dot(d, d)
        if square < cutoff * cutoff:
            rho = wp.sqrt(square + core * core)
            G = yukawa(rho, strength, a)
            w = cloud.weight[j]
            force += d * (w * (push(rho, G, a) - F_end / rho))
            energy += w * (G - G_end + F_end * (rho - rho_end))
    pairs.force[i] = force
    pairs.energy[i] = real(0.5) * energy


@wp.kernel
def stiffnesses(cloud: Cloud, lists: Lists, strength: real, a: real, core: real, stiff: wp.array(dtype=wp.float64)):
    """Σ_j w_j |∂f/∂d| of every node, over its drag: how fast contact pulls it back at most; 1/time."""
    i = wp.tid()
    x = cloud.position[i]
    cutoff = real(REACH) * a
    _, _, F_end = reach_end(strength, a, core)
    total = real(0.0)
    for n in range(lists.count[i]):
        j = lists.near[i, n]
        d = nearest_image(x - cloud.position[j], cloud.period)
        square = wp.dot(d, d)
        if square < cutoff * cutoff:
            rho = wp.sqrt(square + core * core)
            total += cloud.weight[j] * stiffness(square, rho, yukawa(rho, strength, a), a, F_end)
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

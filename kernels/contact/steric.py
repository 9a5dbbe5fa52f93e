"""Regularised Yukawa repulsion between all nodes of a scene (docs/model.md §6.1; (5.27), (5.39), appendix D.6).

    ρ = √(r² + ε²)     G = g0 e^(−ρ/a)/4πρ     f_i = Σ_j w_j P(ρ) (r_i − r_j),  P = −G'(ρ)/ρ

With the trapezoid weights w, w_i f_i is minus the gradient of ½ Σ w_i w_j G with respect to r_i, to round-off. Pairs
beyond the cut-off ρ_c are left out; the tangent at the cut-off is subtracted from G, G − G_c − G'_c (ρ − ρ_c), so that
the force vanishes there continuously. Where ε > a contact is weak: a plain cut-off would leave a jump of about a per
cent of the force, and the time step would lose its order.

Each node sums over its neighbours in increasing order, without atomics. The bits depend on the positions only, not on
when the lists were built or which pairs beyond the cut-off they contain.
"""

import warp as wp

from warp_rods.kernels.contact.box import nearest_image
from warp_rods.kernels.contact.cutoff import CUTOFF as CUTOFF
from warp_rods.kernels.contact.neighbour_list import Lists, Points, are_close_along
from warp_rods.kernels.layout import Matrices1D, Matrices2D, Scalars1D, Vectors1D, Vectors2D, real

wp.set_module_options({"enable_backward": False})


@wp.struct
class PairSums:
    """Sums over the neighbours of each point [point]."""

    force: Vectors1D  # force per length
    energy: Scalars1D  # energy per length; half of the energy of each pair
    stiffness: Matrices1D  # K, of the push on the point against its own motion


@wp.struct
class Yukawa:
    """Parameters of G(ρ) = g0 e^(−ρ/a)/4πρ, and its values at the cut-off."""

    strength: real  # g0/4π
    inverse_range: real  # 1/a
    core_square: real  # ε²
    cutoff_square: real  # of the distance r
    rho_cutoff: real  # ρ_c
    G_cutoff: real  # G(ρ_c)
    F_cutoff: real  # −G'(ρ_c)


@wp.func
def pair_potential(square: real, y: Yukawa):
    """G and P = −G'/ρ (D.87) at a squared distance; both vanish at the cut-off."""
    rho = wp.sqrt(square + y.core_square)
    inverse_rho = real(1.0) / rho
    G = y.strength * wp.exp(-rho * y.inverse_range) * inverse_rho
    F = (inverse_rho + y.inverse_range) * G
    return G - y.G_cutoff + y.F_cutoff * (rho - y.rho_cutoff), (F - y.F_cutoff) * inverse_rho


@wp.func
def stiffness_along(square: real, P: real, y: Yukawa) -> real:
    """−∂f/∂d along d for f = P(ρ) d, (G'' + P) r²/ρ² − P, where it is positive: the push stiffens as nodes approach."""
    rho_square = square + y.core_square
    rho = wp.sqrt(rho_square)
    G = y.strength * wp.exp(-rho * y.inverse_range) / rho
    second_derivative = (y.inverse_range * y.inverse_range + real(2.0) * (y.inverse_range + real(1.0) / rho) / rho) * G
    return wp.max((second_derivative + P) * square / rho_square - P, real(0.0))


@wp.kernel
def sum_pairs(points: Points, lists: Lists, yukawa: Yukawa, first: int, sums: PairSums):
    """Force, energy and stiffness per length at every point from ``first`` on."""
    i = first + wp.tid()
    block = lists.block[i]
    x = points.position[i]
    force = wp.vec3d()
    energy = real(0.0)
    stiffness = wp.mat33d()
    for n in range(lists.count[block]):
        j = lists.neighbour[block, n]
        d = nearest_image(x - points.position[j], points.period)
        square = wp.dot(d, d)
        if square < yukawa.cutoff_square and not are_close_along(points, i, j):
            G, P = pair_potential(square, yukawa)
            w = points.weight[j]
            force += d * (w * P)
            energy += w * G
            if square > real(0.0):
                stiffness += (w * stiffness_along(square, P, yukawa) / square) * wp.outer(d, d)
    sums.force[i] = force
    sums.energy[i] = real(0.5) * energy
    sums.stiffness[i] = stiffness


@wp.kernel
def distribute(sums: PairSums, first: int, force: Vectors2D, stiffness: Matrices2D):
    """Copy force and stiffness of the points from ``first`` on to the nodes of one ensemble."""
    rod, i = wp.tid()
    k = first + rod * force.shape[1] + i
    force[rod, i] = sums.force[k]
    stiffness[rod, i] = sums.stiffness[k]


@wp.kernel
def find_rod_energies(points: Points, sums: PairSums, first: int, nodes: int, energy: Scalars1D):
    """Steric energy of each rod of an ensemble, ½ Σ w_i w_j G over its nodes i."""
    rod = wp.tid()
    total = real(0.0)
    for i in range(nodes):
        k = first + rod * nodes + i
        total += points.weight[k] * sums.energy[k]
    energy[rod] = total

"""The bending of active rods at the end of a step (docs/model.md §2.4).

    (a − J) δk = ∂k/∂t(x*) − Σ d_j k_j                δk = δk' = 0 at the ends
    J z = [i (shear' − i λ* z)/ζ⊥]'' + (u0* z)' − i ω0* z,    shear = i b z' + c τ* z, odd beyond the ends

J is the derivative of ∂k/∂t at constant tension, tangential velocity, twist and roll. It couples both bending
components where the rod is twisted, as a complex number does, or contact adds a drag to η, as a matrix does. Otherwise
it is the same for both.
"""

from typing import Any

import warp as wp

from warp_rods.kernels.block_banded import solve_block_pentadiagonal_rod
from warp_rods.kernels.free.rod import bending_rate, set_zero_end_rows, solve_in_place
from warp_rods.kernels.free.state import Balance, Shape, Swimmers
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Block,
    Lanes,
    Pair,
    Pairs,
    add,
    all_of,
    any_of,
    block,
    larger,
    magnitude,
    mul,
    none_like,
    pair,
    sub,
    where,
)
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.func
def step_bending(tile: int, rods: Swimmers, star: Shape, slope: Shape, a: Lanes, balance: Balance):
    """From k* to kⁿ⁺¹."""
    last = star.twist.shape[1] - 1
    balance.rhs_pairs[tile, 0] = Pair()
    balance.rhs_pairs[tile, last] = Pair()
    for node in range(1, last):
        rate = bending_rate(tile, node, rods, star.bending[tile, node], balance)
        balance.rhs_pairs[tile, node] = rate - slope.bending[tile, node]
    equal = where(
        is_planar(tile, rods, star), where(feels_contact(tile, rods, balance), Lanes(), Lanes(real(1.0))), Lanes()
    )
    if all_of(equal):
        solve_equal(tile, rods, a, balance, balance.rhs_pairs)
    else:
        solve_coupled(tile, rods, star, a, equal, balance)
    for node in range(1, last):
        star.bending[tile, node] += balance.rhs_pairs[tile, node]


@wp.func
def solve_equal(tile: int, rods: Swimmers, a: Lanes, balance: Balance, rhs: Pairs):
    """δk of rods whose matrix is the same for both components, stored in place of the right-hand side."""
    set_rows(tile, rods, a, balance)
    solve_in_place(tile, balance, rhs)


@wp.func
def solve_coupled(tile: int, rods: Swimmers, star: Shape, a: Lanes, equal: Lanes, balance: Balance):
    """δk of any rods; those where ``equal`` is not zero get what ``solve_equal`` finds."""
    nodes = star.twist.shape[1]
    if any_of(equal):
        for node in range(nodes):
            balance.rhs_equal[tile, node] = balance.rhs_pairs[tile, node]
        solve_equal(tile, rods, a, balance, balance.rhs_equal)
    if rods.touched == 1:
        set_block_rows(tile, rods, star, a, balance)
        solve_block_bending(tile, balance)
    else:
        set_complex_rows(tile, rods, star, a, balance)
        solve_complex_bending(tile, balance)
    if any_of(equal):
        for node in range(nodes):
            balance.rhs_pairs[tile, node] = where(equal, balance.rhs_equal[tile, node], balance.rhs_pairs[tile, node])


@wp.func
def set_rows(tile: int, rods: Swimmers, a: Lanes, balance: Balance):
    """Rows of a − J of a rod in a plane, ``a + (b/η)∂⁴ − (1/η)∂²(λ* ·) − ∂(u0* ·)``, the same for both components."""
    last = balance.tension.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    mobility = per_length * per_length / rods.drag_ratio[tile]
    stiffness = rods.bending_stiffness[tile] * mobility * per_length * per_length
    half = real(0.5) * per_length
    off_diagonal = real(-4.0) * stiffness
    u0 = balance.axial_velocity[tile, 0]
    for node in range(1, last):
        u0_next = balance.axial_velocity[tile, node]
        centre = a + real(6.0) * stiffness + real(2.0) * mobility * balance.tension[tile, node]
        balance.lower2[tile, node] = stiffness
        balance.lower[tile, node] = off_diagonal - mobility * balance.tension[tile, node - 1] + half * u0
        balance.diagonal[tile, node] = centre + half * (u0 - u0_next)
        balance.upper[tile, node] = off_diagonal - mobility * balance.tension[tile, node + 1] - half * u0_next
        balance.upper2[tile, node] = stiffness
        u0 = u0_next
    set_free_end_rows(tile, last, stiffness, balance)


@wp.func
def half_twist(tile: int, half: int, last: int, shape: Shape):
    """τ at a half node; beyond the ends minus that of the last one, as the shear is odd there."""
    if half < 0:
        return real(-0.5) * (shape.twist[tile, 0] + shape.twist[tile, 1])
    if half >= last:
        return real(-0.5) * (shape.twist[tile, last - 1] + shape.twist[tile, last])
    return real(0.5) * (shape.twist[tile, half] + shape.twist[tile, half + 1])


@wp.func
def set_complex_rows(tile: int, rods: Swimmers, star: Shape, a: Lanes, balance: Balance):
    """Rows of a − J of rods that feel no contact, where it multiplies complex numbers.

    With S = τ(z_i + z_(i+1))/2 at half nodes, ∂²(i(τz)') at node i is i (S_(i+3/2) − 3 S_(i+1/2) + 3 S_(i−1/2) −
    S_(i−3/2))/Δs³. Beyond an end S is minus its mirror image, whose z are those of the first inner node and the end.
    """
    last = star.twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    mobility = per_length * per_length / rods.drag_ratio[tile]
    b = rods.bending_stiffness[tile] * mobility * per_length * per_length
    c = real(-0.5) * per_length * rods.twist_stiffness[tile] * mobility
    half = real(0.5) * per_length
    two, three, four, six = real(2.0), real(3.0), real(4.0), real(6.0)
    set_identity_rows(
        tile,
        last,
        pair(Lanes(real(1.0)), Lanes()),
        balance.complex_lower2,
        balance.complex_lower,
        balance.complex_diagonal,
        balance.complex_upper,
        balance.complex_upper2,
    )
    tau = c * half_twist(tile, -1, last, star)
    tau_after = c * half_twist(tile, 0, last, star)
    tau_after2 = c * half_twist(tile, 1, last, star)
    u0_next = half * balance.axial_velocity[tile, 0]
    for node in range(1, last):
        tau_before2 = tau
        tau = tau_after
        tau_after = tau_after2
        tau_after2 = c * half_twist(tile, node + 1, last, star)
        u0 = u0_next
        u0_next = half * balance.axial_velocity[tile, node]
        pull = mobility * balance.tension[tile, node]
        pull_before = four * b + mobility * balance.tension[tile, node - 1]
        pull_after = four * b + mobility * balance.tension[tile, node + 1]
        centre = pair(
            a + u0 - u0_next + six * b + two * pull, three * (tau - tau_after) + balance.bishop_roll_rate[tile, node]
        )
        lower2 = pair(b, -tau_before2)
        upper2 = pair(b, tau_after2)
        if node == 1:  # the mirror image of z_(-1) is z_1
            centre += lower2
        if node == last - 1:
            centre += upper2
        balance.complex_lower2[tile, node] = lower2
        balance.complex_lower[tile, node] = pair(u0 - pull_before, three * tau - tau_before2)
        balance.complex_diagonal[tile, node] = centre
        balance.complex_upper[tile, node] = pair(-u0_next - pull_after, tau_after2 - three * tau_after)
        balance.complex_upper2[tile, node] = upper2


@wp.func
def solve_complex_bending(tile: int, balance: Balance):
    """δk of rods in space that feel no contact, stored in place of the right-hand side."""
    solve_block_pentadiagonal_rod(
        tile,
        balance.complex_lower2,
        balance.complex_lower,
        balance.complex_diagonal,
        balance.complex_upper,
        balance.complex_upper2,
        balance.rhs_pairs,
        balance.work_pairs,
        balance.work_pairs2,
        balance.rhs_pairs,
    )


@wp.func
def turned(M: Block):
    """i M as a matrix."""
    return block(-M[2], -M[3], M[0], M[1])


@wp.func
def turned_twice(M: Block):
    """−i M i as a matrix, which is M where drag across is isotropic."""
    return block(M[3], -M[2], -M[1], M[0])


@wp.func
def identity(a: Lanes):
    """a times the identity."""
    return block(a, Lanes(), Lanes(), a)


@wp.func
def set_block_rows(tile: int, rods: Swimmers, star: Shape, a: Lanes, balance: Balance):
    """Rows of a − J of rods in contact, whose drag across has a direction, in the stencil of the forces.

    With S = τ(z_i + z_(i+1))/2 at half nodes and m = 1/ζ⊥, ∂²(i m(τz)') at node i is i (m_(i+1) S_(i+3/2) −
    (m_(i+1) + 2m_i) S_(i+1/2) + (2m_i + m_(i−1)) S_(i−1/2) − m_(i−1) S_(i−3/2))/Δs³. Beyond an end S is minus its
    mirror image, whose z are those of the first inner node and the end.
    """
    last = star.twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    square = per_length * per_length
    b = rods.bending_stiffness[tile] * square * square
    c = real(-0.5) * rods.twist_stiffness[tile] * square * per_length
    half = real(0.5) * per_length
    two = real(2.0)
    set_identity_rows(
        tile,
        last,
        identity(Lanes(real(1.0))),
        balance.block_lower2,
        balance.block_lower,
        balance.block_diagonal,
        balance.block_upper,
        balance.block_upper2,
    )
    m = balance.transverse_mobility[tile, 0]
    m_after = balance.transverse_mobility[tile, 1]
    tau = c * half_twist(tile, -1, last, star)
    tau_after = c * half_twist(tile, 0, last, star)
    tau_after2 = c * half_twist(tile, 1, last, star)
    u0_next = half * balance.axial_velocity[tile, 0]
    for node in range(1, last):
        m_before = m
        m = m_after
        m_after = balance.transverse_mobility[tile, node + 1]
        tau_before2 = tau
        tau = tau_after
        tau_after = tau_after2
        tau_after2 = c * half_twist(tile, node + 1, last, star)
        u0 = u0_next
        u0_next = half * balance.axial_velocity[tile, node]
        pull_before = square * balance.tension[tile, node - 1]
        pull = square * balance.tension[tile, node]
        pull_after = square * balance.tension[tile, node + 1]
        lower2 = turned_twice(b * m_before) - turned(tau_before2 * m_before)
        lower = turned((tau - tau_before2) * m_before + (two * tau) * m)
        lower += identity(u0) - turned_twice((two * b + pull_before) * m_before + (two * b) * m)
        centre = turned(tau * m_before + (two * (tau - tau_after)) * m - tau_after * m_after)
        centre += turned_twice(b * (m_before + m_after) + (real(4.0) * b + two * pull) * m)
        centre += identity(a + u0 - u0_next) + turned(identity(balance.bishop_roll_rate[tile, node]))
        upper = turned((tau_after2 - tau_after) * m_after - (two * tau_after) * m)
        upper -= identity(u0_next) + turned_twice((two * b + pull_after) * m_after + (two * b) * m)
        upper2 = turned_twice(b * m_after) + turned(tau_after2 * m_after)
        if node == 1:  # the mirror image of z_(-1) is z_1
            centre += lower2
        if node == last - 1:
            centre += upper2
        balance.block_lower2[tile, node] = lower2
        balance.block_lower[tile, node] = lower
        balance.block_diagonal[tile, node] = centre
        balance.block_upper[tile, node] = upper
        balance.block_upper2[tile, node] = upper2


@wp.func
def set_identity_rows(tile: int, last: int, one: Any, lower2: Any, lower: Any, diagonal: Any, upper: Any, upper2: Any):
    """Rows of both ends, where z is zero: ``one``, of complex numbers or blocks, on the diagonal."""
    for end in range(2):
        node = end * last
        lower2[tile, node] = none_like(one)
        lower[tile, node] = none_like(one)
        diagonal[tile, node] = one
        upper[tile, node] = none_like(one)
        upper2[tile, node] = none_like(one)


@wp.func
def is_planar(tile: int, rods: Swimmers, shape: Shape):
    """1 for rods that have no twist and get none, and so are bent in one plane, 0 for others."""
    most = magnitude(rods.moment[tile])
    for node in range(shape.twist.shape[1]):
        most = larger(most, magnitude(shape.twist[tile, node]))
    return where(most, Lanes(), Lanes(real(1.0)))


@wp.func
def feels_contact(tile: int, rods: Swimmers, balance: Balance):
    """Not zero where contact adds drag across the rod, which then is another in each direction."""
    most = Lanes()
    if rods.touched == 1:
        for node in range(balance.tension.shape[1]):
            D = balance.load.transverse_drag[tile, node]
            most = larger(most, D[0] + D[3])
    return most


@wp.func
def set_free_end_rows(tile: int, last: int, stiffness: Lanes, balance: Balance):
    """End rows of the pentadiagonal system for ``k = k' = 0`` at both free ends; beyond them k is its mirror image."""
    set_zero_end_rows(tile, last, balance)
    balance.upper2[tile, 0] = Lanes()
    balance.lower2[tile, last] = Lanes()
    balance.diagonal[tile, 1] += stiffness
    balance.diagonal[tile, last - 1] += stiffness


@wp.func
def solve_block_bending(tile: int, balance: Balance):
    """δk of a rod in space, stored in place of the right-hand side."""
    solve_block_pentadiagonal_rod(
        tile,
        balance.block_lower2,
        balance.block_lower,
        balance.block_diagonal,
        balance.block_upper,
        balance.block_upper2,
        balance.rhs_pairs,
        balance.work_block,
        balance.work_block2,
        balance.rhs_pairs,
    )

"""The bending of active rods at the end of a step (docs/model.md §2.4).

    (a − J) δk = ∂k/∂t(x*) − Σ d_j k_j                δk = δk' = 0 at the ends
    J z = [i (shear' − i λ* z)/ζ⊥]'' + (u0* z)' − i ω0* z,    shear = i b z' + c τ* z, odd beyond the ends

J is the derivative of ∂k/∂t at constant tension, tangential velocity, twist and roll. It couples both bending
components where the rod is twisted or contact adds a drag to η. Otherwise it is the same for both.
"""

import warp as wp

from warp_rods.kernels.block_banded import solve_block_pentadiagonal_rod
from warp_rods.kernels.free.rod import bending_rate, set_zero_end_rows, solve_in_place
from warp_rods.kernels.free.state import Balance, Shape, Swimmers
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.func
def step_bending(rod: int, rods: Swimmers, star: Shape, slope: Shape, a: real, balance: Balance):
    """From k* to kⁿ⁺¹."""
    last = star.twist.shape[1] - 1
    balance.rhs_pairs[rod, 0] = wp.vec2d()
    balance.rhs_pairs[rod, last] = wp.vec2d()
    for node in range(1, last):
        rate = bending_rate(rod, node, rods, star.bending[rod, node], balance)
        balance.rhs_pairs[rod, node] = rate - slope.bending[rod, node]
    if is_planar(rod, rods, star) and not feels_contact(rod, rods, balance):
        set_rows(rod, rods, a, balance)
        solve_in_place(rod, balance, balance.rhs_pairs)
    else:
        set_block_rows(rod, rods, star, a, balance)
        solve_block_bending(rod, balance)
    for node in range(1, last):
        star.bending[rod, node] += balance.rhs_pairs[rod, node]


@wp.func
def set_rows(rod: int, rods: Swimmers, a: real, balance: Balance):
    """Rows of a − J of a rod in a plane, ``a + (b/η)∂⁴ − (1/η)∂²(λ* ·) − ∂(u0* ·)``, the same for both components."""
    last = balance.tension.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    mobility = per_length * per_length / rods.drag_ratio[rod]
    stiffness = rods.bending_stiffness[rod] * mobility * per_length * per_length
    half = real(0.5) * per_length
    off_diagonal = real(-4.0) * stiffness
    u0 = balance.axial_velocity[rod, 0]
    for node in range(1, last):
        u0_next = balance.axial_velocity[rod, node]
        centre = a + real(6.0) * stiffness + real(2.0) * mobility * balance.tension[rod, node]
        balance.lower2[rod, node] = stiffness
        balance.lower[rod, node] = off_diagonal - mobility * balance.tension[rod, node - 1] + half * u0
        balance.diagonal[rod, node] = centre + half * (u0 - u0_next)
        balance.upper[rod, node] = off_diagonal - mobility * balance.tension[rod, node + 1] - half * u0_next
        balance.upper2[rod, node] = stiffness
        u0 = u0_next
    set_free_end_rows(rod, last, stiffness, balance)


@wp.func
def half_twist(rod: int, half: int, last: int, shape: Shape):
    """τ at a half node; beyond the ends minus that of the last one, as the shear is odd there."""
    if half < 0:
        return real(-0.5) * (shape.twist[rod, 0] + shape.twist[rod, 1])
    if half >= last:
        return real(-0.5) * (shape.twist[rod, last - 1] + shape.twist[rod, last])
    return real(0.5) * (shape.twist[rod, half] + shape.twist[rod, half + 1])


@wp.func
def turned(M: wp.mat22d):
    """i M as a matrix."""
    return wp.mat22d(-M[1, 0], -M[1, 1], M[0, 0], M[0, 1])


@wp.func
def turned_twice(M: wp.mat22d):
    """−i M i as a matrix, which is M where drag across is isotropic."""
    return wp.mat22d(M[1, 1], -M[1, 0], -M[0, 1], M[0, 0])


@wp.func
def identity(a: real):
    """a times the identity."""
    return wp.mat22d(a, real(0.0), real(0.0), a)


@wp.func
def set_block_rows(rod: int, rods: Swimmers, star: Shape, a: real, balance: Balance):
    """Rows of a − J, which couples both bending components, in the stencil of the forces.

    With S = τ(z_i + z_(i+1))/2 at half nodes and m = 1/ζ⊥, ∂²(i m(τz)') at node i is i (m_(i+1) S_(i+3/2) −
    (m_(i+1) + 2m_i) S_(i+1/2) + (2m_i + m_(i−1)) S_(i−1/2) − m_(i−1) S_(i−3/2))/Δs³. Beyond an end S is minus its
    mirror image, whose z are those of the first inner node and the end.
    """
    last = star.twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    square = per_length * per_length
    b = rods.bending_stiffness[rod] * square * square
    c = real(-0.5) * rods.twist_stiffness[rod] * square * per_length
    half = real(0.5) * per_length
    two = real(2.0)
    set_identity_rows(rod, last, balance)
    m = balance.transverse_mobility[rod, 0]
    m_after = balance.transverse_mobility[rod, 1]
    tau = c * half_twist(rod, -1, last, star)
    tau_after = c * half_twist(rod, 0, last, star)
    tau_after2 = c * half_twist(rod, 1, last, star)
    u0_next = half * balance.axial_velocity[rod, 0]
    for node in range(1, last):
        m_before = m
        m = m_after
        m_after = balance.transverse_mobility[rod, node + 1]
        tau_before2 = tau
        tau = tau_after
        tau_after = tau_after2
        tau_after2 = c * half_twist(rod, node + 1, last, star)
        u0 = u0_next
        u0_next = half * balance.axial_velocity[rod, node]
        pull_before = square * balance.tension[rod, node - 1]
        pull = square * balance.tension[rod, node]
        pull_after = square * balance.tension[rod, node + 1]
        lower2 = turned_twice(b * m_before) - turned(tau_before2 * m_before)
        lower = turned((tau - tau_before2) * m_before + (two * tau) * m)
        lower += identity(u0) - turned_twice((two * b + pull_before) * m_before + (two * b) * m)
        centre = turned(tau * m_before + (two * (tau - tau_after)) * m - tau_after * m_after)
        centre += turned_twice(b * (m_before + m_after) + (real(4.0) * b + two * pull) * m)
        centre += identity(a + u0 - u0_next) + turned(identity(balance.bishop_roll_rate[rod, node]))
        upper = turned((tau_after2 - tau_after) * m_after - (two * tau_after) * m)
        upper -= identity(u0_next) + turned_twice((two * b + pull_after) * m_after + (two * b) * m)
        upper2 = turned_twice(b * m_after) + turned(tau_after2 * m_after)
        if node == 1:  # the mirror image of z_(-1) is z_1
            centre += lower2
        if node == last - 1:
            centre += upper2
        balance.block_lower2[rod, node] = lower2
        balance.block_lower[rod, node] = lower
        balance.block_diagonal[rod, node] = centre
        balance.block_upper[rod, node] = upper
        balance.block_upper2[rod, node] = upper2


@wp.func
def set_identity_rows(rod: int, last: int, balance: Balance):
    """Rows of both ends, where z is zero."""
    for end in range(2):
        node = end * last
        balance.block_lower2[rod, node] = wp.mat22d()
        balance.block_lower[rod, node] = wp.mat22d()
        balance.block_diagonal[rod, node] = identity(real(1.0))
        balance.block_upper[rod, node] = wp.mat22d()
        balance.block_upper2[rod, node] = wp.mat22d()


@wp.func
def is_planar(rod: int, rods: Swimmers, shape: Shape):
    """Whether the rod has no twist and gets none: bent in one plane."""
    if rods.moment[rod] != real(0.0):
        return False
    most = real(0.0)
    for node in range(shape.twist.shape[1]):
        most = wp.max(most, wp.abs(shape.twist[rod, node]))
    return most == real(0.0)


@wp.func
def feels_contact(rod: int, rods: Swimmers, balance: Balance):
    """Whether contact adds drag across the rod, which then is another in each direction."""
    most = real(0.0)
    if rods.forced == 1:
        for node in range(balance.tension.shape[1]):
            D = balance.load.transverse_drag[rod, node]
            most = wp.max(most, D[0, 0] + D[1, 1])
    return most > real(0.0)


@wp.func
def set_free_end_rows(rod: int, last: int, stiffness: real, balance: Balance):
    """End rows of the pentadiagonal system for ``k = k' = 0`` at both free ends; beyond them k is its mirror image."""
    zero = real(0.0)
    set_zero_end_rows(rod, last, balance)
    balance.upper2[rod, 0] = zero
    balance.lower2[rod, last] = zero
    balance.diagonal[rod, 1] += stiffness
    balance.diagonal[rod, last - 1] += stiffness


@wp.func
def solve_block_bending(rod: int, balance: Balance):
    """δk of a rod in space, stored in place of the right-hand side."""
    solve_block_pentadiagonal_rod(
        rod,
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

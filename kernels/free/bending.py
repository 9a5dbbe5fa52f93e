"""The bending of active rods at the end of a step (docs/model.md §2.4).

    (a − J) δk = ∂k/∂t(x*) − Σ d_j k_j                δk = δk' = 0 at the ends
    J z = [i (shear' − i λ* z)/ζ⊥]'' + (u0* z)' − i ω0* z,    shear = i b z' + c τ* z, odd beyond the ends

J is the derivative of ∂k/∂t at constant tension, tangential velocity, twist and roll. It is complex where the rod is
twisted, and couples both bending components. Otherwise it is real, and the same for both.
"""

import warp as wp

from warp_rods.kernels.banded import solve_pentadiagonal_rod
from warp_rods.kernels.complex_banded import solve_complex_pentadiagonal_rod
from warp_rods.kernels.free.rod import bending_rate, set_zero_end_rows
from warp_rods.kernels.free.state import Balance, Shape, Swimmers
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.func
def step_bending(rod: int, rods: Swimmers, star: Shape, slope: Shape, a: real, balance: Balance):
    """From k* to kⁿ⁺¹."""
    set_bending_rows(rod, rods, star, slope, a, balance)
    if is_planar(rod, rods, star):
        solve_bending(rod, balance)
    else:
        set_complex_rows(rod, rods, star, balance)
        solve_complex_bending(rod, balance)
    for node in range(1, star.twist.shape[1] - 1):
        star.bending[rod, node] += balance.rhs_pairs[rod, node]


@wp.func
def set_bending_rows(rod: int, rods: Swimmers, star: Shape, slope: Shape, a: real, balance: Balance):
    """The real part of a − J, ``a + ∂²(b/ζ⊥)∂² − ∂²(λ*/ζ⊥ ·) − ∂(u0* ·)``, and the right-hand side."""
    last = star.twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    square = per_length * per_length
    b = rods.bending_stiffness[rod] * square
    half = real(0.5) * per_length
    u0 = balance.axial_velocity[rod, 0]
    before = square * balance.transverse_mobility[rod, 0]
    here = square * balance.transverse_mobility[rod, 1]
    set_free_end_rows(rod, last, balance)
    for node in range(1, last):
        u0_next = balance.axial_velocity[rod, node]
        after = square * balance.transverse_mobility[rod, node + 1]
        centre = a + b * (real(4.0) * here + (before + after)) + real(2.0) * here * balance.tension[rod, node]
        pull_before = before * balance.tension[rod, node - 1]
        pull_after = after * balance.tension[rod, node + 1]
        balance.lower2[rod, node] = b * before
        balance.lower[rod, node] = real(-2.0) * b * (before + here) - pull_before + half * u0
        balance.diagonal[rod, node] = centre + half * (u0 - u0_next)
        balance.upper[rod, node] = real(-2.0) * b * (here + after) - pull_after - half * u0_next
        balance.upper2[rod, node] = b * after
        rate = bending_rate(rod, node, rods, star.bending[rod, node], balance)
        balance.rhs_pairs[rod, node] = rate - slope.bending[rod, node]
        u0 = u0_next
        before = here
        here = after
    balance.diagonal[rod, 1] += balance.lower2[rod, 1]
    balance.diagonal[rod, last - 1] += balance.upper2[rod, last - 1]


@wp.func
def half_twist(rod: int, half: int, last: int, shape: Shape):
    """τ at a half node; beyond the ends minus that of the last one, as the shear is odd there."""
    if half < 0:
        return real(-0.5) * (shape.twist[rod, 0] + shape.twist[rod, 1])
    if half >= last:
        return real(-0.5) * (shape.twist[rod, last - 1] + shape.twist[rod, last])
    return real(0.5) * (shape.twist[rod, half] + shape.twist[rod, half + 1])


@wp.func
def set_complex_rows(rod: int, rods: Swimmers, star: Shape, balance: Balance):
    """Rows of a − J: the real part, and the imaginary part ``−∂²((c/ζ⊥)(τ* ·)') + ω0*`` in the stencil of the forces.

    With S = τ(z_i + z_(i+1))/2 at half nodes and m = 1/ζ⊥, ∂²(m(τz)') at node i is (m_(i+1) S_(i+3/2) −
    (m_(i+1) + 2m_i) S_(i+1/2) + (2m_i + m_(i−1)) S_(i−1/2) − m_(i−1) S_(i−3/2))/Δs³. Beyond an end S is minus its
    mirror image, whose z are those of the first inner node and the end.
    """
    last = star.twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    scale = real(-0.5) * rods.twist_stiffness[rod] * per_length * per_length * per_length
    two = real(2.0)
    for node in range(last + 1):
        m_before = balance.transverse_mobility[rod, wp.max(node - 1, 0)]
        m = balance.transverse_mobility[rod, node]
        m_after = balance.transverse_mobility[rod, wp.min(node + 1, last)]
        after2 = scale * m_after * half_twist(rod, node + 1, last, star)
        after = scale * (m_after + two * m) * half_twist(rod, node, last, star)
        before = scale * (two * m + m_before) * half_twist(rod, node - 1, last, star)
        before2 = scale * m_before * half_twist(rod, node - 2, last, star)
        centre = before - after + balance.bishop_roll_rate[rod, node]
        inner = real(1.0)
        if node == 0 or node == last:
            inner = real(0.0)
        if node == 1:  # the mirror image of z_(-1) is z_1
            centre -= before2
        if node == last - 1:
            centre += after2
        balance.complex_lower2[rod, node] = wp.vec2d(balance.lower2[rod, node], -inner * before2)
        balance.complex_lower[rod, node] = wp.vec2d(balance.lower[rod, node], inner * (before - before2))
        balance.complex_diagonal[rod, node] = wp.vec2d(balance.diagonal[rod, node], inner * centre)
        balance.complex_upper[rod, node] = wp.vec2d(balance.upper[rod, node], inner * (after2 - after))
        balance.complex_upper2[rod, node] = wp.vec2d(balance.upper2[rod, node], inner * after2)


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
def set_free_end_rows(rod: int, last: int, balance: Balance):
    """End rows of the pentadiagonal system for ``k = k' = 0`` at both free ends; beyond them k is its mirror image."""
    zero = real(0.0)
    set_zero_end_rows(rod, last, balance)
    balance.upper2[rod, 0] = zero
    balance.lower2[rod, last] = zero
    balance.rhs_pairs[rod, 0] = wp.vec2d()
    balance.rhs_pairs[rod, last] = wp.vec2d()


@wp.func
def solve_bending(rod: int, balance: Balance):
    """δk, stored in place of the right-hand side."""
    solve_pentadiagonal_rod(
        rod,
        balance.lower2,
        balance.lower,
        balance.diagonal,
        balance.upper,
        balance.upper2,
        balance.rhs_pairs,
        balance.work_pairs,
        balance.rhs_pairs,
    )


@wp.func
def solve_complex_bending(rod: int, balance: Balance):
    """δk of a twisted rod, stored in place of the right-hand side."""
    solve_complex_pentadiagonal_rod(
        rod,
        balance.complex_lower2,
        balance.complex_lower,
        balance.complex_diagonal,
        balance.complex_upper,
        balance.complex_upper2,
        balance.rhs_pairs,
        balance.work_quadruples,
        balance.rhs_pairs,
    )

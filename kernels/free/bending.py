"""The bending of active rods at the end of a step (docs/model.md §2.4).

    (a − J) δk = ∂k/∂t(x*) − Σ d_j k_j                δk given at ends that are not clamped
    J z = [i (shear' − i λ* z)/ζ⊥]'' + (u0* z)' − i ω0* z,    shear = i (b z)' + m0* z, odd beyond free ends

J is the derivative of ∂k/∂t at constant tension, tangential velocity, twist and roll. It couples both bending
components where the rod is twisted, as a complex number does, or contact adds a drag, as a matrix does. Otherwise it is
the same for both. Each function that forms rows serves all three: a coefficient is Lanes, a Pair or a Block.
"""

from typing import Any

import warp as wp

from warp_rods.kernels.block_banded import solve_block_pentadiagonal_rod
from warp_rods.kernels.free.ends import first_bending, last_bending
from warp_rods.kernels.free.rod import bending_rate, solve_in_place, twisting_moment
from warp_rods.kernels.free.state import CLAMPED, Balance, Shape, Swimmers
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
    for node in range(1, last):
        rate = bending_rate(tile, node, rods, star.bending[tile, node], balance)
        balance.rhs_pairs[tile, node] = rate - slope.bending[tile, node]
    set_end_increments(tile, rods, star, slope, balance)
    equal = where(
        is_untwisted(tile, rods, star), where(feels_contact(tile, rods, balance), Lanes(), Lanes(real(1.0))), Lanes()
    )
    if all_of(equal):
        solve_equal(tile, rods, star, a, balance, balance.rhs_pairs)
    else:
        solve_coupled(tile, rods, star, a, equal, balance)
    for node in range(last + 1):
        star.bending[tile, node] += balance.rhs_pairs[tile, node]


@wp.func
def set_end_increments(tile: int, rods: Swimmers, star: Shape, slope: Shape, balance: Balance):
    """Right-hand sides of both ends: as of inner nodes where they are clamped, otherwise δk."""
    last = star.twist.shape[1] - 1
    if rods.first.kind == CLAMPED:
        rate = bending_rate(tile, 0, rods, star.bending[tile, 0], balance)
        balance.rhs_pairs[tile, 0] = rate - slope.bending[tile, 0]
    else:
        balance.rhs_pairs[tile, 0] = first_bending(tile, rods, balance) - star.bending[tile, 0]
    if rods.last.kind == CLAMPED:
        rate = bending_rate(tile, last, rods, star.bending[tile, last], balance)
        balance.rhs_pairs[tile, last] = rate - slope.bending[tile, last]
    else:
        balance.rhs_pairs[tile, last] = last_bending(tile, rods, balance) - star.bending[tile, last]


@wp.func
def is_untwisted(tile: int, rods: Swimmers, shape: Shape):
    """1 for rods that have no twist, natural twist or moment, 0 for others."""
    most = magnitude(rods.moment[tile]) + Lanes(real(rods.wound))
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
def solve_equal(tile: int, rods: Swimmers, star: Shape, a: Lanes, balance: Balance, rhs: Pairs):
    """δk of rods whose matrix is the same for both components, stored in place of the right-hand side."""
    set_rows(
        tile,
        rods,
        star,
        a,
        balance,
        balance.lower2,
        balance.lower,
        balance.diagonal,
        balance.upper,
        balance.upper2,
    )
    solve_in_place(tile, balance, rhs)


@wp.func
def solve_coupled(tile: int, rods: Swimmers, star: Shape, a: Lanes, equal: Lanes, balance: Balance):
    """δk of any rods; those where ``equal`` is not zero get what ``solve_equal`` finds."""
    nodes = star.twist.shape[1]
    if any_of(equal):
        for node in range(nodes):
            balance.rhs_equal[tile, node] = balance.rhs_pairs[tile, node]
        solve_equal(tile, rods, star, a, balance, balance.rhs_equal)
    if rods.touched == 1:
        solve_in_blocks(tile, rods, star, a, balance)
    else:
        solve_complex(tile, rods, star, a, balance)
    if any_of(equal):
        for node in range(nodes):
            balance.rhs_pairs[tile, node] = where(equal, balance.rhs_equal[tile, node], balance.rhs_pairs[tile, node])


@wp.func
def solve_complex(tile: int, rods: Swimmers, star: Shape, a: Lanes, balance: Balance):
    """δk of twisted rods that feel no contact, stored in place of the right-hand side."""
    set_rows(
        tile,
        rods,
        star,
        a,
        balance,
        balance.complex_lower2,
        balance.complex_lower,
        balance.complex_diagonal,
        balance.complex_upper,
        balance.complex_upper2,
    )
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
def solve_in_blocks(tile: int, rods: Swimmers, star: Shape, a: Lanes, balance: Balance):
    """δk of rods in contact, stored in place of the right-hand side."""
    set_rows(
        tile,
        rods,
        star,
        a,
        balance,
        balance.block_lower2,
        balance.block_lower,
        balance.block_diagonal,
        balance.block_upper,
        balance.block_upper2,
    )
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


# --- Coefficients ---------------------------------------------------------------------------------------------------


@wp.func
def coefficient(across: Block, x: Lanes, y: Lanes, like: Lanes):
    """−i M i (x + iy) of the mobility M ``across``, as a number: M is isotropic and y vanishes."""
    return across[0] * x


@wp.func
def coefficient(across: Block, x: Lanes, y: Lanes, like: Pair):
    """As a complex number: M is isotropic."""
    return across[0] * pair(x, y)


@wp.func
def coefficient(across: Block, x: Lanes, y: Lanes, like: Block):
    """As a matrix."""
    return block(across[3], -across[2], -across[1], across[0]) * block(x, -y, y, x)


@wp.func
def plain(x: Lanes, y: Lanes, like: Lanes):
    """x + iy as a number: y vanishes, or is left to the right-hand side."""
    return x


@wp.func
def plain(x: Lanes, y: Lanes, like: Pair):
    """As a complex number."""
    return pair(x, y)


@wp.func
def plain(x: Lanes, y: Lanes, like: Block):
    """As a matrix."""
    return block(x, -y, y, x)


@wp.func
def velocity_terms(tile: int, node: int, rods: Swimmers, q_before: Lanes, q_after: Lanes, balance: Balance, like: Any):
    """How z at the node before, at this one and at the next moves this one across: factors of −i u⊥.

    u⊥ = i M ((b z)'' − i S' − λ z) with S = m0 z at half nodes; q: m0/2Δs of the half nodes beside this node. Beyond a
    free end S is minus its mirror image, whose z is that of the first inner node, so that its factor is added to that
    of this node.
    """
    last = balance.tension.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    square = per_length * per_length
    before, after = wp.abs(node - 1), last - wp.abs(last - node - 1)
    M = square * balance.transverse_mobility[tile, node]
    b = square * rods.bending_stiffness[tile, node]
    lower = coefficient(M, square * rods.bending_stiffness[tile, before], q_before, like)
    centre = coefficient(M, real(-2.0) * b - balance.tension[tile, node], q_before - q_after, like)
    upper = coefficient(M, square * rods.bending_stiffness[tile, after], -q_after, like)
    if node == 0:
        upper += lower
    if node == last:
        lower += upper
    return lower, centre, upper


@wp.func
def half_moment(tile: int, half: int, rods: Swimmers, star: Shape):
    """m0/2Δs at a half node."""
    total = twisting_moment(tile, half, rods, star.twist) + twisting_moment(tile, half + 1, rods, star.twist)
    return (real(0.25) / rods.spacing) * total


@wp.func
def set_rows(
    tile: int,
    rods: Swimmers,
    star: Shape,
    a: Lanes,
    balance: Balance,
    lower2: Any,
    lower: Any,
    diagonal: Any,
    upper: Any,
    upper2: Any,
):
    """Rows of a − J; ``ω⊥' = (i u⊥' + u0 z)'`` with ω⊥ at half nodes."""
    last = star.twist.shape[1] - 1
    like = none_like(diagonal[tile, 0])
    half = real(0.5) / rods.spacing
    two = real(2.0)
    none = Lanes()
    q_before = half_moment(tile, 0, rods, star)
    q = half_moment(tile, 1, rods, star)
    lower_before, centre_before, upper_before = velocity_terms(tile, 0, rods, -q_before, q_before, balance, like)
    lower_here, centre_here, upper_here = velocity_terms(tile, 1, rods, q_before, q, balance, like)
    u0_next = half * balance.axial_velocity[tile, 0]
    set_end_row(tile, 0, rods.first.kind, a, u0_next, balance, diagonal)
    lower2[tile, 0] = none_like(like)
    lower[tile, 0] = none_like(like)
    upper[tile, 0] = none_like(like)
    upper2[tile, 0] = none_like(like)
    if rods.first.kind == CLAMPED:
        diagonal[tile, 0] += two * lower_here
        upper[tile, 0] = two * centre_here - plain(two * u0_next, none, like)
        upper2[tile, 0] = two * upper_here
    for node in range(1, last):
        q_after = -q
        if node < last - 1:
            q_after = half_moment(tile, node + 1, rods, star)
        lower_after, centre_after, upper_after = velocity_terms(tile, node + 1, rods, q, q_after, balance, like)
        q = q_after
        u0 = u0_next
        u0_next = half * balance.axial_velocity[tile, node]
        lower2[tile, node] = lower_before
        lower[tile, node] = centre_before - two * lower_here + plain(u0, none, like)
        centre = upper_before - two * centre_here + lower_after
        diagonal[tile, node] = centre + plain(a + u0 - u0_next, balance.bishop_roll_rate[tile, node], like)
        upper[tile, node] = centre_after - two * upper_here - plain(u0_next, none, like)
        upper2[tile, node] = upper_after
        lower_before, centre_before, upper_before = lower_here, centre_here, upper_here
        lower_here, centre_here, upper_here = lower_after, centre_after, upper_after
    set_end_row(tile, last, rods.last.kind, a, -u0_next, balance, diagonal)
    lower2[tile, last] = none_like(like)
    lower[tile, last] = none_like(like)
    upper[tile, last] = none_like(like)
    upper2[tile, last] = none_like(like)
    if rods.last.kind == CLAMPED:
        diagonal[tile, last] += two * upper_before
        lower[tile, last] = two * centre_before + plain(two * u0_next, none, like)
        lower2[tile, last] = two * lower_before


@wp.func
def set_end_row(tile: int, node: int, kind: int, a: Lanes, u0: Lanes, balance: Balance, diagonal: Any):
    """The diagonal of an end but for velocities across: 1, or a, ``u0`` and ω0 where it is clamped."""
    like = none_like(diagonal[tile, node])
    diagonal[tile, node] = plain(Lanes(real(1.0)), Lanes(), like)
    if kind == CLAMPED:
        roll = balance.bishop_roll_rate[tile, node]
        diagonal[tile, node] = plain(a - real(2.0) * u0, roll, like)

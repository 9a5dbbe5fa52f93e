"""The twist of active rods at the end of a step (docs/model.md §2.4).

    (a − J) δτ = ∂τ/∂t − Σ d_j τ_j                                            δτ given at ends that are not clamped
    J z = ((c z)'/ζr)' + Re(k̄ [(c z k)'/ζ⊥]') − P z,    P = b Re(k̄ k0 exp(iϑ))/ζr where it is positive

∂τ/∂t is that of the new bending and f; to extrapolate them is unstable. The second term of J is the motion across that
a change of twist causes. It spreads twist, as the first one does, and more than that where |k|² ζr > ζ⊥. P is how
natural bending draws the material back.
"""

import warp as wp

from warp_rods.kernels.free.ends import first_twist, last_twist
from warp_rods.kernels.free.rod import (
    find_transverse_source,
    find_transverse_velocity,
    roll_rate_after,
    solve_in_place,
    twist_rate,
)
from warp_rods.kernels.free.state import CLAMPED, Balance, Shape, Swimmers
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Lanes,
    add,
    any_of,
    div,
    dot,
    larger,
    magnitude,
    mul,
    sub,
    where,
)
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.func
def step_twist(tile: int, rods: Swimmers, star: Shape, slope: Shape, a: Lanes, balance: Balance):
    """From τ* to τⁿ⁺¹, after the bending and f; nothing to do where no twist arises."""
    find_transverse_source(tile, rods, star.bending, star.twist, balance)
    find_transverse_velocity(tile, rods, star.bending, balance)
    if not any_of(may_twist(tile, rods, star)):
        return
    last = star.twist.shape[1] - 1
    balance.rhs[tile, 0] = first_twist(tile, rods) - star.twist[tile, 0]
    balance.rhs[tile, last] = last_twist(tile, rods) - star.twist[tile, last]
    before = Lanes()
    for node in range(last + 1):
        after = Lanes()
        if node < last:
            after = roll_rate_after(tile, node, rods, star, balance)
        if has_twist_rate(node, last, rods):
            rate = twist_rate(tile, node, rods, before, after, balance)
            balance.rhs[tile, node] = rate - slope.twist[tile, node]
        before = after
    most = Lanes()
    for node in range(last + 1):
        most += magnitude(balance.rhs[tile, node])  # NaN counts
    if not any_of(most):
        return
    set_twist_rows(tile, rods, star, a, balance)
    solve_in_place(tile, balance, balance.rhs)
    for node in range(last + 1):
        star.twist[tile, node] += balance.rhs[tile, node]


@wp.func
def has_twist_rate(node: int, last: int, rods: Swimmers) -> bool:
    """Whether the twist of a node follows from its rate: everywhere but at ends that are not clamped."""
    if node == 0:
        return rods.first.kind == CLAMPED
    if node == last:
        return rods.last.kind == CLAMPED
    return True


@wp.func
def may_twist(tile: int, rods: Swimmers, star: Shape):
    """0 for rods that have no twist and get none, as they are bent along one director, and nothing turns them."""
    first, second = Lanes(), Lanes()
    other = magnitude(rods.moment[tile]) + Lanes(real(rods.forced + rods.bent + rods.wound))
    other += magnitude(rods.first.angular_velocity[tile][0]) + magnitude(rods.last.angular_velocity[tile][0])
    other += magnitude(rods.first.couple[tile][0]) + magnitude(rods.last.couple[tile][0])
    for node in range(star.twist.shape[1]):
        k = star.bending[tile, node]
        first = larger(first, magnitude(k[0]))
        second = larger(second, magnitude(k[1]))
        other = larger(other, magnitude(star.twist[tile, node]))
    return where(first, second, Lanes()) + other


@wp.func
def half_bending(tile: int, half: int, shape: Shape):
    """k at a half node."""
    return real(0.5) * (shape.bending[tile, half] + shape.bending[tile, half + 1])


@wp.func
def drawing_back(tile: int, node: int, rods: Swimmers, star: Shape, balance: Balance):
    """P of a node."""
    half_node = wp.min(node, star.twist.shape[1] - 2)
    pull = rods.bending_stiffness[tile, node] * dot(star.bending[tile, node], balance.rest[tile, node])
    return rods.rotational_mobility[tile, half_node] * larger(pull, Lanes())


@wp.func
def set_twist_rows(tile: int, rods: Swimmers, star: Shape, a: Lanes, balance: Balance):
    """Rows of a − J, as factors of y = c z first.

    Re(k̄ [(y k)'/ζ⊥]') at a half node j is (A_j y_(j+1) − B_j y_j + A_(j−1) y_(j−1))/Δs² with the means y_j of both
    nodes, A_j = k_j·m_(j+1) k_(j+1), B_j = k_j·(m_j + m_(j+1)) k_j and m = 1/ζ⊥ of the nodes j and j + 1 beside it. The
    shear is odd beyond free ends, which doubles m there. At a node it is the mean of both half nodes.
    """
    last = star.twist.shape[1] - 1
    two = real(2.0)
    square = real(1.0) / (rods.spacing * rods.spacing)
    g = real(0.25) * square
    k = half_bending(tile, 0, star)
    m_k = balance.transverse_mobility[tile, 1] * k
    A_before = Lanes()
    B = dot(k, two * (balance.transverse_mobility[tile, 0] * k) + m_k)
    k_after = half_bending(tile, 1, star)
    A = dot(m_k, k_after)
    spread = square * rods.rotational_mobility[tile, 0]
    near = two * (g * (B - A) - spread)
    set_end_row(tile, 0, 1, rods.first.kind, rods, star, a, two * (g * B + spread), near, -two * (g * A), balance)
    for node in range(1, last):
        A_before2 = A_before
        A_before = A
        B_before = B
        spread_before = spread
        k = k_after
        m_k = balance.transverse_mobility[tile, node + 1] * k
        spread = square * rods.rotational_mobility[tile, node]
        A = Lanes()
        if node < last - 1:
            k_after = half_bending(tile, node + 1, star)
            A = dot(m_k, k_after)
        else:
            m_k = two * m_k
        B = dot(k, balance.transverse_mobility[tile, node] * k + m_k)
        c = rods.twist_stiffness[tile, node]
        centre = c * (g * (B_before + B - two * A_before) + spread_before + spread) + a
        if rods.bent == 1:
            centre += drawing_back(tile, node, rods, star, balance)
        lower = g * (B_before - A_before2 - A_before) - spread_before
        upper = g * (B - A_before - A) - spread
        balance.lower2[tile, node] = rods.twist_stiffness[tile, wp.max(node - 2, 0)] * (-g * A_before2)
        balance.lower[tile, node] = rods.twist_stiffness[tile, node - 1] * lower
        balance.diagonal[tile, node] = centre
        balance.upper[tile, node] = rods.twist_stiffness[tile, node + 1] * upper
        balance.upper2[tile, node] = rods.twist_stiffness[tile, wp.min(node + 2, last)] * (-g * A)
    near_last = two * (g * (B - A_before) - spread)
    centre_last = two * (g * B + spread)
    set_end_row(tile, last, -1, rods.last.kind, rods, star, a, centre_last, near_last, -two * (g * A_before), balance)


@wp.func
def set_end_row(
    tile: int,
    node: int,
    inward: int,
    kind: int,
    rods: Swimmers,
    star: Shape,
    a: Lanes,
    centre: Lanes,
    near: Lanes,
    next: Lanes,
    balance: Balance,
):
    """The row of an end from factors of y there and at the next two nodes inwards; δτ itself if it is not clamped."""
    balance.lower2[tile, node] = Lanes()
    balance.lower[tile, node] = Lanes()
    balance.diagonal[tile, node] = Lanes(real(1.0))
    balance.upper[tile, node] = Lanes()
    balance.upper2[tile, node] = Lanes()
    if kind == CLAMPED:
        drawn = drawing_back(tile, node, rods, star, balance)
        balance.diagonal[tile, node] = rods.twist_stiffness[tile, node] * centre + a + drawn
        near_term = rods.twist_stiffness[tile, node + inward] * near
        next_term = rods.twist_stiffness[tile, node + 2 * inward] * next
        if inward > 0:
            balance.upper[tile, node] = near_term
            balance.upper2[tile, node] = next_term
        else:
            balance.lower[tile, node] = near_term
            balance.lower2[tile, node] = next_term

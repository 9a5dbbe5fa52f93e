"""The twist of active rods at the end of a step (docs/model.md §2.4).

    (a − J) δτ = ∂τ/∂t − Σ d_j τ_j,    J z = (c/ηr) z'' + Re(k̄ [(c z k)'/ζ⊥]')        δτ = 0 at the ends

∂τ/∂t is that of the new bending and f; to extrapolate them is unstable. The last term of J is the motion across that a
change of twist causes. It spreads twist, as the first one does, and more than that where |k|² ηr > ζ⊥.
"""

import warp as wp

from warp_rods.kernels.free.rod import (
    find_transverse_source,
    find_transverse_velocity,
    roll_rate_after,
    set_zero_end_rows,
    solve_in_place,
)
from warp_rods.kernels.free.state import Balance, Shape, Swimmers
from warp_rods.kernels.lanes import Lanes, add, any_of, div, dot, larger, magnitude, mul, sub, where  # noqa: F401 (operators)
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
    most = Lanes()
    roll_rate = roll_rate_after(tile, 0, rods, star)
    for node in range(1, last):
        roll_rate_next = roll_rate_after(tile, node, rods, star)
        source = real(0.5) * (balance.twist_source[tile, node - 1] + balance.twist_source[tile, node])
        rhs = (roll_rate_next - roll_rate) / rods.spacing + source - slope.twist[tile, node]
        balance.rhs[tile, node] = rhs
        most += magnitude(rhs)  # NaN counts
        roll_rate = roll_rate_next
    if not any_of(most):
        return
    set_twist_rows(tile, rods, star, a, balance)
    solve_in_place(tile, balance, balance.rhs)
    for node in range(1, last):
        star.twist[tile, node] += balance.rhs[tile, node]


@wp.func
def may_twist(tile: int, rods: Swimmers, star: Shape):
    """0 for rods that have no twist and get none, as they are free, bent along one director, and without moment."""
    first, second, other = Lanes(), Lanes(), magnitude(rods.moment[tile]) + Lanes(real(rods.forced))
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
def set_twist_rows(tile: int, rods: Swimmers, star: Shape, a: Lanes, balance: Balance):
    """Rows of a − J.

    Re(k̄ [(c z k)'/ζ⊥]') at a half node j is c (A_j z_(j+1) − B_j z_j + A_(j−1) z_(j−1))/Δs² with the means z_j of both
    nodes, A_j = k_j·m_(j+1) k_(j+1), B_j = k_j·(m_j + m_(j+1)) k_j and m = 1/ζ⊥ of the nodes j and j + 1 beside it. The
    shear is odd beyond the ends, which doubles m there. At a node it is the mean of both half nodes.
    """
    last = star.twist.shape[1] - 1
    two = real(2.0)
    c = rods.twist_stiffness[tile] / (rods.spacing * rods.spacing)
    diffusion = c / rods.rotational_drag[tile]
    g = real(0.25) * c
    k = half_bending(tile, 0, star)
    m_k = balance.transverse_mobility[tile, 1] * k
    A_before = Lanes()
    B = dot(k, two * (balance.transverse_mobility[tile, 0] * k) + m_k)
    k_after = half_bending(tile, 1, star)
    A = dot(m_k, k_after)
    set_zero_end_rows(tile, last, balance)
    balance.upper2[tile, 0] = Lanes()
    balance.lower2[tile, last] = Lanes()
    for node in range(1, last):
        A_before2 = A_before
        A_before = A
        B_before = B
        k = k_after
        m_k = balance.transverse_mobility[tile, node + 1] * k
        A = Lanes()
        if node < last - 1:
            k_after = half_bending(tile, node + 1, star)
            A = dot(m_k, k_after)
        else:
            m_k = two * m_k
        B = dot(k, balance.transverse_mobility[tile, node] * k + m_k)
        balance.lower2[tile, node] = -g * A_before2
        balance.lower[tile, node] = g * (B_before - A_before2 - A_before) - diffusion
        balance.diagonal[tile, node] = a + two * diffusion + g * (B_before + B - two * A_before)
        balance.upper[tile, node] = g * (B - A_before - A) - diffusion
        balance.upper2[tile, node] = -g * A

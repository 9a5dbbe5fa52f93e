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
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.func
def step_twist(rod: int, rods: Swimmers, star: Shape, slope: Shape, a: real, balance: Balance):
    """From τ* to τⁿ⁺¹, after the bending and f; nothing to do where no twist arises."""
    find_transverse_source(rod, rods, star.bending, star.twist, balance)
    find_transverse_velocity(rod, rods, star.bending, balance)
    last = star.twist.shape[1] - 1
    most = real(0.0)
    roll_rate = roll_rate_after(rod, 0, rods, star)
    for node in range(1, last):
        roll_rate_next = roll_rate_after(rod, node, rods, star)
        source = real(0.5) * (balance.twist_source[rod, node - 1] + balance.twist_source[rod, node])
        rhs = (roll_rate_next - roll_rate) / rods.spacing + source - slope.twist[rod, node]
        balance.rhs[rod, node] = rhs
        most = wp.max(most, wp.abs(rhs))
        roll_rate = roll_rate_next
    if most == real(0.0):
        return
    set_twist_rows(rod, rods, star, a, balance)
    solve_in_place(rod, balance, balance.rhs)
    for node in range(1, last):
        star.twist[rod, node] += balance.rhs[rod, node]


@wp.func
def half_bending(rod: int, half: int, shape: Shape):
    """k at a half node."""
    return real(0.5) * (shape.bending[rod, half] + shape.bending[rod, half + 1])


@wp.func
def set_twist_rows(rod: int, rods: Swimmers, star: Shape, a: real, balance: Balance):
    """Rows of a − J.

    Re(k̄ [(c z k)'/ζ⊥]') at a half node j is c (A_j z_(j+1) − B_j z_j + A_(j−1) z_(j−1))/Δs² with the means z_j of both
    nodes, A_j = k_j·m_(j+1) k_(j+1), B_j = k_j·(m_j + m_(j+1)) k_j and m = 1/ζ⊥ of the nodes j and j + 1 beside it. The
    shear is odd beyond the ends, which doubles m there. At a node it is the mean of both half nodes.
    """
    last = star.twist.shape[1] - 1
    two = real(2.0)
    c = rods.twist_stiffness[rod] / (rods.spacing * rods.spacing)
    diffusion = c / rods.rotational_drag[rod]
    g = real(0.25) * c
    k = half_bending(rod, 0, star)
    m_k = balance.transverse_mobility[rod, 1] * k
    A_before = real(0.0)
    B = wp.dot(k, two * (balance.transverse_mobility[rod, 0] * k) + m_k)
    k_after = half_bending(rod, 1, star)
    A = wp.dot(m_k, k_after)
    set_zero_end_rows(rod, last, balance)
    balance.upper2[rod, 0] = real(0.0)
    balance.lower2[rod, last] = real(0.0)
    for node in range(1, last):
        A_before2 = A_before
        A_before = A
        B_before = B
        k = k_after
        m_k = balance.transverse_mobility[rod, node + 1] * k
        A = real(0.0)
        if node < last - 1:
            k_after = half_bending(rod, node + 1, star)
            A = wp.dot(m_k, k_after)
        else:
            m_k = two * m_k
        B = wp.dot(k, balance.transverse_mobility[rod, node] * k + m_k)
        balance.lower2[rod, node] = -g * A_before2
        balance.lower[rod, node] = g * (B_before - A_before2 - A_before) - diffusion
        balance.diagonal[rod, node] = a + two * diffusion + g * (B_before + B - two * A_before)
        balance.upper[rod, node] = g * (B - A_before - A) - diffusion
        balance.upper2[rod, node] = -g * A

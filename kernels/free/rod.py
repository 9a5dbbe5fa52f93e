"""The active Kirchhoff rod in its twist-free (Bishop) frame: velocities and rates of a shape (docs/model.md §2.3).

Bending ``k = Ω[1] + i Ω[2]`` is stored as a pair; ``times_i`` multiplies it by i. Fields are those of a tile of rods
(``lanes.py``). The grid is staggered: ``k, τ, f, λ, u⊥, m⊥`` live at nodes; ``Λ⊥, u0, ω⊥, ω0`` live at half nodes and
are stored at the node before. Beyond free ends ``Λ⊥`` is odd, and ``u0`` and ``f`` are even, so that the energy law
dE/dt = power − dissipation holds to round-off. What holds an end is in ``ends.py``.

Functions of one tile loop over its nodes and store their results in ``Balance``. On the CPU its arrays hold a single
row that all tiles share, so one thread must complete the whole step of a tile.
"""

from typing import Any

import warp as wp

from warp_rods.kernels.banded import solve_pentadiagonal_rod, solve_tridiagonal_rod
from warp_rods.kernels.free.ends import hold_across, hold_mobilities, set_end_tensions
from warp_rods.kernels.free.flagella import reaction
from warp_rods.kernels.free.state import Balance, End, Shape, Swimmers
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Lanes,
    Lanes2D,
    Pair,
    Pairs,
    add,
    block,
    div,
    dot,
    inverse,
    mul,
    pair,
    sub,
    times_i,
    wedge,
)
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.func
def bending_moment(tile: int, node: int, rods: Swimmers, bending: Pairs, balance: Balance):
    """``m⊥ = b (k − k0 exp(iϑ))``."""
    return rods.bending_stiffness[tile, node] * (bending[tile, node] - balance.rest[tile, node])


@wp.func
def twisting_moment(tile: int, node: int, rods: Swimmers, twist: Lanes2D):
    """``m0 = c (τ − τ0)``."""
    return rods.twist_stiffness[tile, node] * (twist[tile, node] - rods.natural_twist[tile, node])


@wp.func
def find_mobilities(tile: int, rods: Swimmers, balance: Balance):
    """The inverse of the drag along at half nodes and across at nodes, that of contact included; 0 at held ends."""
    one, zero = real(1.0), Lanes()
    for node in range(balance.tension.shape[1]):
        eta = rods.drag_across[tile, node]
        balance.axial_mobility[tile, node] = one / (rods.drag_along[tile, node] + balance.load.axial_drag[tile, node])
        D = balance.load.transverse_drag[tile, node]
        balance.transverse_mobility[tile, node] = inverse(D + block(eta, zero, zero, eta))
    hold_mobilities(tile, rods, balance)


@wp.func
def find_transverse_source(tile: int, rods: Swimmers, bending: Pairs, twist: Lanes2D, balance: Balance):
    """``source⊥ = (Λ⊥' + f_ext⊥)/ζ⊥`` at nodes, with ``Λ⊥ = i (m⊥' + µ⊥) + m0 k`` at half nodes.

    It is odd beyond free ends; source⊥ of held ends is their velocity. Stores ``m⊥' + µ⊥``, too.
    """
    last = twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    quarter = real(0.25)
    shear_before = Pair()
    k = bending[tile, 0]
    m = bending_moment(tile, 0, rods, bending, balance)
    m0 = quarter * twisting_moment(tile, 0, rods, twist)
    for node in range(last):
        k_next = bending[tile, node + 1]
        m_next = bending_moment(tile, node + 1, rods, bending, balance)
        m0_next = quarter * twisting_moment(tile, node + 1, rods, twist)
        slope = per_length * (m_next - m) + balance.load.transverse_couple[tile, node]
        balance.moment_slope[tile, node] = slope
        shear = times_i(slope) + (m0 + m0_next) * (k + k_next)
        if node == 0:
            shear_before = -shear
        force = per_length * (shear - shear_before) + balance.load.transverse_force[tile, node]
        balance.transverse_source[tile, node] = balance.transverse_mobility[tile, node] * force
        shear_before = shear
        k = k_next
        m = m_next
        m0 = m0_next
    force = real(-2.0) * per_length * shear_before + balance.load.transverse_force[tile, last]
    balance.transverse_source[tile, last] = balance.transverse_mobility[tile, last] * force
    hold_across(tile, rods, balance)


@wp.func
def find_axial_source(tile: int, rods: Swimmers, shape: Shape, balance: Balance):
    """``source0 = (Re(k̄ (m⊥' + µ⊥)) + f + f_ext0)/ζ∥`` at half nodes, after ``find_transverse_source``."""
    half = real(0.5)
    k = shape.bending[tile, 0]
    f = shape.activity[tile, 0]
    for node in range(shape.twist.shape[1] - 1):
        k_next = shape.bending[tile, node + 1]
        f_next = shape.activity[tile, node + 1]
        along = dot(k + k_next, balance.moment_slope[tile, node])
        force = half * (along + f + f_next) + balance.load.axial_force[tile, node]
        balance.axial_source[tile, node] = balance.axial_mobility[tile, node] * force
        k = k_next
        f = f_next


@wp.func
def solve_tension(tile: int, rods: Swimmers, shape: Shape, balance: Balance):
    """λ from inextensibility: ``−(λ'/ζ∥)' + |k|² λ/ζ⊥ = source0' + Im(k̄ source⊥)`` (4.24), and its end rows."""
    last = shape.twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    source = balance.axial_source[tile, 0]
    before = -per_length * per_length * balance.axial_mobility[tile, 0]
    for node in range(1, last):
        k = shape.bending[tile, node]
        source_next = balance.axial_source[tile, node]
        across = times_i(k)
        transverse = dot(across, balance.transverse_source[tile, node])
        after = -per_length * per_length * balance.axial_mobility[tile, node]
        balance.lower[tile, node] = before
        balance.upper[tile, node] = after
        balance.diagonal[tile, node] = dot(across, balance.transverse_mobility[tile, node] * across) - (before + after)
        balance.rhs[tile, node] = per_length * (source_next - source) + transverse
        source = source_next
        before = after
    set_end_tensions(tile, rods, shape, balance)
    solve_tridiagonal_rod(
        tile, balance.lower, balance.diagonal, balance.upper, balance.rhs, balance.work, balance.tension
    )


@wp.func
def solve_in_place(tile: int, balance: Balance, rhs: Any):
    """The solution of the pentadiagonal system, stored in place of its right-hand side."""
    solve_pentadiagonal_rod(
        tile,
        balance.lower2,
        balance.lower,
        balance.diagonal,
        balance.upper,
        balance.upper2,
        rhs,
        balance.work_pairs,
        rhs,
    )


@wp.func
def find_axial_velocity(tile: int, rods: Swimmers, balance: Balance):
    """``u0 = λ'/ζ∥ + source0`` at half nodes."""
    per_length = real(1.0) / rods.spacing
    for node in range(balance.tension.shape[1] - 1):
        slope = per_length * (balance.tension[tile, node + 1] - balance.tension[tile, node])
        mobility = balance.axial_mobility[tile, node]
        balance.axial_velocity[tile, node] = mobility * slope + balance.axial_source[tile, node]


@wp.func
def find_transverse_velocity(tile: int, rods: Swimmers, bending: Pairs, balance: Balance):
    """``u⊥ = source⊥ − i λ k/ζ⊥`` at nodes, then ``ω⊥ = i u⊥' + u0 k`` and ``Im(k̄ ω⊥)`` at half nodes."""
    per_length = real(1.0) / rods.spacing
    k = bending[tile, 0]
    u = balance.transverse_source[tile, 0] - balance.transverse_mobility[tile, 0] * (
        balance.tension[tile, 0] * times_i(k)
    )
    balance.transverse_velocity[tile, 0] = u
    for node in range(balance.tension.shape[1] - 1):
        k_next = bending[tile, node + 1]
        pull = balance.transverse_mobility[tile, node + 1] * (balance.tension[tile, node + 1] * times_i(k_next))
        u_next = balance.transverse_source[tile, node + 1] - pull
        k_half = real(0.5) * (k + k_next)
        omega = per_length * times_i(u_next - u) + balance.axial_velocity[tile, node] * k_half
        balance.transverse_velocity[tile, node + 1] = u_next
        balance.angular_velocity[tile, node] = omega
        balance.twist_source[tile, node] = wedge(k_half, omega)
        k = k_next
        u = u_next


@wp.func
def bishop_roll_after(tile: int, node: int, rods: Swimmers, balance: Balance):
    """``−∫ Im(k̄ ω⊥) ds`` from a node to the next.

    With natural bending the energy law demands that the material angle ϑ, a sum of τ at nodes, turns as the frames do:
    the mean of the sources of twist at both nodes, each the mean of those at its half nodes (``twist_rate``), and even
    beyond the ends.
    """
    here = balance.twist_source[tile, node]
    if rods.bent == 0:
        return rods.spacing * here
    last = balance.tension.shape[1] - 1
    before = balance.twist_source[tile, wp.max(node - 1, 0)]
    after = balance.twist_source[tile, wp.min(node + 1, last - 1)]
    return rods.spacing * (real(0.25) * (before + after) + real(0.5) * here)


@wp.func
def integrate_bishop_roll(tile: int, rods: Swimmers, balance: Balance):
    """``ω0' = −Im(k̄ ω⊥)`` of the Bishop frame, integrated outwards from the tracked node, where ω0 = 0 (gauge)."""
    nodes = balance.twist_source.shape[1]
    total = Lanes()
    balance.bishop_roll_rate[tile, rods.tracked] = total
    for node in range(rods.tracked, nodes - 1):
        total -= bishop_roll_after(tile, node, rods, balance)
        balance.bishop_roll_rate[tile, node + 1] = total
    total = Lanes()
    for back in range(rods.tracked):
        node = rods.tracked - 1 - back
        total += bishop_roll_after(tile, node, rods, balance)
        balance.bishop_roll_rate[tile, node] = total


@wp.func
def solve_balance(tile: int, rods: Swimmers, shape: Shape, balance: Balance):
    """Tension and velocities of rods from the balances of forces and moments (4.16), (4.17), at constant length."""
    find_mobilities(tile, rods, balance)
    find_transverse_source(tile, rods, shape.bending, shape.twist, balance)
    find_axial_source(tile, rods, shape, balance)
    solve_tension(tile, rods, shape, balance)
    find_axial_velocity(tile, rods, balance)
    find_transverse_velocity(tile, rods, shape.bending, balance)
    integrate_bishop_roll(tile, rods, balance)


@wp.func
def axial_velocity_at_node(tile: int, node: int, balance: Balance):
    """u0 at a node; even beyond the ends, where ``u0' = −Im(k̄ u⊥) = 0``."""
    last = balance.axial_velocity.shape[1] - 1
    before = balance.axial_velocity[tile, wp.max(node - 1, 0)]
    return real(0.5) * (before + balance.axial_velocity[tile, wp.min(node, last - 1)])


@wp.func
def roll_rate_after(tile: int, node: int, rods: Swimmers, shape: Shape, balance: Balance):
    """``ω0 = (m0' + Im(k̄ m⊥) + M f + µ0)/ζr`` of the material at the half node after ``node`` (4.21)."""
    half = real(0.5)
    here, there = twisting_moment(tile, node, rods, shape.twist), twisting_moment(tile, node + 1, rods, shape.twist)
    f = half * (shape.activity[tile, node] + shape.activity[tile, node + 1])
    couple = (real(1.0) / rods.spacing) * (there - here) + rods.moment[tile] * f + balance.load.axial_couple[tile, node]
    if rods.bent == 1:
        turning = wedge(shape.bending[tile, node], bending_moment(tile, node, rods, shape.bending, balance))
        after = wedge(shape.bending[tile, node + 1], bending_moment(tile, node + 1, rods, shape.bending, balance))
        couple += half * (turning + after)
    return rods.rotational_mobility[tile, node] * couple


@wp.func
def roll_rate_at_end(tile: int, half: int, side: real, rods: Swimmers, shape: Shape, balance: Balance):
    """ω0 at an end that is not clamped, where τ is given: that of the half node beside it, and −Im(k̄ ω⊥) from there.

    side: 1 at the last end, −1 at the first.
    """
    beyond = (side * real(0.5) * rods.spacing) * balance.twist_source[tile, half]
    return roll_rate_after(tile, half, rods, shape, balance) - beyond


@wp.func
def turning_across(tile: int, end: End):
    """ω⊥ of a clamped end."""
    w = end.angular_velocity[tile]
    return pair(w[1], w[2])


@wp.func
def bending_rate(tile: int, node: int, rods: Swimmers, k: Pair, balance: Balance):
    """``∂k/∂t = ω⊥' − i ω0 k`` (4.10) at an inner node, or at a clamped end, whose cell is half as long."""
    per_length = real(1.0) / rods.spacing
    rotation = balance.bishop_roll_rate[tile, node] * times_i(k)
    if node == 0:
        slope = (real(2.0) * per_length) * (balance.angular_velocity[tile, 0] - turning_across(tile, rods.first))
        return slope - rotation
    before = balance.angular_velocity[tile, node - 1]
    if node == balance.tension.shape[1] - 1:
        return (real(2.0) * per_length) * (turning_across(tile, rods.last) - before) - rotation
    return per_length * (balance.angular_velocity[tile, node] - before) - rotation


@wp.func
def twist_rate(tile: int, node: int, rods: Swimmers, before: Lanes, after: Lanes, balance: Balance):
    """``∂τ/∂t = ω0' + Im(k̄ ω⊥)`` at an inner node, or at a clamped end, from ω0 of the half nodes beside it."""
    per_length = real(1.0) / rods.spacing
    if node == 0:
        slope = real(2.0) * per_length * (after - rods.first.angular_velocity[tile][0])
        return slope + balance.twist_source[tile, 0]
    if node == balance.tension.shape[1] - 1:
        slope = real(2.0) * per_length * (rods.last.angular_velocity[tile][0] - before)
        return slope + balance.twist_source[tile, node - 1]
    source = real(0.5) * (balance.twist_source[tile, node - 1] + balance.twist_source[tile, node])
    return per_length * (after - before) + source


@wp.func
def activity_diffusion(tile: int, node: int, rods: Swimmers, activity: Lanes2D):
    """``D f''``, with ``f' = 0`` at the ends."""
    last = activity.shape[1] - 1
    left = activity[tile, wp.abs(node - 1)]
    right = activity[tile, last - wp.abs(last - node - 1)]
    scale = rods.diffusion[tile] / (rods.spacing * rods.spacing)
    return scale * (left - real(2.0) * activity[tile, node] + right)


@wp.func
def axial_stream_at_node(tile: int, node: int, balance: Balance):
    """The flow along the rod at a node, as ``axial_velocity_at_node``."""
    last = balance.axial_velocity.shape[1] - 1
    before = balance.load.axial_stream[tile, wp.max(node - 1, 0)]
    return real(0.5) * (before + balance.load.axial_stream[tile, wp.min(node, last - 1)])


@wp.func
def activity_terms(tile: int, node: int, rods: Swimmers, shape: Shape, balance: Balance):
    """``τf ∂f/∂t = source − sink f + D f''`` at a node (4.12), and the sink; u0 is relative to the flow."""
    f = shape.activity[tile, node]
    u0 = axial_velocity_at_node(tile, node, balance)
    if rods.flowing == 1:
        u0 -= axial_stream_at_node(tile, node, balance)
    s = real(node) * rods.spacing - real(0.5)
    source, sink = reaction(rods.law, s, f, u0, rods.law_parameters[tile])
    return source - sink * f + activity_diffusion(tile, node, rods, shape.activity), sink

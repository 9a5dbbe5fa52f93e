"""The active Kirchhoff rod in its twist-free (Bishop) frame: velocities and rates of a shape (docs/model.md §2.3).

Bending ``k = Ω[1] + i Ω[2]`` is stored as a pair; ``times_i`` multiplies it by i. The grid is staggered: ``k, τ, f, λ,
u⊥`` live at nodes; ``Λ⊥, u0, ω⊥, ω0`` live at half nodes and are stored at the node before. Beyond the free ends ``Λ⊥``
is odd, and ``u0`` and ``f`` are even, so that the energy law dE/dt = power − dissipation holds to round-off.

Functions of one rod loop over its nodes and store their results in ``Balance``. On the CPU its arrays hold a single
row that all rods share, so one thread must complete the whole step of a rod.
"""

from typing import Any

import warp as wp

from warp_rods.kernels.banded import solve_pentadiagonal_rod, solve_tridiagonal_rod
from warp_rods.kernels.block_banded import inverse
from warp_rods.kernels.free.flagella import reaction
from warp_rods.kernels.free.state import Balance, Shape, Swimmers
from warp_rods.kernels.layout import Pairs2D, Scalars2D, real

wp.set_module_options({"enable_backward": False})


@wp.func
def times_i(z: wp.vec2d):
    """i z, which is e0 × z."""
    return wp.vec2d(-z[1], z[0])


@wp.func
def wedge(a: wp.vec2d, b: wp.vec2d):
    """Im(ā b), which is e0·(a × b)."""
    return a[0] * b[1] - a[1] * b[0]


@wp.func
def find_mobilities(rod: int, rods: Swimmers, balance: Balance):
    """The inverse of the drag along at half nodes and across at nodes, that of contact included."""
    one, zero = real(1.0), real(0.0)
    eta = rods.drag_ratio[rod]
    for node in range(balance.tension.shape[1]):
        balance.axial_mobility[rod, node] = one / (one + balance.load.axial_drag[rod, node])
        D = balance.load.transverse_drag[rod, node]
        balance.transverse_mobility[rod, node] = inverse(D + wp.mat22d(eta, zero, zero, eta))


@wp.func
def find_transverse_source(rod: int, rods: Swimmers, bending: Pairs2D, twist: Scalars2D, balance: Balance):
    """``source⊥ = (Λ⊥' + f_ext⊥)/ζ⊥`` at nodes, with ``Λ⊥ = i b k' + c τ k`` at half nodes, odd beyond the ends."""
    last = twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    b = rods.bending_stiffness[rod] * per_length
    c = rods.twist_stiffness[rod] * real(0.25)
    shear_before = wp.vec2d()
    k = bending[rod, 0]
    tau = twist[rod, 0]
    for node in range(last):
        k_next = bending[rod, node + 1]
        tau_next = twist[rod, node + 1]
        shear = b * times_i(k_next - k) + (c * (tau + tau_next)) * (k + k_next)
        if node == 0:
            shear_before = -shear
        force = per_length * (shear - shear_before) + balance.load.transverse_force[rod, node]
        balance.transverse_source[rod, node] = balance.transverse_mobility[rod, node] * force
        shear_before = shear
        k = k_next
        tau = tau_next
    force = real(-2.0) * per_length * shear_before + balance.load.transverse_force[rod, last]
    balance.transverse_source[rod, last] = balance.transverse_mobility[rod, last] * force


@wp.func
def find_axial_source(rod: int, rods: Swimmers, shape: Shape, balance: Balance):
    """``source0 = ((b/2)(|k|²)' + f + f_ext0)/ζ∥`` at half nodes."""
    half = real(0.5)
    b = half * rods.bending_stiffness[rod] / rods.spacing
    k = shape.bending[rod, 0]
    square = wp.dot(k, k)
    f = shape.activity[rod, 0]
    for node in range(shape.twist.shape[1] - 1):
        k = shape.bending[rod, node + 1]
        square_next = wp.dot(k, k)
        f_next = shape.activity[rod, node + 1]
        force = b * (square_next - square) + half * (f + f_next) + balance.load.axial_force[rod, node]
        balance.axial_source[rod, node] = balance.axial_mobility[rod, node] * force
        square = square_next
        f = f_next


@wp.func
def solve_tension(rod: int, rods: Swimmers, shape: Shape, balance: Balance):
    """λ from inextensibility: ``−(λ'/ζ∥)' + |k|² λ/ζ⊥ = source0' + Im(k̄ source⊥)``, ``λ = 0`` at the ends (4.24)."""
    last = shape.twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    source = balance.axial_source[rod, 0]
    before = -per_length * per_length * balance.axial_mobility[rod, 0]
    for node in range(1, last):
        k = shape.bending[rod, node]
        source_next = balance.axial_source[rod, node]
        across = times_i(k)
        transverse = wp.dot(across, balance.transverse_source[rod, node])
        after = -per_length * per_length * balance.axial_mobility[rod, node]
        balance.lower[rod, node] = before
        balance.upper[rod, node] = after
        balance.diagonal[rod, node] = wp.dot(across, balance.transverse_mobility[rod, node] * across) - (before + after)
        balance.rhs[rod, node] = per_length * (source_next - source) + transverse
        source = source_next
        before = after
    set_zero_end_rows(rod, last, balance)
    solve_tridiagonal_rod(
        rod, balance.lower, balance.diagonal, balance.upper, balance.rhs, balance.work, balance.tension
    )


@wp.func
def solve_in_place(rod: int, balance: Balance, rhs: Any):
    """The solution of the pentadiagonal system, stored in place of its right-hand side."""
    solve_pentadiagonal_rod(
        rod,
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
def set_zero_end_rows(rod: int, last: int, balance: Balance):
    """End rows of a tridiagonal system whose solution vanishes at both ends."""
    zero = real(0.0)
    balance.upper[rod, 0] = zero
    balance.lower[rod, last] = zero
    balance.diagonal[rod, 0] = real(1.0)
    balance.diagonal[rod, last] = real(1.0)
    balance.rhs[rod, 0] = zero
    balance.rhs[rod, last] = zero


@wp.func
def find_axial_velocity(rod: int, rods: Swimmers, balance: Balance):
    """``u0 = λ'/ζ∥ + source0`` at half nodes."""
    per_length = real(1.0) / rods.spacing
    for node in range(balance.tension.shape[1] - 1):
        slope = per_length * (balance.tension[rod, node + 1] - balance.tension[rod, node])
        mobility = balance.axial_mobility[rod, node]
        balance.axial_velocity[rod, node] = mobility * slope + balance.axial_source[rod, node]


@wp.func
def find_transverse_velocity(rod: int, rods: Swimmers, bending: Pairs2D, balance: Balance):
    """``u⊥ = source⊥ − i λ k/ζ⊥`` at nodes, then ``ω⊥ = i u⊥' + u0 k`` and ``Im(k̄ ω⊥)`` at half nodes."""
    per_length = real(1.0) / rods.spacing
    k = bending[rod, 0]
    u = balance.transverse_source[rod, 0] - balance.transverse_mobility[rod, 0] * (balance.tension[rod, 0] * times_i(k))
    balance.transverse_velocity[rod, 0] = u
    for node in range(balance.tension.shape[1] - 1):
        k_next = bending[rod, node + 1]
        pull = balance.transverse_mobility[rod, node + 1] * (balance.tension[rod, node + 1] * times_i(k_next))
        u_next = balance.transverse_source[rod, node + 1] - pull
        k_half = real(0.5) * (k + k_next)
        omega = per_length * times_i(u_next - u) + balance.axial_velocity[rod, node] * k_half
        balance.transverse_velocity[rod, node + 1] = u_next
        balance.angular_velocity[rod, node] = omega
        balance.twist_source[rod, node] = wedge(k_half, omega)
        k = k_next
        u = u_next


@wp.func
def integrate_bishop_roll(rod: int, rods: Swimmers, balance: Balance):
    """``ω0' = −Im(k̄ ω⊥)`` of the Bishop frame, integrated outwards from the middle node, where ω0 = 0 (gauge)."""
    nodes = balance.twist_source.shape[1]
    middle = nodes // 2
    total = real(0.0)
    balance.bishop_roll_rate[rod, middle] = total
    for node in range(middle, nodes - 1):
        total -= rods.spacing * balance.twist_source[rod, node]
        balance.bishop_roll_rate[rod, node + 1] = total
    total = real(0.0)
    for back in range(middle):
        node = middle - 1 - back
        total += rods.spacing * balance.twist_source[rod, node]
        balance.bishop_roll_rate[rod, node] = total


@wp.func
def solve_balance(rod: int, rods: Swimmers, shape: Shape, balance: Balance):
    """Tension and velocities of one rod from the balances of forces and moments (4.16), (4.17), at constant length."""
    find_mobilities(rod, rods, balance)
    find_transverse_source(rod, rods, shape.bending, shape.twist, balance)
    find_axial_source(rod, rods, shape, balance)
    solve_tension(rod, rods, shape, balance)
    find_axial_velocity(rod, rods, balance)
    find_transverse_velocity(rod, rods, shape.bending, balance)
    integrate_bishop_roll(rod, rods, balance)


@wp.func
def axial_velocity_at_node(rod: int, node: int, balance: Balance):
    """u0 at a node; even beyond the ends, where ``u0' = −Im(k̄ u⊥) = 0``."""
    last = balance.axial_velocity.shape[1] - 1
    before = balance.axial_velocity[rod, wp.max(node - 1, 0)]
    return real(0.5) * (before + balance.axial_velocity[rod, wp.min(node, last - 1)])


@wp.func
def roll_rate_after(rod: int, node: int, rods: Swimmers, shape: Shape):
    """``ω0 = (c τ' + M f)/ηr`` of the material at the half node after ``node`` (4.21)."""
    slope = (shape.twist[rod, node + 1] - shape.twist[rod, node]) / rods.spacing
    f = real(0.5) * (shape.activity[rod, node] + shape.activity[rod, node + 1])
    return (rods.twist_stiffness[rod] * slope + rods.moment[rod] * f) / rods.rotational_drag[rod]


@wp.func
def bending_rate(rod: int, node: int, rods: Swimmers, k: wp.vec2d, balance: Balance):
    """``∂k/∂t = ω⊥' − i ω0 k`` at an inner node (4.10)."""
    slope = (balance.angular_velocity[rod, node] - balance.angular_velocity[rod, node - 1]) / rods.spacing
    return slope - balance.bishop_roll_rate[rod, node] * times_i(k)


@wp.func
def activity_diffusion(rod: int, node: int, rods: Swimmers, activity: Scalars2D):
    """``D f''``, with ``f' = 0`` at the ends."""
    last = activity.shape[1] - 1
    left = activity[rod, wp.abs(node - 1)]
    right = activity[rod, last - wp.abs(last - node - 1)]
    scale = rods.diffusion[rod] / (rods.spacing * rods.spacing)
    return scale * (left - real(2.0) * activity[rod, node] + right)


@wp.func
def activity_terms(rod: int, node: int, rods: Swimmers, shape: Shape, balance: Balance):
    """``τf ∂f/∂t = source − sink f + D f''`` at a node (4.12), and the sink."""
    f = shape.activity[rod, node]
    u0 = axial_velocity_at_node(rod, node, balance)
    source, sink = reaction(rods.law[rod], f, u0, rods.law_parameters[rod])
    return source - sink * f + activity_diffusion(rod, node, rods, shape.activity), sink

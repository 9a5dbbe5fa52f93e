"""One time step of active rods: the two-step formula about the extrapolated shape x* (docs/model.md §1.5, §2.4).

With ``d = xⁿ − xⁿ⁻¹``, ``ρ`` the ratio of this step to the previous one and ``a = (1 + 2ρ)/((1 + ρ) Δt)``::

    x* = xⁿ + ρ d,    (a − L*) δ = F(x*) − ρ d/Δt,    xⁿ⁺¹ = x* + δ,    d ← ρ d + δ

``ρ = 0`` is the first step, implicit-explicit Euler. ``ρ = 1`` are equal steps. One thread does the whole step of a
rod. In the functions ``star`` is first x* and then, field by field, xⁿ⁺¹; ``change`` is d; ``rho_dt`` is ρ/Δt.
"""

import warp as wp

from warp_rods.kernels.banded import solve_pentadiagonal_rod, solve_tridiagonal_rod
from warp_rods.kernels.clock import RATIO, STEP
from warp_rods.kernels.free.rod import (
    activity_terms,
    bending_rate,
    find_transverse_source,
    find_transverse_velocity,
    roll_rate_after,
    set_zero_end_rows,
    solve_balance,
)
from warp_rods.kernels.free.state import Balance, ExternalForce, Shape, Swimmers
from warp_rods.kernels.layout import Scalars1D, real

wp.set_module_options({"enable_backward": False})


@wp.func
def extrapolate(
    rod: int, now: Shape, change: Shape, external: ExternalForce, ratio: real, star: Shape, balance: Balance
):
    """Extrapolate shape and external force to the end of the step."""
    for node in range(now.twist.shape[1]):
        star.bending[rod, node] = now.bending[rod, node] + ratio * change.bending[rod, node]
        star.twist[rod, node] = now.twist[rod, node] + ratio * change.twist[rod, node]
        star.activity[rod, node] = now.activity[rod, node] + ratio * change.activity[rod, node]
        force = external.now[rod, node]
        balance.force[rod, node] = force + ratio * (force - external.previous[rod, node])
        external.previous[rod, node] = force


@wp.func
def step_bending(rod: int, rods: Swimmers, star: Shape, change: Shape, a: real, rho_dt: real, balance: Balance):
    """From k* to kⁿ⁺¹, with ``L = −(b/η)∂⁴ + (1/η)∂²(λ* ·) + ∂(u0* ·)``: one real matrix for both components."""
    last = star.twist.shape[1] - 1
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
        rate = bending_rate(rod, node, rods, star.bending[rod, node], balance)
        balance.rhs_pairs[rod, node] = rate - rho_dt * change.bending[rod, node]
        u0 = u0_next
    set_free_end_rows(rod, last, stiffness, balance)
    solve_bending(rod, balance)
    for node in range(1, last):
        star.bending[rod, node] += balance.rhs_pairs[rod, node]


@wp.func
def set_free_end_rows(rod: int, last: int, stiffness: real, balance: Balance):
    """End rows of the pentadiagonal system for ``k = k' = 0`` at both free ends."""
    zero = real(0.0)
    set_zero_end_rows(rod, last, balance)
    balance.upper2[rod, 0] = zero
    balance.lower2[rod, last] = zero
    balance.rhs_pairs[rod, 0] = wp.vec2d()
    balance.rhs_pairs[rod, last] = wp.vec2d()
    balance.diagonal[rod, 1] += stiffness
    balance.diagonal[rod, last - 1] += stiffness


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
def solve_scalar(rod: int, balance: Balance):
    """δτ or δf, stored in place of the right-hand side."""
    solve_tridiagonal_rod(rod, balance.lower, balance.diagonal, balance.upper, balance.rhs, balance.work, balance.rhs)


@wp.func
def step_activity(rod: int, rods: Swimmers, star: Shape, change: Shape, a: real, rho_dt: real, balance: Balance):
    """From f* to fⁿ⁺¹, with diffusion and the sink of the law implicit, ``f' = 0`` at the ends."""
    last = star.twist.shape[1] - 1
    relaxation = rods.relaxation[rod]
    diffusion = rods.diffusion[rod] / (rods.spacing * rods.spacing)
    for node in range(last + 1):
        rate, sink = activity_terms(rod, node, rods, star, balance)
        balance.lower[rod, node] = -diffusion
        balance.upper[rod, node] = -diffusion
        balance.diagonal[rod, node] = relaxation * a + sink + real(2.0) * diffusion
        balance.rhs[rod, node] = rate - relaxation * rho_dt * change.activity[rod, node]
    balance.upper[rod, 0] = real(-2.0) * diffusion
    balance.lower[rod, last] = real(-2.0) * diffusion
    solve_scalar(rod, balance)
    for node in range(last + 1):
        star.activity[rod, node] += balance.rhs[rod, node]


@wp.func
def step_twist(rod: int, rods: Swimmers, star: Shape, change: Shape, a: real, rho_dt: real, balance: Balance):
    """From τ* to τⁿ⁺¹, with ``(c/ηr)∂²`` implicit.

    ``Im(k̄ ω⊥)`` must be that of the new bending; its extrapolation is unstable.
    """
    last = star.twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    diffusion = rods.twist_stiffness[rod] / rods.rotational_drag[rod] * per_length * per_length
    roll_rate = roll_rate_after(rod, 0, rods, star)
    for node in range(1, last):
        roll_rate_next = roll_rate_after(rod, node, rods, star)
        source = real(0.5) * (balance.twist_source[rod, node - 1] + balance.twist_source[rod, node])
        balance.lower[rod, node] = -diffusion
        balance.upper[rod, node] = -diffusion
        balance.diagonal[rod, node] = a + real(2.0) * diffusion
        rate = per_length * (roll_rate_next - roll_rate) + source
        balance.rhs[rod, node] = rate - rho_dt * change.twist[rod, node]
        roll_rate = roll_rate_next
    set_zero_end_rows(rod, last, balance)
    solve_scalar(rod, balance)
    for node in range(1, last):
        star.twist[rod, node] += balance.rhs[rod, node]


@wp.func
def symmetrise(rod: int, shape: Shape):
    """Impose ``k(−s) = −k̄(s)``, τ even, f odd (C.50).

    The Bishop frame has the parities of the material frame if the two agree at the middle node, because ``k_Bishop =
    k_material exp(i ∫τ)`` and the integral of an even twist is odd.
    """
    half = real(0.5)
    last = shape.twist.shape[1] - 1
    for node in range(last // 2 + 1):
        mirror = last - node
        k = shape.bending[rod, node]
        k_mirror = shape.bending[rod, mirror]
        odd = half * (k[0] - k_mirror[0])
        even = half * (k[1] + k_mirror[1])
        shape.bending[rod, node] = wp.vec2d(odd, even)
        shape.bending[rod, mirror] = wp.vec2d(-odd, even)
        tau = half * (shape.twist[rod, node] + shape.twist[rod, mirror])
        shape.twist[rod, node] = tau
        shape.twist[rod, mirror] = tau
        f = half * (shape.activity[rod, node] - shape.activity[rod, mirror])
        shape.activity[rod, node] = f
        shape.activity[rod, mirror] = -f


@wp.func
def step_shape(rod: int, rods: Swimmers, star: Shape, change: Shape, clock: Scalars1D, balance: Balance):
    """Advance the extrapolated shape ``star`` to the shape at the end of the step."""
    one = real(1.0)
    ratio = clock[RATIO]
    a = (one + real(2.0) * ratio) / ((one + ratio) * clock[STEP])
    rho_dt = ratio / clock[STEP]
    solve_balance(rod, rods, star, balance)
    step_bending(rod, rods, star, change, a, rho_dt, balance)
    step_activity(rod, rods, star, change, a, rho_dt, balance)
    find_transverse_source(rod, rods, star.bending, star.twist, balance)
    find_transverse_velocity(rod, rods, star.bending, balance)
    step_twist(rod, rods, star, change, a, rho_dt, balance)
    if rods.symmetric == 1:
        symmetrise(rod, star)

"""Time stepping of active rods: SBDF2 in increments from the extrapolated shape x* (model.md §2).

With ``d = xⁿ − xⁿ⁻¹``, ``ρ`` the ratio of this step to the one before and ``a = (1 + 2ρ)/((1 + ρ) Δt)``::

    x* = xⁿ + ρ d,    (a − L*) δ = F(x*) − ρ d/Δt,    xⁿ⁺¹ = x* + δ,    d ← ρ d + δ

``ρ = 0`` is the first step, IMEX Euler; ``ρ = 1`` equal steps. One thread takes a rod through a whole step.
"""

import warp as wp

from warp_rods.kernels.banded import solve_pentadiagonal_rod, solve_tridiagonal_rod
from warp_rods.kernels.clock import RATIO, STEP
from warp_rods.kernels.free.rod import (
    activity_drive,
    balance,
    bending_rate,
    find_transverse_source,
    find_transverse_velocity,
    pin,
    roll_at,
)
from warp_rods.kernels.free.state import AppliedForce, Flow, Shape, Swimmers, per_rod
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.func
def extrapolate(rod: int, now: Shape, change: Shape, applied: AppliedForce, ratio: real, star: Shape, flow: Flow):
    """Extrapolate shape and force to the end of the step."""
    for node in range(now.twist.shape[1]):
        star.bending[rod, node] = now.bending[rod, node] + ratio * change.bending[rod, node]
        star.twist[rod, node] = now.twist[rod, node] + ratio * change.twist[rod, node]
        star.activity[rod, node] = now.activity[rod, node] + ratio * change.activity[rod, node]
        force = applied.now[rod, node]
        flow.force[rod, node] = force + ratio * (force - applied.before[rod, node])
        applied.before[rod, node] = force


@wp.func
def step_bending(rod: int, rods: Swimmers, star: Shape, change: Shape, rate: real, memory: real, flow: Flow):
    """k* to kⁿ⁺¹, with ``L = −(b/η)∂⁴ + (1/η)∂²(λ* ·) + ∂(u0* ·)``: one real matrix for both components."""
    last = star.twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    mobility = per_length * per_length / rods.drag_ratio[rod]
    stiff = rods.bending_stiffness[rod] * mobility * per_length * per_length
    half = real(0.5) * per_length
    beside = real(-4.0) * stiff
    axial = flow.axial[rod, 0]
    for node in range(1, last):
        axial_next = flow.axial[rod, node]
        here = rate + real(6.0) * stiff + real(2.0) * mobility * flow.tension[rod, node]
        flow.lower2[rod, node] = stiff
        flow.lower[rod, node] = beside - mobility * flow.tension[rod, node - 1] + half * axial
        flow.diagonal[rod, node] = here + half * (axial - axial_next)
        flow.upper[rod, node] = beside - mobility * flow.tension[rod, node + 1] - half * axial_next
        flow.upper2[rod, node] = stiff
        drive = bending_rate(rod, node, rods, star.bending[rod, node], flow)
        flow.right_pair[rod, node] = drive - memory * change.bending[rod, node]
        axial = axial_next
    clamp(rod, last, stiff, flow)
    solve_bending(rod, flow)
    for node in range(1, last):
        star.bending[rod, node] += flow.right_pair[rod, node]


@wp.func
def clamp(rod: int, last: int, stiff: real, flow: Flow):
    """Rows of the pentadiagonal system for ``k = k' = 0`` at both ends."""
    zero = real(0.0)
    pin(rod, last, flow)
    flow.upper2[rod, 0] = zero
    flow.lower2[rod, last] = zero
    flow.right_pair[rod, 0] = wp.vec2d()
    flow.right_pair[rod, last] = wp.vec2d()
    flow.diagonal[rod, 1] += stiff
    flow.diagonal[rod, last - 1] += stiff


@wp.func
def solve_bending(rod: int, flow: Flow):
    """δk, in place of the right-hand side."""
    solve_pentadiagonal_rod(
        rod,
        flow.lower2,
        flow.lower,
        flow.diagonal,
        flow.upper,
        flow.upper2,
        flow.right_pair,
        flow.work_pair,
        flow.right_pair,
    )


@wp.func
def step_activity(rod: int, rods: Swimmers, star: Shape, change: Shape, rate: real, memory: real, flow: Flow):
    """f* to fⁿ⁺¹, with diffusion and the law's sink implicit, ``f' = 0`` at the ends."""
    last = star.twist.shape[1] - 1
    inertia = rods.relaxation[rod]
    spread = rods.diffusion[rod] / (rods.spacing * rods.spacing)
    for node in range(last + 1):
        drive, sink = activity_drive(rod, node, rods, star, flow)
        flow.lower[rod, node] = -spread
        flow.upper[rod, node] = -spread
        flow.diagonal[rod, node] = inertia * rate + sink + real(2.0) * spread
        flow.right[rod, node] = drive - inertia * memory * change.activity[rod, node]
    flow.upper[rod, 0] = real(-2.0) * spread
    flow.lower[rod, last] = real(-2.0) * spread
    solve_tridiagonal_rod(rod, flow.lower, flow.diagonal, flow.upper, flow.right, flow.work, flow.right)
    for node in range(last + 1):
        star.activity[rod, node] += flow.right[rod, node]


@wp.func
def step_twist(rod: int, rods: Swimmers, star: Shape, change: Shape, rate: real, memory: real, flow: Flow):
    """τ* to τⁿ⁺¹, with ``(c/ηr)∂²`` implicit and ``Im(k̄ ω⊥)`` of the new bending (extrapolated: unstable)."""
    last = star.twist.shape[1] - 1
    per_length = real(1.0) / rods.spacing
    soft = rods.twist_stiffness[rod] / rods.rotational_drag[rod] * per_length * per_length
    roll = roll_at(rod, 0, rods, star)
    for node in range(1, last):
        roll_next = roll_at(rod, node, rods, star)
        source = real(0.5) * (flow.twist_source[rod, node - 1] + flow.twist_source[rod, node])
        flow.lower[rod, node] = -soft
        flow.upper[rod, node] = -soft
        flow.diagonal[rod, node] = rate + real(2.0) * soft
        flow.right[rod, node] = per_length * (roll_next - roll) + source - memory * change.twist[rod, node]
        roll = roll_next
    pin(rod, last, flow)
    solve_tridiagonal_rod(rod, flow.lower, flow.diagonal, flow.upper, flow.right, flow.work, flow.right)
    for node in range(1, last):
        star.twist[rod, node] += flow.right[rod, node]


@wp.func
def symmetrise(rod: int, shape: Shape):
    """Keep ``k(−s) = −k̄(s)``, τ even, f odd (C.50).

    The Bishop frame inherits these parities from the material one when the two agree at the midpoint, as
    ``k_B = k exp(i ∫τ)`` and the integral of an even twist is odd.
    """
    half = real(0.5)
    last = shape.twist.shape[1] - 1
    for node in range(last // 2 + 1):
        mirror = last - node
        k = shape.bending[rod, node]
        other = shape.bending[rod, mirror]
        odd = half * (k[0] - other[0])
        even = half * (k[1] + other[1])
        shape.bending[rod, node] = wp.vec2d(odd, even)
        shape.bending[rod, mirror] = wp.vec2d(-odd, even)
        tau = half * (shape.twist[rod, node] + shape.twist[rod, mirror])
        shape.twist[rod, node] = tau
        shape.twist[rod, mirror] = tau
        f = half * (shape.activity[rod, node] - shape.activity[rod, mirror])
        shape.activity[rod, node] = f
        shape.activity[rod, mirror] = -f


@wp.func
def step_shape(rod: int, rods: Swimmers, star: Shape, change: Shape, clock: per_rod, flow: Flow):
    """Turn the extrapolated shape into that at the end of the step."""
    one = real(1.0)
    ratio = clock[RATIO]
    rate = (one + real(2.0) * ratio) / ((one + ratio) * clock[STEP])
    memory = ratio / clock[STEP]
    balance(rod, rods, star, flow)
    step_bending(rod, rods, star, change, rate, memory, flow)
    step_activity(rod, rods, star, change, rate, memory, flow)
    find_transverse_source(rod, rods, star.bending, star.twist, flow)
    find_transverse_velocity(rod, rods, star.bending, flow)
    step_twist(rod, rods, star, change, rate, memory, flow)
    if rods.symmetric == 1:
        symmetrise(rod, star)

"""One time step of active rods about the extrapolated shape x* (docs/model.md §1.5, §2.4).

    (a − J) δ = F(x*) − Σ d_j x_j,    xⁿ⁺¹ = x* + δ

One thread does the whole step of a rod. In the functions ``star`` is first x* and then, field by field, xⁿ⁺¹;
``slope`` is Σ d_j x_j.
"""

from typing import Any

import warp as wp

from warp_rods.kernels.banded import solve_tridiagonal_rod
from warp_rods.kernels.free.bending import step_bending
from warp_rods.kernels.free.rod import activity_terms, solve_balance
from warp_rods.kernels.free.state import Balance, Past, Shape, Swimmers
from warp_rods.kernels.free.twist import step_twist
from warp_rods.kernels.layout import real
from warp_rods.kernels.multistep import Levels

wp.set_module_options({"enable_backward": False})


@wp.func
def combine_differences(w: Levels, x0: Any, x1: Any, x2: Any, x3: Any, x4: Any):
    """Σ w_j (x_j − x_0), which is exactly zero for a field that does not change."""
    return w[1] * (x1 - x0) + w[2] * (x2 - x0) + w[3] * (x3 - x0) + w[4] * (x4 - x0)


@wp.func
def combine_shapes(rod: int, w: Levels, now: Shape, past: Past, result: Shape):
    """Σ w_j (x_j − x_0) of the levels of a rod, newest first."""
    for node in range(now.twist.shape[1]):
        result.bending[rod, node] = combine_differences(
            w,
            now.bending[rod, node],
            past.first.bending[rod, node],
            past.second.bending[rod, node],
            past.third.bending[rod, node],
            past.fourth.bending[rod, node],
        )
        result.twist[rod, node] = combine_differences(
            w,
            now.twist[rod, node],
            past.first.twist[rod, node],
            past.second.twist[rod, node],
            past.third.twist[rod, node],
            past.fourth.twist[rod, node],
        )
        result.activity[rod, node] = combine_differences(
            w,
            now.activity[rod, node],
            past.first.activity[rod, node],
            past.second.activity[rod, node],
            past.third.activity[rod, node],
            past.fourth.activity[rod, node],
        )


@wp.func
def find_slope(rod: int, d: Levels, now: Shape, past: Past, slope: Shape):
    """Σ d_j x_j; the sum of the d_j is zero."""
    combine_shapes(rod, d, now, past, slope)


@wp.func
def find_value(rod: int, e: Levels, now: Shape, past: Past, value: Shape):
    """Σ e_j x_j; the sum of the e_j is one."""
    combine_shapes(rod, e, now, past, value)
    for node in range(now.twist.shape[1]):
        value.bending[rod, node] += now.bending[rod, node]
        value.twist[rod, node] += now.twist[rod, node]
        value.activity[rod, node] += now.activity[rod, node]


@wp.func
def solve_scalar(rod: int, balance: Balance):
    """δτ or δf, stored in place of the right-hand side."""
    solve_tridiagonal_rod(rod, balance.lower, balance.diagonal, balance.upper, balance.rhs, balance.work, balance.rhs)


@wp.func
def step_activity(rod: int, rods: Swimmers, star: Shape, slope: Shape, a: real, balance: Balance):
    """From f* to fⁿ⁺¹, with diffusion and the sink of the law implicit, ``f' = 0`` at the ends."""
    last = star.twist.shape[1] - 1
    relaxation = rods.relaxation[rod]
    diffusion = rods.diffusion[rod] / (rods.spacing * rods.spacing)
    for node in range(last + 1):
        rate, sink = activity_terms(rod, node, rods, star, balance)
        balance.lower[rod, node] = -diffusion
        balance.upper[rod, node] = -diffusion
        balance.diagonal[rod, node] = relaxation * a + sink + real(2.0) * diffusion
        balance.rhs[rod, node] = rate - relaxation * slope.activity[rod, node]
    balance.upper[rod, 0] = real(-2.0) * diffusion
    balance.lower[rod, last] = real(-2.0) * diffusion
    solve_scalar(rod, balance)
    for node in range(last + 1):
        star.activity[rod, node] += balance.rhs[rod, node]


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
def step_shape(rod: int, rods: Swimmers, star: Shape, slope: Shape, a: real, balance: Balance):
    """Advance the extrapolated shape ``star`` to the shape at the end of the step."""
    solve_balance(rod, rods, star, balance)
    step_bending(rod, rods, star, slope, a, balance)
    step_activity(rod, rods, star, slope, a, balance)
    step_twist(rod, rods, star, slope, a, balance)
    if rods.symmetric == 1:
        symmetrise(rod, star)

"""One time step of active rods about the extrapolated shape x* (docs/model.md §1.5, §2.4).

    (a − J) δ = F(x*) − Σ d_j x_j,    xⁿ⁺¹ = x* + δ

One thread does the whole step of a tile of rods. In the functions ``star`` is first x* and then, field by field, xⁿ⁺¹;
``slope`` is Σ d_j x_j.
"""

import warp as wp

from warp_rods.kernels.banded import solve_tridiagonal_rod
from warp_rods.kernels.free.bending import step_bending
from warp_rods.kernels.free.levels import differences, levels_in
from warp_rods.kernels.free.natural import find_rest
from warp_rods.kernels.free.rod import activity_terms, solve_balance
from warp_rods.kernels.free.state import Balance, Past, Shape, Swimmers
from warp_rods.kernels.free.twist import step_twist
from warp_rods.kernels.lanes import Lanes, add, div, mul, pair, sub  # noqa: F401 (operators)
from warp_rods.kernels.layout import Scalars1D, real
from warp_rods.kernels.multistep import Weights

wp.set_module_options({"enable_backward": False})


@wp.func
def find_slope(tile: int, d: Weights, now: Shape, past: Past, slope: Shape):
    """Σ d_j x_j; the sum of the d_j is zero."""
    levels = levels_in(d)
    for node in range(now.twist.shape[1]):
        k, tau, f = differences(tile, node, d, levels, now, past)
        slope.bending[tile, node] = k
        slope.twist[tile, node] = tau
        slope.activity[tile, node] = f


@wp.func
def find_value(tile: int, e: Weights, now: Shape, past: Past, value: Shape):
    """Σ e_j x_j; the sum of the e_j is one."""
    levels = levels_in(e)
    for node in range(now.twist.shape[1]):
        k, tau, f = differences(tile, node, e, levels, now, past)
        value.bending[tile, node] = now.bending[tile, node] + k
        value.twist[tile, node] = now.twist[tile, node] + tau
        value.activity[tile, node] = now.activity[tile, node] + f


@wp.func
def solve_scalar(tile: int, balance: Balance):
    """δτ or δf, stored in place of the right-hand side."""
    solve_tridiagonal_rod(tile, balance.lower, balance.diagonal, balance.upper, balance.rhs, balance.work, balance.rhs)


@wp.func
def step_activity(tile: int, rods: Swimmers, star: Shape, slope: Shape, a: Lanes, balance: Balance):
    """From f* to fⁿ⁺¹, with diffusion and the sink of the law implicit, ``f' = 0`` at the ends."""
    last = star.twist.shape[1] - 1
    relaxation = rods.relaxation[tile]
    diffusion = rods.diffusion[tile] / (rods.spacing * rods.spacing)
    for node in range(last + 1):
        rate, sink = activity_terms(tile, node, rods, star, balance)
        balance.lower[tile, node] = -diffusion
        balance.upper[tile, node] = -diffusion
        balance.diagonal[tile, node] = relaxation * a + sink + real(2.0) * diffusion
        balance.rhs[tile, node] = rate - relaxation * slope.activity[tile, node]
    balance.upper[tile, 0] = real(-2.0) * diffusion
    balance.lower[tile, last] = real(-2.0) * diffusion
    solve_scalar(tile, balance)
    for node in range(last + 1):
        star.activity[tile, node] += balance.rhs[tile, node]


@wp.func
def symmetrise(tile: int, shape: Shape):
    """Impose ``k(−s) = −k̄(s)``, τ even, f odd (C.50).

    The Bishop frame has the parities of the material frame if the two agree at the middle node, because ``k_Bishop =
    k_material exp(i ∫τ)`` and the integral of an even twist is odd.
    """
    half = real(0.5)
    last = shape.twist.shape[1] - 1
    for node in range(last // 2 + 1):
        mirror = last - node
        k = shape.bending[tile, node]
        k_mirror = shape.bending[tile, mirror]
        odd = half * (k[0] - k_mirror[0])
        even = half * (k[1] + k_mirror[1])
        shape.bending[tile, node] = pair(odd, even)
        shape.bending[tile, mirror] = pair(-odd, even)
        tau = half * (shape.twist[tile, node] + shape.twist[tile, mirror])
        shape.twist[tile, node] = tau
        shape.twist[tile, mirror] = tau
        f = half * (shape.activity[tile, node] - shape.activity[tile, mirror])
        shape.activity[tile, node] = f
        shape.activity[tile, mirror] = -f


@wp.func
def step_shape(tile: int, rods: Swimmers, star: Shape, slope: Shape, a: Lanes, angle: Scalars1D, balance: Balance):
    """Advance the extrapolated shape ``star``, with the ``angle`` θ there, to the shape at the end of the step."""
    if rods.bent == 1:
        find_rest(tile, rods, star, angle, balance)
    solve_balance(tile, rods, star, balance)
    step_bending(tile, rods, star, slope, a, balance)
    step_activity(tile, rods, star, slope, a, balance)
    step_twist(tile, rods, star, slope, a, balance)
    if rods.symmetric == 1:
        symmetrise(tile, star)

"""Sine and cosine without branches or calls, so that loops over lanes become vector instructions.

x is reduced by the nearest multiple of π (cosine: of odd multiples of π/2), in three parts whose products are exact for
|x| < 1e6; beyond, the error is that of rounding x. The series on |r| ≤ π/2 ends at r²¹/21!. Together 2.3e-16.
"""

from typing import Any

import warp as wp

from warp_rods.kernels.lanes import Lanes, Pair, add, mul, pair, sub  # noqa: F401 (operators)
from warp_rods.kernels.layout import real
from warp_rods.kernels.lie import factorial

wp.set_module_options({"enable_backward": False})

PER_PI = wp.constant(real(0.3183098861837907))
PI_1 = wp.constant(real(3.141592651605606))
PI_2 = wp.constant(real(1.9841871583270443e-09))
PI_3 = wp.constant(real(1.034036596358821e-18))
NEAREST = wp.constant(real(6755399441055744.0))
"""1.5 · 2⁵²: the sum of a number and this is a whole number."""
terms = wp.types.vector(11, real)
SINE = wp.constant(terms(*[(-1) ** j / factorial(2 * j + 1) for j in range(11)]))


@wp.func
def nearest(x: Any):
    """The nearest whole number, for |x| < 2⁵¹."""
    return (x + NEAREST) - NEAREST


@wp.func
def sine_of_rest(x: Any, turns: Any, flips: Any):
    """(−1)^flips sin(x − turns π); ``turns`` may be half a number."""
    r = ((x - PI_1 * turns) - PI_2 * turns) - PI_3 * turns
    odd = real(0.5) * flips - nearest(real(0.5) * flips)
    t = r * r
    total = SINE[9] + SINE[10] * t
    for j in range(8):
        total = SINE[8 - j] + t * total
    return (real(1.0) - real(8.0) * odd * odd) * (r + r * (t * total))


@wp.func
def sine(x: real) -> real:
    """sin x."""
    turns = nearest(PER_PI * x)
    return sine_of_rest(x, turns, turns)


@wp.func
def cosine(x: real) -> real:
    """cos x."""
    flips = nearest(PER_PI * x + real(0.5))
    return sine_of_rest(x, flips - real(0.5), flips)


@wp.func
def turn(x: Lanes) -> Pair:
    """exp(ix)."""
    turns = nearest(PER_PI * x)
    flips = nearest(PER_PI * x + real(0.5))
    return pair(sine_of_rest(x, flips - real(0.5), flips), sine_of_rest(x, turns, turns))

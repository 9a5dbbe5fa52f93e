"""Backward differentiation on levels at any times, for one rod (docs/model.md §1.5).

``at`` are the times of past levels, newest first, and t the end of the step. With p levels::

    x* = Σ e_j x_j                        extrapolation to t, a polynomial of degree p − 1
    dx/dt(t) = a (x − x*) + Σ d_j x_j,    a = Σ 1/(t − at_j)

which is the derivative of the polynomial through x at t and the p levels. Its error in x is the distance to the
extrapolation with one level more, over ``a (t − at_p)``.
"""

from typing import Any

import warp as wp

from warp_rods.kernels.lanes import WIDTH, Lanes, add, mul, rods_in  # noqa: F401 (operators)
from warp_rods.kernels.layout import Integers1D, Scalars1D, Scalars2D, real

wp.set_module_options({"enable_backward": False})

LEVELS = 5
"""Levels that are kept: one more than the highest order, for its error."""

Levels = wp.types.vector(length=LEVELS, dtype=real)
Weights = wp.types.matrix(shape=(LEVELS, WIDTH), dtype=real)
"""Numbers of levels for each rod of a tile; ``[j]`` are Lanes."""

SAFETY = wp.constant(real(0.85))
"""Fraction of the step that the estimated error would allow."""
SHORTEST = wp.constant(real(1.0e-13))
"""The shortest step that is tried, in units of the time at its start."""
SHORTEST_AT_START = wp.constant(real(1.0e-30))
"""The shortest step at the start, in units of the time to which the steps go."""
INFINITE = wp.constant(real(float("inf")))
"""The error of a step whose result is not valid."""
SMALLEST_ERROR = wp.constant(real(1.0e-12))
SHORTEN_MOST = wp.constant(real(0.1))
SHORTEN_LEAST = wp.constant(real(0.8))
LENGTHEN_LEAST = wp.constant(real(1.15))
LENGTHEN_MOST = wp.constant(real(2.0))
LENGTHEN_FIRST_ORDER = wp.constant(real(5.0))
"""Bounds of the ratio of a step to the one before; the formulas are stable for such ratios now and then."""


@wp.struct
class Pace:
    """Where each rod is in time [rod], and the steps that it takes."""

    at: Scalars2D  # times of the levels [rod, level], newest first
    levels: Integers1D  # how many of them are known
    order: Integers1D
    step: Scalars1D  # the next step to try
    waited: Integers1D  # steps since step or order changed
    highest_order: Integers1D
    taken: Integers1D
    rejected: Integers1D
    largest_error: Scalars1D  # of a step that was taken
    total_error: Scalars1D  # sum of the errors of all steps that were taken


@wp.struct
class Formula:
    """Weights of the levels, newest first, and ``a``."""

    value: Levels  # e
    slope: Levels  # d
    rate: real  # a
    order: int


@wp.func
def times_of(pace: Pace, rod: int) -> Levels:
    """Times of the levels of a rod."""
    at = Levels()
    for j in range(LEVELS):
        at[j] = pace.at[rod, j]
    return at


@wp.func
def weights_at(at: Levels, levels: int, t: real) -> Levels:
    """Weights at time t of the polynomial through this many levels."""
    e = Levels()
    for j in range(levels):
        product = real(1.0)
        for i in range(levels):
            if i != j:
                product *= (t - at[i]) / (at[j] - at[i])
        e[j] = product
    return e


@wp.func
def formula_of(at: Levels, order: int, t: real) -> Formula:
    """The formula of this order for a step that ends at t."""
    formula = Formula()
    formula.order = order
    formula.value = weights_at(at, order, t)
    total = real(0.0)
    for j in range(order):
        total += real(1.0) / (t - at[j])
    for j in range(order):
        formula.slope[j] = formula.value[j] * (total - real(1.0) / (t - at[j]))
    formula.rate = total
    return formula


@wp.func
def combine(w: Any, x0: Any, x1: Any, x2: Any, x3: Any, x4: Any):
    """Σ w_j x_j."""
    return w[0] * x0 + w[1] * x1 + w[2] * x2 + w[3] * x3 + w[4] * x4


@wp.func
def local_error_scale(at: Levels, order: int, t: real) -> real:
    """The error of a step of this order over the distance to the extrapolation with ``order + 1`` levels."""
    total = real(0.0)
    for j in range(order):
        total += real(1.0) / (t - at[j])
    return real(1.0) / (total * (t - at[order]))


@wp.func
def step_factor(error: real, order: int) -> real:
    """The ratio of the next step to this one for an ``error`` in units of what is allowed."""
    return SAFETY * wp.pow(wp.max(error, SMALLEST_ERROR), real(-1.0) / real(order + 1))


@wp.func
def push_time(pace: Pace, rod: int, t: real, error: real):
    """Take t as the time of the newest level, after a step with this error."""
    pace.largest_error[rod] = wp.max(pace.largest_error[rod], error)
    pace.total_error[rod] = pace.total_error[rod] + error
    for k in range(LEVELS - 1):
        j = LEVELS - 1 - k
        pace.at[rod, j] = pace.at[rod, j - 1]
    pace.at[rod, 0] = t
    pace.levels[rod] = wp.min(pace.levels[rod] + 1, LEVELS)
    pace.taken[rod] = pace.taken[rod] + 1
    pace.waited[rod] = pace.waited[rod] + 1


@wp.func
def lengths_of(tile: int, pace: Pace, end: Scalars1D) -> Lanes:
    """Δt of the steps of a tile to the times ``end``."""
    dt = Lanes(real(1.0))
    for lane in range(rods_in(tile, end.shape[0])):
        rod = tile * WIDTH + lane
        dt[lane] = end[rod] - pace.at[rod, 0]
    return dt


@wp.func
def is_shortest(step: real, start: real, target: real) -> bool:
    """Whether no step from ``start`` on the way to ``target`` may be shorter."""
    return step < SHORTEST * start + SHORTEST_AT_START * target


@wp.func
def reject(pace: Pace, rod: int, tried: real, factor: real):
    """Try a shorter step than the one tried, which an event may have cut."""
    pace.step[rod] = tried * wp.clamp(factor, SHORTEN_MOST, SHORTEN_LEAST)
    pace.rejected[rod] = pace.rejected[rod] + 1
    pace.waited[rod] = 0


@wp.func
def choose_next(pace: Pace, rod: int, lower: real, same: real, higher: real):
    """Step and order after a step that was taken, from the step factors of three orders (0: not possible).

    They change only after as many equal steps as the formula has levels, and the step only where that is worth it.
    """
    order = pace.order[rod]
    factor = same
    if lower > factor:
        factor = lower
        pace.order[rod] = order - 1
    if higher > factor:
        factor = higher
        pace.order[rod] = order + 1
    if pace.order[rod] != order:
        pace.waited[rod] = 0
    if factor > LENGTHEN_LEAST or factor < real(1.0):
        most = LENGTHEN_MOST
        if order == 1:
            most = LENGTHEN_FIRST_ORDER
        pace.step[rod] = pace.step[rod] * wp.clamp(factor, SHORTEN_MOST, most)
        pace.waited[rod] = 0

"""Steps of active rods that nothing pushes, each rod at its own pace, and the state between them."""

import warp as wp

from warp_rods.kernels.free.motion import (
    carried_midpoint,
    carry_midpoint,
    midpoint_rates,
    push_rates,
)
from warp_rods.kernels.free.outcome import error_of_step, shape_error, status_of, store_shape
from warp_rods.kernels.free.state import Balance, Midpoint, Past, Shape, Swimmers
from warp_rods.kernels.free.step import find_slope, find_value, step_shape
from warp_rods.kernels.layout import Matrices1D, Scalars1D, Vectors1D, real
from warp_rods.kernels.magnus import levels_of_rates
from warp_rods.kernels.multistep import (
    Pace,
    choose_next,
    formula_of,
    is_shortest,
    push_time,
    reject,
    step_factor,
    times_of,
    weights_at,
)
from warp_rods.kernels.status import OK, why_frozen

wp.set_module_options({"enable_backward": False})


@wp.kernel
def advance_past(
    rods: Swimmers,
    now: Shape,
    past: Past,
    midpoint: Midpoint,
    pace: Pace,
    target: Scalars1D,
    failed_at: Scalars1D,
    star: Shape,
    slope: Shape,
    balance: Balance,
):
    """Steps of every rod that is not frozen until it reaches the time ``target[0]``, each rod at its own pace.

    ``target[1]`` is the error allowed in a step; ``dim = rods``.
    """
    rod = wp.tid()
    while rods.status[rod] == OK and pace.at[rod, 0] < target[0]:
        at = times_of(pace, rod)
        order = pace.order[rod]
        t = at[0] + pace.step[rod]
        formula = formula_of(at, order, t)
        find_value(rod, formula.value, now, past, star)
        find_slope(rod, formula.slope, now, past, slope)
        step_shape(rod, rods, star, slope, formula.rate, balance)
        status = status_of(rod, rods, star)
        levels = pace.levels[rod]
        error = real(1.0e6)
        if status == OK:
            error = error_of_step(rod, at, levels, order, t, now, past, star) / target[1]
        if not (error <= real(1.0)):
            if is_shortest(t - at[0], at[0], target[2]):
                rods.status[rod] = why_frozen(status)
                failed_at[rod] = at[0]
            reject(pace, rod, step_factor(error, order))
        else:
            same = step_factor(error, order)
            lower, higher = real(0.0), real(0.0)
            ready = pace.waited[rod] >= order
            if ready and order > 1:
                lower = step_factor(shape_error(rod, at, order - 1, t, now, past, star) / target[1], order - 1)
            if ready and order < pace.highest_order[rod] and levels > order + 1:
                higher = step_factor(shape_error(rod, at, order + 1, t, now, past, star) / target[1], order + 1)
            omega, u, roll_rate = midpoint_rates(rod, rods, star, balance)
            push_time(pace, rod, t, real(0.0))
            push_rates(rod, midpoint, omega, u, roll_rate)
            carry_midpoint(rod, pace, midpoint)
            store_shape(rod, star, now, past)
            if ready:
                choose_next(pace, rod, lower, same, higher)


@wp.kernel
def show(
    now: Shape,
    past: Past,
    midpoint: Midpoint,
    pace: Pace,
    target: Scalars1D,
    shown: Shape,
    rotation: Matrices1D,
    position: Vectors1D,
    angle: Scalars1D,
):
    """Shape and middle frame at the time ``target[0]`` within the last step, or at its end; ``dim = rods``."""
    rod = wp.tid()
    at = times_of(pace, rod)
    t = wp.min(target[0], at[0])
    find_value(rod, weights_at(at, wp.min(pace.order[rod] + 1, pace.levels[rod]), t), now, past, shown)
    rotation[rod] = midpoint.rotation[rod]
    position[rod] = midpoint.position[rod]
    angle[rod] = midpoint.angle[rod]
    if t < at[0]:
        R0 = midpoint.rotation_before[rod]
        r0 = midpoint.position_before[rod]
        levels = levels_of_rates(pace, rod, wp.max(pace.order[rod], 2))
        R, r, theta = carried_midpoint(rod, midpoint, R0, r0, midpoint.angle_before[rod], at, levels, at[1], t)
        rotation[rod] = R
        position[rod] = r
        angle[rod] = theta

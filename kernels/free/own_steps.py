"""Steps of active rods that nothing pushes, each rod at its own pace, and the state between them."""

import warp as wp

from warp_rods.kernels.free.formulas import formulas_of
from warp_rods.kernels.free.motion import (
    carried_midpoint,
    carried_so_far,
    carry_midpoint,
    find_midpoint_rates,
    foretold_angle,
    push_rates,
)
from warp_rods.kernels.free.outcome import errors_of_order, find_errors, find_statuses, store_shape
from warp_rods.kernels.free.state import NOT_CARRIED, Balance, Midpoint, Past, Shape, Swimmers, Trial
from warp_rods.kernels.free.step import find_slope, find_value, step_shape
from warp_rods.kernels.lanes import WIDTH, Lanes, any_of, repeat_last, rods_in
from warp_rods.kernels.layout import Matrices1D, Scalars1D, Vectors1D, real
from warp_rods.kernels.magnus import levels_of_rates
from warp_rods.kernels.multistep import (
    LEVELS,
    Pace,
    Weights,
    choose_next,
    is_shortest,
    push_time,
    reject,
    step_factor,
    times_of,
    weights_at,
)
from warp_rods.kernels.status import OK, why_frozen

wp.set_module_options({"enable_backward": False})

OF_INVALID = wp.constant(real(1.0e6))
"""The error of a step whose result is not valid, in units of what is allowed."""


@wp.func
def end_before(limit: real, start: real, step: real) -> real:
    """The end of a step that does not pass a limit; the last two steps before it are of the same length."""
    left = limit - start
    if step >= left:
        return limit
    if real(2.0) * step > left:
        return start + real(0.5) * left
    return start + step


@wp.func
def plan_steps(tile: int, rods: Swimmers, pace: Pace, midpoint: Midpoint, target: real, trial: Trial):
    """Ends and orders of the next steps; 1 for rods that take one, 0 for those that are frozen or have arrived."""
    going = Lanes()
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        start = pace.at[rod, 0]
        trial.order[rod] = 1
        trial.end[rod] = start + real(1.0)
        if rods.status[rod] == OK and start < wp.min(target, trial.limit[rod]):
            trial.order[rod] = pace.order[rod]
            trial.end[rod] = end_before(trial.limit[rod], start, pace.step[rod])
            going[lane] = real(1.0)
        if rods.bent == 1:
            trial.angle[rod] = foretold_angle(rod, midpoint, pace, trial.end[rod])
    return going


@wp.func
def may_lower(rod: int, pace: Pace):
    """Whether an order less is worth a look."""
    return pace.waited[rod] >= pace.order[rod] and pace.order[rod] > 1


@wp.func
def may_raise(rod: int, pace: Pace):
    """Whether an order more is worth a look, and possible."""
    order = pace.order[rod]
    return pace.waited[rod] >= order and order < pace.highest_order[rod] and pace.levels[rod] > order + 1


@wp.func
def any_may_lower(tile: int, pace: Pace):
    """``may_lower`` of any rod."""
    for lane in range(rods_in(tile, pace.at.shape[0])):  # noqa: SIM110 (a Warp function)
        if may_lower(tile * WIDTH + lane, pace):
            return True
    return False


@wp.func
def any_may_raise(tile: int, pace: Pace):
    """``may_raise`` of any rod."""
    for lane in range(rods_in(tile, pace.at.shape[0])):  # noqa: SIM110 (a Warp function)
        if may_raise(tile * WIDTH + lane, pace):
            return True
    return False


@wp.func
def other_errors(tile: int, pace: Pace, trial: Trial, now: Shape, past: Past, star: Shape):
    """Errors of steps of an order less and of one more; 0 where no rod of the tile may take them."""
    lower, higher = Lanes(), Lanes()
    if any_may_lower(tile, pace):
        lower = errors_of_order(tile, -1, pace, trial, now, past, star)
    if any_may_raise(tile, pace):
        higher = errors_of_order(tile, 1, pace, trial, now, past, star)
    return lower, higher


@wp.func
def reject_step(rod: int, rods: Swimmers, pace: Pace, unit: real, error: real, trial: Trial, failed_at: Scalars1D):
    """Try a shorter step, or freeze a rod that has tried the shortest one."""
    start = pace.at[rod, 0]
    tried = real(1.0) * pace.step[rod]
    if real(2.0) * tried > trial.limit[rod] - start:
        tried = trial.end[rod] - start  # cut by an event
    if is_shortest(trial.end[rod] - start, start, unit):
        rods.status[rod] = why_frozen(trial.status[rod])
        failed_at[rod] = start
    reject(pace, rod, tried, step_factor(error, pace.order[rod]))


@wp.func
def accept_step(rod: int, pace: Pace, midpoint: Midpoint, lower: real, same: real, higher: real, trial: Trial):
    """Carry the middle frame to the end of the step, and choose the next one from the errors."""
    order = pace.order[rod]
    ready = pace.waited[rod] >= order
    factor_lower, factor_higher = real(0.0), real(0.0)
    if may_lower(rod, pace):
        factor_lower = step_factor(lower, order - 1)
    if may_raise(rod, pace):
        factor_higher = step_factor(higher, order + 1)
    push_time(pace, rod, trial.end[rod], real(0.0))
    push_rates(rod, midpoint, trial.angular_velocity[rod], trial.velocity[rod], trial.roll_rate[rod])
    carry_midpoint(rod, pace, midpoint)
    if ready:
        choose_next(pace, rod, factor_lower, step_factor(same, order), factor_higher)


@wp.kernel
def advance_past(
    rods: Swimmers,
    now: Shape,
    past: Past,
    midpoint: Midpoint,
    pace: Pace,
    target: Scalars1D,
    failed_at: Scalars1D,
    trial: Trial,
    star: Shape,
    slope: Shape,
    balance: Balance,
):
    """Steps of every rod that is not frozen until it reaches the time ``target[0]``, each rod at its own pace.

    ``target[1]`` is the error allowed in a step; ``dim = tiles``.
    """
    tile = wp.tid()
    going = plan_steps(tile, rods, pace, midpoint, target[0], trial)
    while any_of(going):
        formulas = formulas_of(tile, pace, trial)
        find_value(tile, formulas.value, now, past, star)
        find_slope(tile, formulas.slope, now, past, slope)
        step_shape(tile, rods, star, slope, formulas.rate, trial.angle, balance)
        find_midpoint_rates(tile, rods, star, balance, trial)
        find_statuses(tile, rods, star, trial)
        find_errors(tile, pace, trial, now, past, star)
        lower, higher = other_errors(tile, pace, trial, now, past, star)
        accepted = Lanes()
        for lane in range(rods_in(tile, trial.end.shape[0])):
            rod = tile * WIDTH + lane
            error = trial.error[rod] / target[1]
            if trial.status[rod] != OK:
                error = OF_INVALID
            if going[lane] != real(0.0):
                if error <= real(1.0):
                    accepted[lane] = real(1.0)
                    accept_step(rod, pace, midpoint, lower[lane] / target[1], error, higher[lane] / target[1], trial)
                else:
                    reject_step(rod, rods, pace, target[2], error, trial, failed_at)
        store_shape(tile, repeat_last(tile, trial.end.shape[0], accepted), star, now, past)
        going = plan_steps(tile, rods, pace, midpoint, target[0], trial)


@wp.kernel
def show_shape(now: Shape, past: Past, pace: Pace, target: Scalars1D, shown: Shape):
    """Shapes at the time ``target[0]`` within the last step of each rod, or at its end; ``dim = tiles``."""
    tile = wp.tid()
    w = Weights()
    for lane in range(rods_in(tile, pace.at.shape[0])):
        rod = tile * WIDTH + lane
        at = times_of(pace, rod)
        e = weights_at(at, wp.min(pace.order[rod] + 1, pace.levels[rod]), wp.min(target[0], at[0]))
        for j in range(LEVELS):
            w[j, lane] = e[j]
    find_value(tile, w, now, past, shown)


@wp.kernel
def show_midpoint(
    midpoint: Midpoint,
    pace: Pace,
    target: Scalars1D,
    rotation: Matrices1D,
    position: Vectors1D,
    angle: Scalars1D,
):
    """Middle frames at the time ``target[0]`` within the last step of each rod, or at its end; ``dim = rods``."""
    rod = wp.tid()
    at = times_of(pace, rod)
    t = wp.min(target[0], at[0])
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
    if midpoint.carrier.kind != NOT_CARRIED:
        position[rod] = position[rod] + carried_so_far(rod, midpoint.carrier, at, t)

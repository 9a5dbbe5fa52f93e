"""Motion of active rods in space, and the kernel of a step.

The frame of the middle node advances by Magnus steps (4.29). Frames elsewhere are computed from the strains when they
are needed. A rod whose shape becomes non-finite or unresolved keeps its last valid state and gets a status; the other
rods continue.
"""

import warp as wp

from warp_rods.kernels.clock import STEP
from warp_rods.kernels.free.error import error_of
from warp_rods.kernels.free.rod import axial_velocity_at_node, roll_rate_after
from warp_rods.kernels.free.state import Balance, ExternalForce, Midpoint, Past, Shape, Swimmers
from warp_rods.kernels.free.step import combine_shapes, extrapolate, extrapolate_force, step_shape
from warp_rods.kernels.layout import Matrices1D, Scalars1D, Vectors1D, real
from warp_rods.kernels.lie import orthonormalise, se3_compose, se3_exp
from warp_rods.kernels.magnus import RATES, mean_over, twist_over
from warp_rods.kernels.multistep import (
    Levels,
    Pace,
    choose_next,
    formula_of,
    local_error_scale,
    push_time,
    reject,
    step_factor,
    times_of,
    weights_at,
)
from warp_rods.kernels.status import NOT_FINITE, OK, TOO_BENT

wp.set_module_options({"enable_backward": False})

HALF_TURN = wp.constant(real(wp.pi))
SHORTEST = wp.constant(real(1.0e-13))
"""The shortest step that is tried, in units of the time and of ``target[2]``."""


@wp.func
def status_of(rod: int, rods: Swimmers, shape: Shape):
    """OK if the shape is finite and bends by less than half a turn between adjacent nodes."""
    largest_square = real(0.0)
    non_finite = real(0.0)
    for node in range(shape.twist.shape[1]):
        k = shape.bending[rod, node]
        largest_square = wp.max(largest_square, wp.dot(k, k))
        # Zero times a number is zero; zero times infinity or NaN is NaN.
        non_finite += real(0.0) * (k[0] + k[1] + shape.twist[rod, node] + shape.activity[rod, node])
    if non_finite != real(0.0):
        return NOT_FINITE
    if largest_square * rods.spacing * rods.spacing > HALF_TURN * HALF_TURN:
        return TOO_BENT
    return OK


@wp.func
def push_level(rod: int, node: int, newest: Shape, older: Shape):
    """Copy one level of a node to the next older one."""
    older.bending[rod, node] = newest.bending[rod, node]
    older.twist[rod, node] = newest.twist[rod, node]
    older.activity[rod, node] = newest.activity[rod, node]


@wp.func
def store_shape(rod: int, star: Shape, now: Shape, past: Past):
    """Make the shape at the end of the step the present one."""
    for node in range(now.twist.shape[1]):
        push_level(rod, node, past.third, past.fourth)
        push_level(rod, node, past.second, past.third)
        push_level(rod, node, past.first, past.second)
        push_level(rod, node, now, past.first)
        push_level(rod, node, star, now)


@wp.func
def midpoint_rates(rod: int, rods: Swimmers, shape: Shape, balance: Balance):
    """(ω, u) of the middle node in its Bishop frame, and ω0 of the material there."""
    half = real(0.5)
    node = shape.twist.shape[1] // 2
    omega = half * (balance.angular_velocity[rod, node - 1] + balance.angular_velocity[rod, node])
    u = balance.transverse_velocity[rod, node]
    u0 = axial_velocity_at_node(rod, node, balance)
    roll_rate = half * (roll_rate_after(rod, node - 1, rods, shape) + roll_rate_after(rod, node, rods, shape))
    zero = real(0.0)
    if rods.symmetric == 1:  # (C.53), (C.54)
        return wp.vec3d(zero, omega[0], zero), wp.vec3d(zero, u[0], zero), zero
    return wp.vec3d(zero, omega[0], omega[1]), wp.vec3d(u0, u[0], u[1]), roll_rate


@wp.func
def push_rates(rod: int, midpoint: Midpoint, omega: wp.vec3d, velocity: wp.vec3d, roll_rate: real):
    """Take these rates as those of the newest level."""
    for k in range(RATES - 1):
        j = RATES - 1 - k
        midpoint.angular_velocity[rod, j] = midpoint.angular_velocity[rod, j - 1]
        midpoint.velocity[rod, j] = midpoint.velocity[rod, j - 1]
        midpoint.roll_rate[rod, j] = midpoint.roll_rate[rod, j - 1]
    midpoint.angular_velocity[rod, 0] = omega
    midpoint.velocity[rod, 0] = velocity
    midpoint.roll_rate[rod, 0] = roll_rate


@wp.func
def move_midpoint(rod: int, midpoint: Midpoint, at: Levels, levels: int, start: real, end: real):
    """The frame of the middle node and its angle at time ``end``, from those before the last step at ``start`` (4.29).

    The rates are the polynomial through this many levels.
    """
    theta, mu = twist_over(midpoint.angular_velocity, midpoint.velocity, rod, at, levels, start, end)
    Q, q = se3_exp(theta, mu)
    R, r = se3_compose(midpoint.rotation_before[rod], midpoint.position_before[rod], Q, q)
    roll = mean_over(midpoint.roll_rate, rod, at, levels, start, end)
    return orthonormalise(R), r, midpoint.angle_before[rod] + (end - start) * roll


@wp.func
def advance_midpoint(rod: int, rods: Swimmers, shape: Shape, balance: Balance, pace: Pace, midpoint: Midpoint):
    """Advance the frame of the middle node over the last step, and keep where it was."""
    omega, velocity, roll_rate = midpoint_rates(rod, rods, shape, balance)
    push_rates(rod, midpoint, omega, velocity, roll_rate)
    midpoint.rotation_before[rod] = midpoint.rotation[rod]
    midpoint.position_before[rod] = midpoint.position[rod]
    midpoint.angle_before[rod] = midpoint.angle[rod]
    at = times_of(pace, rod)
    R, r, angle = move_midpoint(rod, midpoint, at, levels_of_rates(pace, rod), at[1], at[0])
    midpoint.rotation[rod] = R
    midpoint.position[rod] = r
    midpoint.angle[rod] = angle


@wp.func
def levels_of_rates(pace: Pace, rod: int):
    """Levels at which the rates of the middle node are known, no more than the order needs; not those of the start."""
    return wp.min(wp.min(pace.levels[rod] - 1, wp.max(pace.order[rod], 2)), RATES)


@wp.func
def accept(
    rod: int,
    rods: Swimmers,
    star: Shape,
    now: Shape,
    past: Past,
    balance: Balance,
    pace: Pace,
    midpoint: Midpoint,
    t: real,
):
    """Make the state at t the present one."""
    push_time(pace, rod, t)
    advance_midpoint(rod, rods, star, balance, pace, midpoint)
    store_shape(rod, star, now, past)


@wp.kernel
def advance(
    rods: Swimmers,
    now: Shape,
    past: Past,
    midpoint: Midpoint,
    pace: Pace,
    external: ExternalForce,
    clock: Scalars1D,
    failed_at: Scalars1D,
    star: Shape,
    slope: Shape,
    balance: Balance,
):
    """One step of every rod that is not frozen, all of the same length and of second order; ``dim = rods``."""
    rod = wp.tid()
    if rods.status[rod] == OK:
        at = times_of(pace, rod)
        t = at[0] + clock[STEP]
        order = wp.min(pace.levels[rod], 2)
        pace.order[rod] = order
        ratio = real(0.0)
        if order == 2:
            ratio = clock[STEP] / (at[0] - at[1])
        formula = formula_of(at, order, t)
        extrapolate(rod, now, past, formula, star, slope)
        extrapolate_force(rod, external, ratio, balance)
        step_shape(rod, rods, star, slope, formula.rate, balance)
        status = status_of(rod, rods, star)
        if status == OK:
            accept(rod, rods, star, now, past, balance, pace, midpoint, t)
        else:
            rods.status[rod] = status
            failed_at[rod] = at[0]


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
        extrapolate(rod, now, past, formula, star, slope)
        step_shape(rod, rods, star, slope, formula.rate, balance)
        status = status_of(rod, rods, star)
        levels = pace.levels[rod]
        error = real(1.0e6)
        if status == OK:
            # Before a second level is known, the whole first step counts as its error.
            scale = real(1.0)
            known = wp.min(order + 1, levels)
            if known > order:
                scale = local_error_scale(at, order, t)
            error = scale * error_of(rod, weights_at(at, known, t), now, past, star) / target[1]
        if error > real(1.0):
            if t - at[0] < SHORTEST * (wp.abs(t) + target[2]):
                rods.status[rod] = wp.max(status, NOT_FINITE)
                failed_at[rod] = at[0]
            reject(pace, rod, step_factor(error, order))
        else:
            same = step_factor(error, order)
            lower, higher = real(0.0), real(0.0)
            ready = pace.waited[rod] >= order
            if ready and order > 1:
                distance = error_of(rod, weights_at(at, order, t), now, past, star)
                lower = step_factor(local_error_scale(at, order - 1, t) * distance / target[1], order - 1)
            if ready and order < pace.highest_order[rod] and levels > order + 1:
                distance = error_of(rod, weights_at(at, order + 2, t), now, past, star)
                higher = step_factor(local_error_scale(at, order + 1, t) * distance / target[1], order + 1)
            accept(rod, rods, star, now, past, balance, pace, midpoint, t)
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
    levels = wp.min(pace.order[rod] + 1, pace.levels[rod])
    w = weights_at(at, levels, t)
    for node in range(now.twist.shape[1]):
        combine_shapes(rod, node, w, now, past, shown)
    rotation[rod] = midpoint.rotation[rod]
    position[rod] = midpoint.position[rod]
    angle[rod] = midpoint.angle[rod]
    if t < at[0]:
        R, r, theta = move_midpoint(rod, midpoint, at, levels_of_rates(pace, rod), at[1], t)
        rotation[rod] = R
        position[rod] = r
        angle[rod] = theta

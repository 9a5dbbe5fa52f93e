"""The end of a step of active rods: status, error, and how its shape becomes the present one."""

import warp as wp

from warp_rods.kernels.free.error import error_of
from warp_rods.kernels.free.formulas import extrapolation
from warp_rods.kernels.free.state import Past, Shape, Swimmers, Trial
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    add,
    all_of,
    copy_of,
    dot,
    larger,
    mul,
    rods_in,
)
from warp_rods.kernels.layout import real
from warp_rods.kernels.multistep import INFINITE, Pace, local_error_scale, times_of
from warp_rods.kernels.status import HALF_TURN, NOT_FINITE, OK, TOO_BENT

wp.set_module_options({"enable_backward": False})


@wp.func
def find_statuses(tile: int, rods: Swimmers, shape: Shape, trial: Trial):
    """OK for rods whose shape is finite and bends by less than half a turn between adjacent nodes."""
    largest_square, non_finite = Lanes(), Lanes()
    for node in range(shape.twist.shape[1]):
        k = shape.bending[tile, node]
        largest_square = larger(largest_square, dot(k, k))
        # Zero times a number is zero; zero times infinity or NaN is NaN.
        non_finite += real(0.0) * (k[0] + k[1] + shape.twist[tile, node] + shape.activity[tile, node])
    for lane in range(rods_in(tile, trial.status.shape[0])):
        status = OK
        if non_finite[lane] != real(0.0):
            status = NOT_FINITE
        elif largest_square[lane] * rods.spacing * rods.spacing > HALF_TURN * HALF_TURN:
            status = TOO_BENT
        trial.status[tile * WIDTH + lane] = status


@wp.func
def errors_of_order(tile: int, shift: int, pace: Pace, trial: Trial, now: Shape, past: Past, star: Shape):
    """Errors of steps of the orders ``trial.order + shift``, from the distance to the extrapolation with a level more.

    Before a second level is known, the whole first step counts as its error.
    """
    error = error_of(tile, extrapolation(tile, pace, trial, shift + 1), now, past, star)
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        order = trial.order[rod] + shift
        if order > 0 and pace.levels[rod] > order:
            error[lane] = local_error_scale(times_of(pace, rod), order, trial.end[rod]) * error[lane]
    return error


@wp.func
def find_errors(tile: int, pace: Pace, trial: Trial, now: Shape, past: Past, star: Shape):
    """Errors of the steps; infinite where the result is not valid."""
    error = errors_of_order(tile, 0, pace, trial, now, past, star)
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        trial.error[rod] = error[lane]
        if trial.status[rod] != OK:
            trial.error[rod] = INFINITE


@wp.func
def push_level(tile: int, node: int, accepted: Lanes, all_accepted: bool, newest: Shape, older: Shape):
    """Copy one level of a node to the next older one, of the rods where ``accepted`` is not zero."""
    copy_of(tile, node, accepted, all_accepted, newest.bending, older.bending)
    copy_of(tile, node, accepted, all_accepted, newest.twist, older.twist)
    copy_of(tile, node, accepted, all_accepted, newest.activity, older.activity)


@wp.func
def store_shape(tile: int, accepted: Lanes, star: Shape, now: Shape, past: Past):
    """Make the shape at the end of the step the present one, of the rods where ``accepted`` is not zero."""
    every = all_of(accepted)
    for node in range(now.twist.shape[1]):
        push_level(tile, node, accepted, every, past.third, past.fourth)
        push_level(tile, node, accepted, every, past.second, past.third)
        push_level(tile, node, accepted, every, past.first, past.second)
        push_level(tile, node, accepted, every, now, past.first)
        push_level(tile, node, accepted, every, star, now)

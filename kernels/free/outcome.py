"""The end of a step of active rods: status, error, and how its shape becomes the present one."""

import warp as wp

from warp_rods.kernels.free.error import error_of
from warp_rods.kernels.free.formulas import extrapolation
from warp_rods.kernels.free.state import Past, Shape, Swimmers, Trial
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    Lanes2D,
    Pairs,
    add,
    all_of,
    dot,
    larger,
    mul,
    rods_in,
    where,
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
def push_pairs(tile: int, node: int, accepted: Lanes, newest: Pairs, older: Pairs):
    """Copy one level of a node to the next older one, of the rods where ``accepted`` is not zero."""
    older[tile, node] = where(accepted, newest[tile, node], older[tile, node])


@wp.func
def push_numbers(tile: int, node: int, accepted: Lanes, newest: Lanes2D, older: Lanes2D):
    """``push_pairs`` of numbers."""
    older[tile, node] = where(accepted, newest[tile, node], older[tile, node])


@wp.func
def push_whole_level(tile: int, node: int, newest: Shape, older: Shape):
    """``push_level`` of all rods: a copy is several times cheaper than a choice for each rod."""
    older.bending[tile, node] = newest.bending[tile, node]
    older.twist[tile, node] = newest.twist[tile, node]
    older.activity[tile, node] = newest.activity[tile, node]


@wp.func
def push_level(tile: int, node: int, accepted: Lanes, newest: Shape, older: Shape):
    """``push_pairs`` of all fields."""
    push_pairs(tile, node, accepted, newest.bending, older.bending)
    push_numbers(tile, node, accepted, newest.twist, older.twist)
    push_numbers(tile, node, accepted, newest.activity, older.activity)


@wp.func
def store_shape(tile: int, accepted: Lanes, star: Shape, now: Shape, past: Past):
    """Make the shape at the end of the step the present one, of the rods where ``accepted`` is not zero."""
    if all_of(accepted):
        for node in range(now.twist.shape[1]):
            push_whole_level(tile, node, past.third, past.fourth)
            push_whole_level(tile, node, past.second, past.third)
            push_whole_level(tile, node, past.first, past.second)
            push_whole_level(tile, node, now, past.first)
            push_whole_level(tile, node, star, now)
        return
    for node in range(now.twist.shape[1]):
        push_level(tile, node, accepted, past.third, past.fourth)
        push_level(tile, node, accepted, past.second, past.third)
        push_level(tile, node, accepted, past.first, past.second)
        push_level(tile, node, accepted, now, past.first)
        push_level(tile, node, accepted, star, now)

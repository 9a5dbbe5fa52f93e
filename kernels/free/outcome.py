"""The end of a step of active rods: status, error, and how its shape becomes the present one."""

import warp as wp

from warp_rods.kernels.free.error import error_of
from warp_rods.kernels.free.state import Past, Shape, Swimmers
from warp_rods.kernels.layout import real
from warp_rods.kernels.multistep import Levels, local_error_scale, weights_at
from warp_rods.kernels.status import HALF_TURN, NOT_FINITE, OK, TOO_BENT

wp.set_module_options({"enable_backward": False})


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
def shape_error(rod: int, at: Levels, order: int, t: real, now: Shape, past: Past, star: Shape):
    """Error of a step of this order to t, from the distance to the extrapolation with one level more."""
    return local_error_scale(at, order, t) * error_of(rod, weights_at(at, order + 1, t), now, past, star)


@wp.func
def error_of_step(rod: int, at: Levels, levels: int, order: int, t: real, now: Shape, past: Past, star: Shape):
    """``shape_error``; before a second level is known, the whole first step counts as its error."""
    if levels > order:
        return shape_error(rod, at, order, t, now, past, star)
    return error_of(rod, weights_at(at, levels, t), now, past, star)


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

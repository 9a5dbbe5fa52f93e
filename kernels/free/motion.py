"""Motion of active rods in space, and the kernel of a step.

The frame of the middle node advances by Magnus steps (4.29). Frames elsewhere are computed from the strains when they
are needed. A rod whose shape becomes non-finite or unresolved keeps its last valid state and gets a status; the other
rods continue.
"""

import warp as wp

from warp_rods.kernels.clock import RATIO, STEP, TIME
from warp_rods.kernels.free.rod import axial_velocity_at_node, roll_rate_after
from warp_rods.kernels.free.state import Balance, ExternalForce, Midpoint, Shape, Swimmers
from warp_rods.kernels.free.step import extrapolate, step_shape
from warp_rods.kernels.layout import Scalars1D, real
from warp_rods.kernels.lie import advance as advance_frame
from warp_rods.kernels.lie import orthonormalise
from warp_rods.kernels.status import NOT_FINITE, OK, TOO_BENT

wp.set_module_options({"enable_backward": False})

HALF_TURN = wp.constant(real(wp.pi))


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
def store_shape(rod: int, star: Shape, now: Shape, change: Shape):
    """Replace the present shape by that at the end of the step."""
    for node in range(now.twist.shape[1]):
        change.bending[rod, node] = star.bending[rod, node] - now.bending[rod, node]
        change.twist[rod, node] = star.twist[rod, node] - now.twist[rod, node]
        change.activity[rod, node] = star.activity[rod, node] - now.activity[rod, node]
        now.bending[rod, node] = star.bending[rod, node]
        now.twist[rod, node] = star.twist[rod, node]
        now.activity[rod, node] = star.activity[rod, node]


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
def advance_midpoint(rod: int, rods: Swimmers, shape: Shape, balance: Balance, clock: Scalars1D, midpoint: Midpoint):
    """Advance the frame of the middle node by the mean of its rates at both ends of the step (4.29)."""
    omega, velocity, roll_rate = midpoint_rates(rod, rods, shape, balance)
    if clock[RATIO] == real(0.0):
        midpoint.angular_velocity[rod] = omega
        midpoint.velocity[rod] = velocity
        midpoint.roll_rate[rod] = roll_rate
    half = real(0.5)
    R, r = advance_frame(
        midpoint.rotation[rod],
        midpoint.position[rod],
        half * (midpoint.angular_velocity[rod] + omega),
        half * (midpoint.velocity[rod] + velocity),
        clock[STEP],
    )
    midpoint.rotation[rod] = orthonormalise(R)
    midpoint.position[rod] = r
    midpoint.angle[rod] += half * clock[STEP] * (midpoint.roll_rate[rod] + roll_rate)
    midpoint.angular_velocity[rod] = omega
    midpoint.velocity[rod] = velocity
    midpoint.roll_rate[rod] = roll_rate


@wp.kernel
def advance(
    rods: Swimmers,
    now: Shape,
    change: Shape,
    midpoint: Midpoint,
    external: ExternalForce,
    clock: Scalars1D,
    failed_at: Scalars1D,
    star: Shape,
    balance: Balance,
):
    """One step of every rod that is not frozen; launch with ``dim = rods``."""
    rod = wp.tid()
    if rods.status[rod] == OK:
        extrapolate(rod, now, change, external, clock[RATIO], star, balance)
        step_shape(rod, rods, star, change, clock, balance)
        status = status_of(rod, rods, star)
        if status == OK:
            advance_midpoint(rod, rods, star, balance, clock, midpoint)
            store_shape(rod, star, now, change)
        else:
            rods.status[rod] = status
            failed_at[rod] = clock[TIME]

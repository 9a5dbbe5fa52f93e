"""Motion of active rods in space, and the kernels of a step.

The middle node's frame moves by Magnus steps (4.29); frames elsewhere follow from the strains when asked for.
A rod whose shape becomes infinite, NaN or unresolvable keeps its last sound state and a status; others go on.
"""

import warp as wp

from warp_rods.kernels.clock import RATIO, STEP, TIME
from warp_rods.kernels.free.rod import axial_at, roll_at
from warp_rods.kernels.free.state import AppliedForce, Flow, Midpoint, Shape, Swimmers, per_rod
from warp_rods.kernels.free.step import extrapolate, step_shape
from warp_rods.kernels.layout import real
from warp_rods.kernels.lie import advance as advance_frame
from warp_rods.kernels.lie import orthonormalise
from warp_rods.kernels.status import NOT_FINITE, SOUND, TOO_BENT

wp.set_module_options({"enable_backward": False})

HALF_TURN = wp.constant(real(wp.pi))


@wp.func
def status_of(rod: int, rods: Swimmers, shape: Shape):
    """Whether a shape is finite, and bends by less than half a turn between two nodes."""
    sharpest = real(0.0)
    total = real(0.0)
    for node in range(shape.twist.shape[1]):
        k = shape.bending[rod, node]
        sharpest = wp.max(sharpest, wp.dot(k, k))
        total += real(0.0) * (k[0] + k[1] + shape.twist[rod, node] + shape.activity[rod, node])
    if total != real(0.0):
        return NOT_FINITE
    if sharpest * rods.spacing * rods.spacing > HALF_TURN * HALF_TURN:
        return TOO_BENT
    return SOUND


@wp.func
def accept(rod: int, star: Shape, now: Shape, change: Shape):
    """Make the end of the step the present."""
    for node in range(now.twist.shape[1]):
        change.bending[rod, node] = star.bending[rod, node] - now.bending[rod, node]
        change.twist[rod, node] = star.twist[rod, node] - now.twist[rod, node]
        change.activity[rod, node] = star.activity[rod, node] - now.activity[rod, node]
        now.bending[rod, node] = star.bending[rod, node]
        now.twist[rod, node] = star.twist[rod, node]
        now.activity[rod, node] = star.activity[rod, node]


@wp.func
def midpoint_rates(rod: int, rods: Swimmers, shape: Shape, flow: Flow):
    """(ω, u) of the middle node in its Bishop frame, and ω0 of the material there."""
    half = real(0.5)
    node = shape.twist.shape[1] // 2
    spin = half * (flow.spin[rod, node - 1] + flow.spin[rod, node])
    u = flow.transverse[rod, node]
    u0 = axial_at(rod, node, flow)
    roll = half * (roll_at(rod, node - 1, rods, shape) + roll_at(rod, node, rods, shape))
    zero = real(0.0)
    if rods.symmetric == 1:  # (C.53), (C.54)
        return wp.vec3d(zero, spin[0], zero), wp.vec3d(zero, u[0], zero), zero
    return wp.vec3d(zero, spin[0], spin[1]), wp.vec3d(u0, u[0], u[1]), roll


@wp.func
def advance_midpoint(rod: int, rods: Swimmers, shape: Shape, flow: Flow, clock: per_rod, midpoint: Midpoint):
    """Move the middle node's frame by the mean of its rates at both ends of the step (4.29)."""
    spin, velocity, roll = midpoint_rates(rod, rods, shape, flow)
    if clock[RATIO] == real(0.0):
        midpoint.spin[rod] = spin
        midpoint.velocity[rod] = velocity
        midpoint.roll[rod] = roll
    half = real(0.5)
    R, r = advance_frame(
        midpoint.rotation[rod],
        midpoint.position[rod],
        half * (midpoint.spin[rod] + spin),
        half * (midpoint.velocity[rod] + velocity),
        clock[STEP],
    )
    midpoint.rotation[rod] = orthonormalise(R)
    midpoint.position[rod] = r
    midpoint.angle[rod] += half * clock[STEP] * (midpoint.roll[rod] + roll)
    midpoint.spin[rod] = spin
    midpoint.velocity[rod] = velocity
    midpoint.roll[rod] = roll


@wp.kernel
def advance(
    rods: Swimmers,
    now: Shape,
    change: Shape,
    midpoint: Midpoint,
    applied: AppliedForce,
    clock: per_rod,
    failed_at: per_rod,
    star: Shape,
    flow: Flow,
):
    """One step of every sound rod; launch with ``dim = rods``."""
    rod = wp.tid()
    if rods.status[rod] == SOUND:
        extrapolate(rod, now, change, applied, clock[RATIO], star, flow)
        step_shape(rod, rods, star, change, clock, flow)
        status = status_of(rod, rods, star)
        if status == SOUND:
            advance_midpoint(rod, rods, star, flow, clock, midpoint)
            accept(rod, star, now, change)
        else:
            rods.status[rod] = status
            failed_at[rod] = clock[TIME]

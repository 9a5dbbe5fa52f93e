"""The end of a step of surface-bound filaments: whether it is valid, and its error (docs/model.md §3.5, §3.9)."""

import warp as wp

from warp_rods.kernels.bound.angles import geodesic_increment
from warp_rods.kernels.bound.levels import History, Plan, geodesic_at, push_geodesic, turn_at
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.layout import Quadruples2D, real
from warp_rods.kernels.magnus import RATES
from warp_rods.kernels.multistep import (
    LEVELS,
    Levels,
    Pace,
    local_error_scale,
    push_time,
    step_factor,
    times_of,
    weights_at,
)
from warp_rods.kernels.status import NOT_FINITE, TOO_BENT, TOO_FAST

wp.set_module_options({"enable_backward": False})

HALF_TURN = wp.constant(real(wp.pi))


@wp.func
def find_new_geodesic(f: Filaments, past: History, plan: Plan, weights: Quadruples2D, rod: int):
    """From Ω* to Ω at the end of the step.

    Ω of a free end stays. To extrapolate it from step to step would amplify round-off as steps grow.
    """
    last = f.geodesic.shape[1] - 1
    end_rate = f.geodesic_rate[rod, last] - plan.geodesic_slope[rod, last]
    for i in range(last + 1):
        f.geodesic[rod, i] += geodesic_increment(f, plan.turn, weights, end_rate, plan.rate[rod], rod, i)
    if f.start_clamped == 0:
        f.geodesic[rod, 0] = past.now[rod, 0]
    if f.end_clamped == 0:
        f.geodesic[rod, last] = past.now[rod, last]


@wp.func
def status_of(f: Filaments, plan: Plan, rod: int, u: wp.vec3d, omega: wp.vec3d, dt: real) -> int:
    """OK if the rod follows its surface, is finite, bends by less than half a turn a cell, and moves by less than L."""
    largest = real(0.0)
    total = real(0.0)
    for i in range(f.geodesic.shape[1]):
        largest = wp.max(largest, wp.abs(f.geodesic[rod, i]))
        total += f.geodesic[rod, i]
    h = f.spacing[rod]
    distance = dt * (wp.length(u) + h * wp.length(omega))
    if not (wp.isfinite(total) and wp.isfinite(distance)):
        return NOT_FINITE
    if largest * h > HALF_TURN:
        return TOO_BENT
    if distance > h * real(f.geodesic.shape[1] - 1):
        return TOO_FAST
    return wp.max(plan.unfit[rod, 0], plan.unfit[rod, 1])


@wp.func
def distance_to(f: Filaments, past: History, w: Levels, rod: int, turn: real) -> real:
    """Root mean square of L (Ω − Σ w Ω) over 1 + that of L Ω, or |ψ − Σ w ψ| if larger."""
    nodes = f.geodesic.shape[1]
    squares, distances = real(0.0), real(0.0)
    for i in range(nodes):
        geodesic = f.geodesic[rod, i]
        d = geodesic - geodesic_at(past, w, rod, i)
        squares += geodesic * geodesic
        distances += d * d
    length = f.spacing[rod] * real(nodes - 1)
    count = real(nodes)
    relative = length * wp.sqrt(distances / count) / (real(1.0) + length * wp.sqrt(squares / count))
    return wp.max(relative, wp.abs(turn - turn_at(past, w, rod)))


@wp.func
def error_of_order(f: Filaments, past: History, at: Levels, rod: int, order: int, t: real, turn: real) -> real:
    """Error of a step of this order in Ω and ψ."""
    return local_error_scale(at, order, t) * distance_to(f, past, weights_at(at, order + 1, t), rod, turn)


@wp.func
def shift_error(
    f: Filaments, past: History, pace: Pace, at: Levels, rod: int, order: int, t: real, u: wp.vec3d
) -> real:
    """Error of a step in the position of the tracked node over L, from the velocity that its last values foretold."""
    levels = wp.min(wp.min(pace.levels[rod] - 1, order), RATES)
    w = weights_at(at, levels, t)
    foretold = wp.vec3d()
    for j in range(levels):
        foretold += w[j] * past.velocity[rod, j]
    length = f.spacing[rod] * real(f.geodesic.shape[1] - 1)
    return (t - at[0]) * wp.length(u - foretold) / (length * real(order + 1))


@wp.func
def error_of_step(
    f: Filaments, past: History, pace: Pace, plan: Plan, rod: int, u: wp.vec3d, turn: real, allowed: real
) -> wp.vec3d:
    """Error of the step in units of what is allowed, and step factors of the orders below and above, or 0."""
    found = wp.vec3d()
    if allowed == real(0.0):
        return found
    at = times_of(pace, rod)
    order = pace.order[rod]
    levels = pace.levels[rod]
    t = plan.end[rod]
    shift = shift_error(f, past, pace, at, rod, order, t, u)
    if levels <= order:  # before a second level is known, the whole first step counts as its error
        found[0] = wp.max(distance_to(f, past, weights_at(at, levels, t), rod, turn), shift) / allowed
        return found
    found[0] = wp.max(error_of_order(f, past, at, rod, order, t, turn), shift) / allowed
    if pace.waited[rod] >= order:
        if order > 1:
            found[1] = step_factor(error_of_order(f, past, at, rod, order - 1, t, turn) / allowed, order - 1)
        if order < pace.highest_order[rod] and levels > order + 1:
            error = wp.max(error_of_order(f, past, at, rod, order + 1, t, turn), shift) / allowed
            found[2] = step_factor(error, order + 1)
    return found


@wp.func
def accept(f: Filaments, past: History, pace: Pace, rod: int, t: real, turn: real, omega: wp.vec3d, u: wp.vec3d):
    """Make the state at t the newest level."""
    push_time(pace, rod, t)
    for i in range(f.geodesic.shape[1]):
        push_geodesic(past, rod, i, f.geodesic[rod, i])
    for k in range(LEVELS - 1):
        j = LEVELS - 1 - k
        past.turn[rod, j] = past.turn[rod, j - 1]
    past.turn[rod, 0] = turn
    for k in range(RATES - 1):
        j = RATES - 1 - k
        past.angular_velocity[rod, j] = past.angular_velocity[rod, j - 1]
        past.velocity[rod, j] = past.velocity[rod, j - 1]
    past.angular_velocity[rod, 0] = omega
    past.velocity[rod, 0] = u

"""The end of a step of surface-bound filaments: whether it is valid, and its error (docs/model.md §3.5, §3.9)."""

import warp as wp

from warp_rods.kernels.bound.angles import geodesic_increment, velocity_increment
from warp_rods.kernels.bound.levels import History, Plan, geodesic_at, push_geodesic, turn_at
from warp_rods.kernels.bound.rod import angular_velocity, node_velocity
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.layout import Quadruples2D, Scalars1D, real
from warp_rods.kernels.magnus import RATES, levels_of_rates, rate_at
from warp_rods.kernels.multistep import (
    INFINITE,
    LEVELS,
    Levels,
    Pace,
    choose_next,
    is_shortest,
    local_error_scale,
    push_time,
    reject,
    step_factor,
    times_of,
    weights_at,
)
from warp_rods.kernels.status import HALF_TURN, NOT_FINITE, OK, TOO_BENT, TOO_FAST, why_frozen

wp.set_module_options({"enable_backward": False})

SHORTEN_INVALID = wp.constant(real(0.25))
"""The ratio of a step to one whose result was not valid."""


@wp.func
def find_new_geodesic(f: Filaments, past: History, plan: Plan, rod: int):
    """From Ω* to Ω at the end of the step.

    Ω of a free end stays. To extrapolate it from step to step would amplify round-off as steps grow.
    """
    last = f.geodesic.shape[1] - 1
    for i in range(last + 1):
        f.geodesic[rod, i] += geodesic_increment(f, plan.turn, rod, i)
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
    foretold = rate_at(past.velocity, rod, weights_at(at, levels_of_rates(pace, rod, order), t))
    length = f.spacing[rod] * real(f.geodesic.shape[1] - 1)
    return (t - at[0]) * wp.length(u - foretold) / (length * real(order + 1))


@wp.func
def find_errors(f: Filaments, past: History, pace: Pace, plan: Plan, rod: int):
    """Errors of the step, and of steps of the orders below and above, where they are wanted and known."""
    at = times_of(pace, rod)
    order = pace.order[rod]
    levels = pace.levels[rod]
    t = plan.end[rod]
    turn = plan.angle[rod]
    shift = shift_error(f, past, pace, at, rod, order, t, plan.velocity[rod])
    plan.lower[rod] = real(-1.0)
    plan.higher[rod] = real(-1.0)
    if levels <= order:  # before a second level is known, the whole first step counts as its error
        plan.error[rod] = wp.max(distance_to(f, past, weights_at(at, levels, t), rod, turn), shift)
        return
    plan.error[rod] = wp.max(error_of_order(f, past, at, rod, order, t, turn), shift)
    if pace.waited[rod] < order:
        return
    if order > 1:
        plan.lower[rod] = error_of_order(f, past, at, rod, order - 1, t, turn)
    if order < pace.highest_order[rod] and levels > order + 1:
        plan.higher[rod] = wp.max(error_of_order(f, past, at, rod, order + 1, t, turn), shift)


@wp.kernel
def judge(f: Filaments, past: History, pace: Pace, plan: Plan, weights: Quadruples2D):
    """The result of the step from the turn δα, whether it is valid, and its error; ``dim = rods``."""
    rod = wp.tid()
    if f.active[rod] == 0:
        plan.error[rod] = real(-1.0)
        return
    find_new_geodesic(f, past, plan, rod)
    plan.angle[rod] = turn_at(past, plan.value[rod], rod)
    u = node_velocity(f, rod, f.tracked)
    omega = angular_velocity(f, rod, f.tracked)
    if f.start_clamped + f.end_clamped == 0:
        node = f.tracked
        increment = real(0.5) * (plan.turn[rod, node - 1] + plan.turn[rod, node])
        plan.angle[rod] = plan.angle[rod] + increment
        du2 = velocity_increment(plan.turn, weights, rod, node)
        K = f.curvature[rod, node]
        u += wp.vec3d(real(0.0), du2, real(0.0))
        spin = plan.rate[rod] * increment + plan.turn_slope[rod]
        omega = wp.vec3d(omega[0] + K[2] * du2, omega[1] - K[1] * du2, spin)
    plan.velocity[rod] = u
    plan.angular_velocity[rod] = omega
    plan.status[rod] = status_of(f, plan, rod, u, omega, plan.end[rod] - pace.at[rod, 0])
    find_errors(f, past, pace, plan, rod)
    if plan.status[rod] != OK:
        plan.error[rod] = INFINITE


@wp.kernel
def repeat_or_accept(f: Filaments, past: History, pace: Pace, plan: Plan, target: Scalars1D):
    """Let a rod repeat a step whose error is above ``target[1]`` with a shorter one; ``dim = rods``.

    A rod is frozen where the shortest step is not valid either.
    """
    rod = wp.tid()
    if f.active[rod] == 0:
        return
    error = plan.error[rod] / target[1]
    if error <= real(1.0):
        return
    f.active[rod] = 0
    start = pace.at[rod, 0]
    if is_shortest(plan.end[rod] - start, start, target[2]):
        f.status[rod] = why_frozen(plan.status[rod])
        past.failed_at[rod] = start
    factor = step_factor(error, pace.order[rod])
    if plan.status[rod] != OK:
        factor = SHORTEN_INVALID
    reject(pace, rod, factor)


@wp.func
def accept(f: Filaments, past: History, pace: Pace, plan: Plan, rod: int):
    """Make the result of the step the newest level."""
    push_time(pace, rod, plan.end[rod], plan.error[rod] * real(plan.together[rod]))
    for i in range(f.geodesic.shape[1]):
        push_geodesic(past, rod, i, f.geodesic[rod, i])
    for k in range(LEVELS - 1):
        j = LEVELS - 1 - k
        past.turn[rod, j] = past.turn[rod, j - 1]
    past.turn[rod, 0] = plan.angle[rod]
    for k in range(RATES - 1):
        j = RATES - 1 - k
        past.angular_velocity[rod, j] = past.angular_velocity[rod, j - 1]
        past.velocity[rod, j] = past.velocity[rod, j - 1]
    past.angular_velocity[rod, 0] = plan.angular_velocity[rod]
    past.velocity[rod, 0] = plan.velocity[rod]


@wp.func
def take_back(f: Filaments, past: History, pace: Pace, rod: int):
    """Return to the state before the step, of a rod that is frozen then."""
    for j in range(LEVELS - 1):
        pace.at[rod, j] = pace.at[rod, j + 1]
        past.turn[rod, j] = past.turn[rod, j + 1]
    pace.levels[rod] = pace.levels[rod] - 1
    for i in range(f.geodesic.shape[1]):
        past.now[rod, i] = past.first[rod, i]
        past.first[rod, i] = past.second[rod, i]
        past.second[rod, i] = past.third[rod, i]
        past.third[rod, i] = past.fourth[rod, i]
    for j in range(RATES - 1):
        past.angular_velocity[rod, j] = past.angular_velocity[rod, j + 1]
        past.velocity[rod, j] = past.velocity[rod, j + 1]


@wp.func
def factor_of(error: real, allowed: real, order: int) -> real:
    """The step factor for an error, 0 for one that is not known."""
    if error < real(0.0):
        return real(0.0)
    return step_factor(error / allowed, order)


@wp.kernel
def choose_next_steps(f: Filaments, pace: Pace, plan: Plan, target: Scalars1D):
    """Step and order of the next steps of rods that have taken one of their own; ``dim = rods``."""
    rod = wp.tid()
    order = pace.order[rod]
    if f.active[rod] == 1 and f.status[rod] == OK and pace.waited[rod] > order:
        lower = factor_of(plan.lower[rod], target[1], order - 1)
        higher = factor_of(plan.higher[rod], target[1], order + 1)
        choose_next(pace, rod, lower, factor_of(plan.error[rod], target[1], order), higher)

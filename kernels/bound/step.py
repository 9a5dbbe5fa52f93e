"""The end of a step of surface-bound filaments: whether it is valid, and its error (docs/model.md §3.5, §3.9)."""

import warp as wp

from warp_rods.kernels.banded import solve_pentadiagonal_rod
from warp_rods.kernels.bound.angles import (
    find_turn_to_velocity,
    geodesic_increment,
    set_angle_rhs,
    set_angle_rows,
    velocity_increment,
)
from warp_rods.kernels.bound.contact import contact_error, find_contact_velocity, set_contact_drag
from warp_rods.kernels.bound.evaluation import evaluate
from warp_rods.kernels.bound.levels import History, Plan, geodesic_at, turn_at
from warp_rods.kernels.bound.rod import angular_velocity, find_loads, is_clamped, node_velocity
from warp_rods.kernels.bound.state import Filaments, Systems
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    add,
    all_of,
    any_of,
    copy_of,
    div,
    larger,
    magnitude,
    mul,
    rods_in,
    sqrt,
    sub,
    where,
)
from warp_rods.kernels.layout import Scalars1D, real
from warp_rods.kernels.magnus import RATES, levels_of_rates, rate_at
from warp_rods.kernels.multistep import (
    INFINITE,
    LEVELS,
    Levels,
    Pace,
    Weights,
    choose_next,
    is_shortest,
    lengths_of,
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
def find_new_geodesic(f: Filaments, systems: Systems, tile: int):
    """From Ω* to Ω at the end of the step; returns the largest |Ω|, and Σ Ω. A free end has Ω* = σ3 already."""
    largest, total = Lanes(), Lanes()
    for i in range(f.geodesic.shape[1]):
        geodesic = f.geodesic[tile, i] + geodesic_increment(f, systems.turn, tile, i)
        f.geodesic[tile, i] = geodesic
        largest = larger(largest, magnitude(geodesic))
        total += geodesic
    return largest, total


@wp.func
def status_of(
    largest: real, total: real, h: real, length: real, dt: real, u: wp.vec3d, omega: wp.vec3d, unfit: int
) -> int:
    """OK if the rod follows its surface, is finite, bends by less than half a turn a cell, and moves by less than L.

    largest: |Ω|; total: Σ Ω.
    """
    distance = dt * (wp.length(u) + h * wp.length(omega))
    if not (wp.isfinite(total) and wp.isfinite(distance)):
        return wp.max(unfit, NOT_FINITE)  # beside a kink curvatures may be infinite
    if largest * h > HALF_TURN:
        return TOO_BENT
    if distance > length:
        return TOO_FAST
    return unfit


@wp.func
def distances_to(f: Filaments, past: History, w: Weights, tile: int) -> Lanes:
    """Root mean square of L (Ω − Σ w Ω) over 1 + that of L Ω."""
    nodes = f.geodesic.shape[1]
    squares, distances = Lanes(), Lanes()
    for i in range(nodes):
        geodesic = f.geodesic[tile, i]
        d = geodesic - geodesic_at(past, w, tile, i)
        squares += geodesic * geodesic
        distances += d * d
    length = f.spacing[tile] * real(nodes - 1)
    count = real(nodes)
    return length * sqrt(distances / count) / (real(1.0) + length * sqrt(squares / count))


@wp.func
def errors_of_order(f: Filaments, past: History, pace: Pace, plan: Plan, tile: int, change: int) -> Lanes:
    """Errors in Ω and ψ of steps of the orders of the rods and ``change``.

    Before a level more than the order is known, the whole first step counts as its error.
    """
    w, scale, turned = Weights(), Lanes(), Lanes()
    for lane in range(rods_in(tile, f.status.shape[0])):
        rod = tile * WIDTH + lane
        order = pace.order[rod] + change
        at, t, levels = times_of(pace, rod), plan.end[rod], pace.levels[rod]
        e = weights_at(at, wp.min(order + 1, levels), t)
        scale[lane] = real(1.0)
        if levels > order:
            scale[lane] = local_error_scale(at, order, t)
        for j in range(LEVELS):
            w[j, lane] = e[j]
        turned[lane] = wp.abs(plan.angle[rod] - turn_at(past, e, rod))
    return scale * larger(distances_to(f, past, w, tile), turned)


@wp.func
def shift_error(
    f: Filaments, past: History, pace: Pace, at: Levels, rod: int, order: int, t: real, u: wp.vec3d
) -> real:
    """Error of a step in the position of the tracked node over L, from the velocity that its last values foretold."""
    foretold = rate_at(past.velocity, rod, weights_at(at, levels_of_rates(pace, rod, order), t))
    length = f.spacing_of_rod[rod] * real(f.geodesic.shape[1] - 1)
    return (t - at[0]) * wp.length(u - foretold) / (length * real(order + 1))


@wp.func
def find_errors(f: Filaments, past: History, pace: Pace, plan: Plan, tile: int):
    """Errors of the step, and of steps of the orders below and above, where they are wanted and known."""
    same = errors_of_order(f, past, pace, plan, tile, 0)
    below, above = Lanes(), Lanes()
    wanted = Lanes()
    for lane in range(rods_in(tile, f.status.shape[0])):
        rod = tile * WIDTH + lane
        wanted[lane] = real(may_change(pace, plan, rod))
    if any_of(wanted):
        below = errors_of_order(f, past, pace, plan, tile, -1)
        above = errors_of_order(f, past, pace, plan, tile, 1)
    for lane in range(rods_in(tile, f.status.shape[0])):
        rod = tile * WIDTH + lane
        order = pace.order[rod]
        shift = shift_error(f, past, pace, times_of(pace, rod), rod, order, plan.end[rod], plan.velocity[rod])
        plan.error[rod] = wp.max(same[lane], shift)
        plan.lower[rod] = real(-1.0)
        plan.higher[rod] = real(-1.0)
        if may_change(pace, plan, rod) == 1:
            if order > 1:
                plan.lower[rod] = below[lane]
            if order < pace.highest_order[rod] and pace.levels[rod] > order + 1:
                plan.higher[rod] = wp.max(above[lane], shift)


@wp.func
def may_change(pace: Pace, plan: Plan, rod: int) -> int:
    """1 if the order of the next step may change."""
    order = pace.order[rod]
    return wp.where(plan.together[rod] == 0 and pace.levels[rod] > order and pace.waited[rod] >= order, 1, 0)


@wp.func
def find_angle(f: Filaments, past: History, plan: Plan, systems: Systems, tile: int):
    """δα at half nodes, by which the rod turns beyond the extrapolated state."""
    slope = plan.slope[tile]
    rate = plan.rate[tile]
    find_turn_to_velocity(f, tile, systems.weights)
    set_angle_rows(f, tile, rate, systems)
    for i in range(f.geodesic.shape[1]):
        systems.rhs[tile, i] = geodesic_at(past, slope, tile, i)
    set_angle_rhs(f, tile, systems.rhs, plan.turn_slope[tile], rate, systems.turn)
    solve_pentadiagonal_rod(
        tile,
        systems.lower2,
        systems.lower,
        systems.diagonal,
        systems.upper,
        systems.upper2,
        systems.turn,
        systems.work_pairs,
        systems.turn,
    )


@wp.func
def find_tracked_rates(f: Filaments, past: History, plan: Plan, systems: Systems, tile: int):
    """Velocity, angular velocity and angle of the tracked node at the end of the step; a clamp has no spin."""
    node = f.tracked
    u, omega = node_velocity(f, tile, node), angular_velocity(f, tile, node)
    increment = Lanes()
    u2, omega0, omega1, omega2 = u[1], omega[0], omega[1], Lanes()
    if not is_clamped(f, node):
        increment = real(0.5) * (systems.turn[tile, node - 1] + systems.turn[tile, node])
        du2 = velocity_increment(systems.turn, systems.weights, tile, node)
        K = f.curvature[tile, node]
        u2 += du2
        omega0 += K[2] * du2
        omega1 -= K[1] * du2
        omega2 = plan.rate[tile] * increment + plan.turn_slope[tile]
    value = plan.value[tile]
    for lane in range(rods_in(tile, f.status.shape[0])):
        rod = tile * WIDTH + lane
        plan.velocity[rod] = wp.vec3d(u[0, lane], u2[lane], u[2, lane])
        plan.angular_velocity[rod] = wp.vec3d(omega0[lane], omega1[lane], omega2[lane])
        angle = increment[lane]
        for j in range(LEVELS):
            angle += value[j, lane] * past.turn[rod, j]
        plan.angle[rod] = angle


@wp.func
def judge(f: Filaments, past: History, pace: Pace, plan: Plan, systems: Systems, tile: int):
    """The result of the step from the turn δα, whether it is valid, and its error."""
    largest, total = find_new_geodesic(f, systems, tile)
    h = f.spacing[tile]
    find_errors(f, past, pace, plan, tile)
    for lane in range(rods_in(tile, f.status.shape[0])):
        rod = tile * WIDTH + lane
        length = h[lane] * real(f.geodesic.shape[1] - 1)
        dt = plan.end[rod] - pace.at[rod, 0]
        u, omega = plan.velocity[rod], plan.angular_velocity[rod]
        plan.status[rod] = status_of(largest[lane], total[lane], h[lane], length, dt, u, omega, int(plan.unfit[rod]))


@wp.kernel
def try_step(f: Filaments, past: History, pace: Pace, plan: Plan, systems: Systems):
    """From the extrapolated state to the result of the step, its status and its error; ``dim = tiles``."""
    tile = wp.tid()
    find_loads(f, tile)
    if f.in_contact == 1:
        set_contact_drag(f, past, pace, plan, tile)
    evaluate(f, tile, systems)
    find_angle(f, past, plan, systems, tile)
    find_tracked_rates(f, past, plan, systems, tile)
    errors = Lanes(real(-1.0))
    if f.in_contact == 1:
        dt = lengths_of(tile, pace, plan.end)
        errors = contact_error(f, past, systems, tile, dt)
        find_contact_velocity(f, past, plan, systems, tile, dt)
    judge(f, past, pace, plan, systems, tile)
    for lane in range(rods_in(tile, f.status.shape[0])):
        rod = tile * WIDTH + lane
        plan.error[rod] = wp.max(plan.error[rod], errors[lane])
        if plan.status[rod] != OK:
            plan.error[rod] = INFINITE
        if f.active[rod] == 0:
            plan.error[rod] = real(-1.0)


@wp.func
def repeat_or_accept(f: Filaments, past: History, pace: Pace, plan: Plan, target: Scalars1D, rod: int):
    """Let a rod repeat a step whose error is above ``target[1]`` with a shorter one.

    A rod is frozen where the shortest step is not valid either.
    """
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
    reject(pace, rod, pace.step[rod], factor)


@wp.func
def accept(past: History, pace: Pace, plan: Plan, rod: int):
    """Make the result of the step the newest level, but for Ω."""
    push_time(pace, rod, plan.end[rod], plan.error[rod] * real(plan.together[rod]))
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
def take_back(past: History, pace: Pace, rod: int):
    """Return to the state before the step, of a rod that is frozen then."""
    for j in range(LEVELS - 1):
        pace.at[rod, j] = pace.at[rod, j + 1]
        past.turn[rod, j] = past.turn[rod, j + 1]
    pace.levels[rod] = pace.levels[rod] - 1
    for j in range(RATES - 1):
        past.angular_velocity[rod, j] = past.angular_velocity[rod, j + 1]
        past.velocity[rod, j] = past.velocity[rod, j + 1]


@wp.func
def keep_fields(f: Filaments, past: History, tile: int, taken: Lanes):
    """Make Ω of the step, and its velocity of contact, the newest ones of the rods that have taken it."""
    every = all_of(taken)
    for i in range(f.geodesic.shape[1]):
        copy_of(tile, i, taken, every, past.third, past.fourth)
        copy_of(tile, i, taken, every, past.second, past.third)
        copy_of(tile, i, taken, every, past.first, past.second)
        copy_of(tile, i, taken, every, past.now, past.first)
        copy_of(tile, i, taken, every, f.geodesic, past.now)
    if f.in_contact == 1:
        for i in range(f.geodesic.shape[1]):
            copy_of(tile, i, taken, every, past.contact_velocity_tried, past.contact_velocity)
            copy_of(tile, i, taken, every, past.contact_lag_tried, past.contact_lag)


@wp.func
def factor_of(error: real, allowed: real, order: int) -> real:
    """The step factor for an error, 0 for one that is not known."""
    if error < real(0.0):
        return real(0.0)
    return step_factor(error / allowed, order)


@wp.func
def choose_next_step(f: Filaments, pace: Pace, plan: Plan, target: Scalars1D, rod: int):
    """Step and order of the next step of a rod that may have taken one of its own."""
    order = pace.order[rod]
    if f.active[rod] == 1 and f.status[rod] == OK and pace.waited[rod] > order:
        lower = factor_of(plan.lower[rod], target[1], order - 1)
        higher = factor_of(plan.higher[rod], target[1], order + 1)
        choose_next(pace, rod, lower, factor_of(plan.error[rod], target[1], order), higher)

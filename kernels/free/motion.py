"""Motion of the tracked node of active rods (docs/model.md §2.6). Frames elsewhere follow from the strains.

It is a held end, if there is one, otherwise the middle node.

In steps of its own a rod advances this frame by Magnus steps of its rates (4.29), of the order of the strains.
In equal steps it takes the backward formula of the strains: forces restore places, which depend on both,
and stiff ones are stable only if both are advanced alike.

A background flow carries free rods: their frames are integrated in axes that move with the flow at the tracked node,
without turning, and how far these have moved is added to places.
"""

import warp as wp

from warp_rods.kernels.free.rod import axial_velocity_at_node, roll_rate_after, roll_rate_at_end
from warp_rods.kernels.free.state import (
    CARRIED_ALIKE,
    CARRIED_APART,
    CLAMPED,
    Balance,
    Carrier,
    End,
    Midpoint,
    Shape,
    Swimmers,
    Trial,
)
from warp_rods.kernels.lanes import WIDTH, Pair, add, mul, pair, rods_in, sub, vector  # noqa: F401 (operators)
from warp_rods.kernels.layout import real
from warp_rods.kernels.lie import orthonormalise, se3_compose, se3_exp, se3_inverse, se3_log
from warp_rods.kernels.magnus import RATES, levels_of_rates, mean_over, rate_at, twist_over
from warp_rods.kernels.multistep import Formula, Levels, Pace, times_of, weights_at

wp.set_module_options({"enable_backward": False})


@wp.func
def extrapolated(near: Pair, far: Pair):
    """A field at an end from the half nodes beside it."""
    return real(1.5) * near - real(0.5) * far


@wp.func
def rates_of_end(tile: int, end: End, near: int, far: int, side: real, rods: Swimmers, shape: Shape, balance: Balance):
    """``tracked_rates`` of a held end, beside the half nodes ``near`` and ``far``."""
    w = end.angular_velocity[tile]
    omega = pair(w[1], w[2])
    roll_rate = real(1.0) * w[0]
    if end.kind != CLAMPED:
        omega = extrapolated(balance.angular_velocity[tile, near], balance.angular_velocity[tile, far])
        roll_rate = roll_rate_at_end(tile, near, side, rods, shape, balance)
    return omega, real(1.0) * end.velocity[tile], roll_rate


@wp.func
def tracked_rates(tile: int, rods: Swimmers, shape: Shape, balance: Balance):
    """(ω, u) of the Bishop frame of the tracked node, and ω0 of the material there."""
    half = real(0.5)
    node = rods.tracked
    last = shape.twist.shape[1] - 1
    if node == 0:
        return rates_of_end(tile, rods.first, 0, 1, real(-1.0), rods, shape, balance)
    if node == last:
        return rates_of_end(tile, rods.last, last - 1, last - 2, real(1.0), rods, shape, balance)
    omega = half * (balance.angular_velocity[tile, node - 1] + balance.angular_velocity[tile, node])
    before = roll_rate_after(tile, node - 1, rods, shape, balance)
    roll_rate = half * (before + roll_rate_after(tile, node, rods, shape, balance))
    u = vector(axial_velocity_at_node(tile, node, balance), balance.transverse_velocity[tile, node])
    return omega, u, roll_rate


@wp.func
def find_midpoint_rates(tile: int, rods: Swimmers, shape: Shape, balance: Balance, trial: Trial):
    """Rates of the tracked node at the end of the step that is tried."""
    omega, u, roll_rate = tracked_rates(tile, rods, shape, balance)
    free = real(1 - rods.symmetric)  # (C.53), (C.54)
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        trial.angular_velocity[rod] = wp.vec3d(real(0.0), omega[0, lane], free * omega[1, lane])
        trial.velocity[rod] = wp.vec3d(free * u[0, lane], u[1, lane], free * u[2, lane])
        trial.roll_rate[rod] = free * roll_rate[lane]


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
def frame_error(rod: int, pace: Pace, midpoint: Midpoint, order: int, t: real, omega: wp.vec3d, u: wp.vec3d):
    """Error of a step to t in the place and direction of the middle frame, from the rates that the last ones foretold.

    Length of a rod, radian. ``omega`` and ``u`` are the rates found at t.
    """
    at = times_of(pace, rod)
    w = weights_at(at, levels_of_rates(pace, rod, order), t)
    foretold_omega = rate_at(midpoint.angular_velocity, rod, w)
    foretold_u = rate_at(midpoint.velocity, rod, w)
    distance = wp.max(wp.length(omega - foretold_omega), wp.length(u - foretold_u))
    return (t - at[0]) * distance / real(order + 1)


# --- Magnus steps -----------------------------------------------------------------------------------------------


@wp.func
def carried_midpoint(
    rod: int,
    midpoint: Midpoint,
    R0: wp.mat33d,
    r0: wp.vec3d,
    angle: real,
    at: Levels,
    levels: int,
    start: real,
    end: real,
):
    """The middle frame and its angle at the time ``end``, from those at ``start`` (4.29).

    The rates are the polynomial through this many levels.
    """
    theta, mu = twist_over(midpoint.angular_velocity, midpoint.velocity, rod, at, levels, start, end)
    Q, q = se3_exp(theta, mu)
    R, r = se3_compose(R0, r0, Q, q)
    roll = mean_over(midpoint.roll_rate, rod, at, levels, start, end)
    return orthonormalise(R), r, angle + (end - start) * roll


@wp.func
def foretold_angle(rod: int, midpoint: Midpoint, pace: Pace, end: real):
    """θ at the end of a step, from its rates at the levels before, as far as they are known."""
    at = times_of(pace, rod)
    levels = levels_of_rates(pace, rod, wp.max(pace.order[rod], 2))
    if levels < 1:
        return midpoint.angle[rod]
    return midpoint.angle[rod] + (end - at[0]) * mean_over(midpoint.roll_rate, rod, at, levels, at[0], end)


# --- The backward formula -----------------------------------------------------------------------------------------


@wp.func
def last_screw(rod: int, midpoint: Midpoint):
    """ξ = log(S_(n−1)⁻¹ S_n), the last step of the middle frame, the same in both frames; and that of its angle."""
    Q, q = se3_inverse(midpoint.rotation_before[rod], midpoint.position_before[rod])
    R, r = se3_compose(Q, q, midpoint.rotation[rod], midpoint.position[rod])
    theta, mu = se3_log(R, r)
    return theta, mu, midpoint.angle[rod] - midpoint.angle_before[rod]


@wp.func
def turned_midpoint(rod: int, midpoint: Midpoint, theta: wp.vec3d, mu: wp.vec3d, roll: real):
    """S_n exp(θ, µ), and the angle increased by ``roll``."""
    Q, q = se3_exp(theta, mu)
    R, r = se3_compose(midpoint.rotation[rod], midpoint.position[rod], Q, q)
    return orthonormalise(R), r, midpoint.angle[rod] + roll


@wp.func
def foretold_midpoint(rod: int, midpoint: Midpoint, formula: Formula):
    """The extrapolated middle frame of a step of order 2 at most: x* = −e_1 ξ, where x is the screw from S_n."""
    if formula.order == 1:
        return midpoint.rotation[rod], midpoint.position[rod], midpoint.angle[rod]
    theta, mu, roll = last_screw(rod, midpoint)
    e = -formula.value[1]
    return turned_midpoint(rod, midpoint, e * theta, e * mu, e * roll)


@wp.func
def stepped_midpoint(rod: int, midpoint: Midpoint, formula: Formula, omega: wp.vec3d, u: wp.vec3d, roll_rate: real):
    """The middle frame after a step of order 2 at most: x = x* + (A + d_1 ξ)/a, with A = (ω, u) at its end."""
    scale = real(1.0) / formula.rate
    if formula.order == 1:
        return turned_midpoint(rod, midpoint, scale * omega, scale * u, scale * roll_rate)
    theta, mu, roll = last_screw(rod, midpoint)
    b = scale * formula.slope[1] - formula.value[1]
    return turned_midpoint(rod, midpoint, b * theta + scale * omega, b * mu + scale * u, b * roll + scale * roll_rate)


# --- The flow that carries a rod ----------------------------------------------------------------------------------


@wp.func
def carried_so_far(rod: int, carrier: Carrier, at: Levels, t: real):
    """How far the flow has carried a rod by a time t within its last step, or at its end."""
    carried = wp.vec3d()
    if carrier.kind == CARRIED_ALIKE:
        carried = t * carrier.uniform
    elif carrier.kind == CARRIED_APART:
        carried = carrier.displacement[rod]
        if t < at[0]:  # the parabola with the velocity at the end
            h = at[0] - at[1]
            x = (t - at[1]) / h
            before = carrier.displacement_before[rod]
            moved = carried - before
            carried = before + x * moved + x * (x - real(1.0)) * (h * carrier.velocity[rod, 0] - moved)
    return carried


@wp.func
def foretold_carried(rod: int, carrier: Carrier, formula: Formula, t: real):
    """``carried_so_far`` extrapolated to the end t of a step."""
    carried = wp.vec3d()
    if carrier.kind == CARRIED_ALIKE:
        carried = t * carrier.uniform
    elif carrier.kind == CARRIED_APART:
        carried = carrier.displacement[rod]
        if formula.order > 1:
            carried -= formula.value[1] * (carried - carrier.displacement_before[rod])
    return carried


@wp.func
def carry(rod: int, tracked: int, carrier: Carrier, formula: Formula):
    """Carry a rod over a step of order 2 at most, by the backward formula."""
    u = carrier.stream[rod, tracked]
    here = carrier.displacement[rod]
    step = u / formula.rate
    if formula.order > 1:
        last = here - carrier.displacement_before[rod]
        step = (u + formula.slope[1] * last) / formula.rate - formula.value[1] * last
    carrier.displacement_before[rod] = here
    carrier.displacement[rod] = here + step
    for k in range(RATES - 1):
        j = RATES - 1 - k
        carrier.velocity[rod, j] = carrier.velocity[rod, j - 1]
    carrier.velocity[rod, 0] = u


@wp.func
def carrier_error(rod: int, tracked: int, pace: Pace, carrier: Carrier, order: int, t: real):
    """Error of a step to t in how far the flow carries a rod, from the velocities that the last ones foretold."""
    at = times_of(pace, rod)
    foretold = rate_at(carrier.velocity, rod, weights_at(at, levels_of_rates(pace, rod, order), t))
    return (t - at[0]) * wp.length(carrier.stream[rod, tracked] - foretold) / real(order + 1)


# --- The end of a step ----------------------------------------------------------------------------------------------


@wp.func
def store_midpoint(rod: int, midpoint: Midpoint, R: wp.mat33d, r: wp.vec3d, angle: real):
    """Make this the middle frame, and keep where it was."""
    midpoint.rotation_before[rod] = midpoint.rotation[rod]
    midpoint.position_before[rod] = midpoint.position[rod]
    midpoint.angle_before[rod] = midpoint.angle[rod]
    midpoint.rotation[rod] = R
    midpoint.position[rod] = r
    midpoint.angle[rod] = angle


@wp.func
def carry_midpoint(rod: int, pace: Pace, midpoint: Midpoint):
    """Carry the middle frame over the last step by the rates of its end and before."""
    at = times_of(pace, rod)
    levels = levels_of_rates(pace, rod, wp.max(pace.order[rod], 2))
    R0 = midpoint.rotation[rod]
    R, r, angle = carried_midpoint(
        rod, midpoint, R0, midpoint.position[rod], midpoint.angle[rod], at, levels, at[1], at[0]
    )
    store_midpoint(rod, midpoint, R, r, angle)

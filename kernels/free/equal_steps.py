"""A step of active rods, all of the same length: it is foretold, tried, and then accepted or rejected.

The order is 2, and 1 from the start. Nothing of the present state changes before the step is accepted. A rod whose
result is not valid keeps its last state and gets a status; the other rods continue.
"""

import warp as wp

from warp_rods.kernels.clock import STEP
from warp_rods.kernels.free.load import contact_error, keep_velocity, step_velocity
from warp_rods.kernels.free.motion import (
    foretold_midpoint,
    frame_error,
    midpoint_rates,
    push_rates,
    stepped_midpoint,
    store_midpoint,
)
from warp_rods.kernels.free.outcome import error_of_step, status_of, store_shape
from warp_rods.kernels.free.state import Balance, Contact, Midpoint, Past, Shape, Swimmers, Trial
from warp_rods.kernels.free.step import find_slope, find_value, step_shape
from warp_rods.kernels.layout import Matrices1D, Scalars1D, Vectors1D, real
from warp_rods.kernels.multistep import INFINITE, Pace, formula_of, push_time, times_of
from warp_rods.kernels.status import OK

wp.set_module_options({"enable_backward": False})


@wp.kernel
def predict(rods: Swimmers, now: Shape, past: Past, pace: Pace, clock: Scalars1D, trial: Trial, star: Shape):
    """When the step ends, its order, and the extrapolated shape x*, that of now for a frozen rod; ``dim = rods``."""
    rod = wp.tid()
    at = times_of(pace, rod)
    t = at[0] + clock[STEP]
    order = wp.min(pace.levels[rod], 2)
    formula = formula_of(at, order, t)
    trial.end[rod] = t
    trial.order[rod] = order
    trial.rate[rod] = formula.rate
    trial.error[rod] = real(-1.0)
    if rods.status[rod] != OK:
        formula = formula_of(at, 1, t)
    find_value(rod, formula.value, now, past, star)


@wp.kernel
def predict_midpoint(
    rods: Swimmers,
    pace: Pace,
    midpoint: Midpoint,
    trial: Trial,
    rotation: Matrices1D,
    position: Vectors1D,
    angle: Scalars1D,
):
    """The extrapolated middle frame, that of now for a frozen rod; ``dim = rods``."""
    rod = wp.tid()
    order = trial.order[rod]
    if rods.status[rod] != OK:
        order = 1
    R, r, theta = foretold_midpoint(rod, midpoint, formula_of(times_of(pace, rod), order, trial.end[rod]))
    rotation[rod] = R
    position[rod] = r
    angle[rod] = theta


@wp.kernel
def try_step(
    rods: Swimmers,
    now: Shape,
    past: Past,
    midpoint: Midpoint,
    pace: Pace,
    trial: Trial,
    contact: Contact,
    star: Shape,
    slope: Shape,
    balance: Balance,
):
    """From x* to the shape at the end of the step, with its status and its error; ``dim = rods``."""
    rod = wp.tid()
    if rods.status[rod] != OK:
        return
    at = times_of(pace, rod)
    t = trial.end[rod]
    order = trial.order[rod]
    formula = formula_of(at, order, t)
    find_slope(rod, formula.slope, now, past, slope)
    step_shape(rod, rods, star, slope, formula.rate, balance)
    omega, u, roll_rate = midpoint_rates(rod, rods, star, balance)
    status = status_of(rod, rods, star)
    error = INFINITE
    if status == OK:
        error = error_of_step(rod, at, pace.levels[rod], order, t, now, past, star)
        if rods.forced == 1:
            error = wp.max(error, frame_error(rod, pace, midpoint, order, t, omega, u))
    if contact.present == 1:
        error = wp.max(error, contact_error(rod, rods, contact, balance, t - at[0]))
        step_velocity(rod, contact, balance, formula.rate, t - at[0])
    trial.status[rod] = status
    trial.error[rod] = error
    trial.angular_velocity[rod] = omega
    trial.velocity[rod] = u
    trial.roll_rate[rod] = roll_rate


@wp.kernel
def accept_step(
    rods: Swimmers,
    now: Shape,
    past: Past,
    midpoint: Midpoint,
    pace: Pace,
    trial: Trial,
    contact: Contact,
    star: Shape,
    failed_at: Scalars1D,
):
    """Make the result of the step the present state, or freeze a rod without a valid one; ``dim = rods``."""
    rod = wp.tid()
    if rods.status[rod] != OK:
        return
    if trial.status[rod] != OK:
        rods.status[rod] = trial.status[rod]
        failed_at[rod] = pace.at[rod, 0]
        return
    t = trial.end[rod]
    formula = formula_of(times_of(pace, rod), trial.order[rod], t)
    omega, u, roll_rate = trial.angular_velocity[rod], trial.velocity[rod], trial.roll_rate[rod]
    R, r, angle = stepped_midpoint(rod, midpoint, formula, omega, u, roll_rate)
    store_midpoint(rod, midpoint, R, r, angle)
    push_rates(rod, midpoint, omega, u, roll_rate)
    store_shape(rod, star, now, past)
    push_time(pace, rod, t, trial.error[rod])
    pace.order[rod] = formula.order
    if contact.present == 1:
        keep_velocity(rod, contact)


@wp.kernel
def reject_step(rods: Swimmers, pace: Pace):
    """Count the step as repeated; ``dim = rods``."""
    rod = wp.tid()
    if rods.status[rod] == OK:
        pace.rejected[rod] = pace.rejected[rod] + 1

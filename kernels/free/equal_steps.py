"""A step of active rods, all of the same length: it is foretold, tried, and then accepted or rejected.

The order is 2, and 1 from the start. Nothing of the present state changes before the step is accepted. A rod whose
result is not valid keeps its last state and gets a status; the other rods continue.
"""

import warp as wp

from warp_rods.kernels.clock import STEP
from warp_rods.kernels.free.formulas import formulas_of
from warp_rods.kernels.free.load import contact_errors, keep_velocity, step_velocity
from warp_rods.kernels.free.motion import (
    carrier_error,
    carry,
    find_midpoint_rates,
    foretold_carried,
    foretold_midpoint,
    frame_error,
    push_rates,
    stepped_midpoint,
    store_midpoint,
)
from warp_rods.kernels.free.outcome import find_errors, find_statuses, store_shape
from warp_rods.kernels.free.state import (
    CARRIED_APART,
    NOT_CARRIED,
    Balance,
    Contact,
    Midpoint,
    Past,
    Shape,
    Swimmers,
    Trial,
)
from warp_rods.kernels.free.step import find_slope, find_value, step_shape
from warp_rods.kernels.lanes import WIDTH, Lanes, repeat_last, rods_in
from warp_rods.kernels.layout import Matrices1D, Scalars1D, Vectors1D, real
from warp_rods.kernels.multistep import Pace, formula_of, lengths_of, push_time, times_of
from warp_rods.kernels.status import OK

wp.set_module_options({"enable_backward": False})


@wp.kernel
def predict(rods: Swimmers, now: Shape, past: Past, pace: Pace, clock: Scalars1D, trial: Trial, star: Shape):
    """When the step ends, its order, and the extrapolated shape x*, that of now for a frozen rod; ``dim = tiles``."""
    tile = wp.tid()
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        trial.end[rod] = pace.at[rod, 0] + clock[STEP]
        trial.order[rod] = wp.min(pace.levels[rod], 2)
        if rods.status[rod] != OK:
            trial.order[rod] = 1
        trial.error[rod] = real(-1.0)
    find_value(tile, formulas_of(tile, pace, trial).value, now, past, star)


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
    """The extrapolated frame of the tracked node, that of now for a frozen rod; ``dim = rods``."""
    rod = wp.tid()
    formula = formula_of(times_of(pace, rod), trial.order[rod], trial.end[rod])
    R, r, theta = foretold_midpoint(rod, midpoint, formula)
    t = trial.end[rod]
    if rods.status[rod] != OK:
        t = pace.at[rod, 0]
    rotation[rod] = R
    position[rod] = r
    if midpoint.carrier.kind != NOT_CARRIED:
        position[rod] = r + foretold_carried(rod, midpoint.carrier, formula, t)
    angle[rod] = theta
    trial.angle[rod] = theta


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
    """From x* to the shape at the end of the step, with its status and its error; ``dim = tiles``."""
    tile = wp.tid()
    formulas = formulas_of(tile, pace, trial)
    find_slope(tile, formulas.slope, now, past, slope)
    step_shape(tile, rods, star, slope, formulas.rate, trial.angle, balance)
    find_midpoint_rates(tile, rods, star, balance, trial)
    find_statuses(tile, rods, star, trial)
    find_errors(tile, pace, trial, now, past, star)
    if rods.forced == 1:
        count_frame_errors(tile, rods.tracked, pace, midpoint, trial)
    if contact.present == 1:
        dt = lengths_of(tile, pace, trial.end)
        count_errors(tile, contact_errors(tile, rods, contact, balance, dt), trial)
        step_velocity(tile, contact, balance, formulas.rate, dt)
    forget_frozen(tile, rods, trial)


@wp.func
def count_frame_errors(tile: int, tracked: int, pace: Pace, midpoint: Midpoint, trial: Trial):
    """Let errors of steps count those of the middle frame, and of how far a flow carries it."""
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        omega, u = trial.angular_velocity[rod], trial.velocity[rod]
        error = frame_error(rod, pace, midpoint, trial.order[rod], trial.end[rod], omega, u)
        if midpoint.carrier.kind == CARRIED_APART:
            carried = carrier_error(rod, tracked, pace, midpoint.carrier, trial.order[rod], trial.end[rod])
            error = wp.max(error, carried)
        trial.error[rod] = wp.max(trial.error[rod], error)


@wp.func
def count_errors(tile: int, errors: Lanes, trial: Trial):
    """Let errors of steps count these."""
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        trial.error[rod] = wp.max(trial.error[rod], errors[lane])


@wp.func
def forget_frozen(tile: int, rods: Swimmers, trial: Trial):
    """A frozen rod takes no step: its error is none, its status stays."""
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        if rods.status[rod] != OK:
            trial.status[rod] = rods.status[rod]
            trial.error[rod] = real(-1.0)


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
    """Make the result of the step the present state, or freeze a rod without a valid one; ``dim = tiles``."""
    tile = wp.tid()
    accepted = Lanes()
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        if rods.status[rod] == OK:
            if trial.status[rod] == OK:
                accepted[lane] = real(1.0)
                accept_midpoint(rod, rods.tracked, midpoint, pace, trial)
            else:
                rods.status[rod] = trial.status[rod]
                failed_at[rod] = pace.at[rod, 0]
    store_shape(tile, repeat_last(tile, trial.end.shape[0], accepted), star, now, past)
    if contact.present == 1:
        keep_velocity(tile, accepted, contact)


@wp.func
def accept_midpoint(rod: int, tracked: int, midpoint: Midpoint, pace: Pace, trial: Trial):
    """Advance the middle frame and the time of a rod to the end of the step."""
    t = trial.end[rod]
    formula = formula_of(times_of(pace, rod), trial.order[rod], t)
    omega, u, roll_rate = trial.angular_velocity[rod], trial.velocity[rod], trial.roll_rate[rod]
    R, r, angle = stepped_midpoint(rod, midpoint, formula, omega, u, roll_rate)
    store_midpoint(rod, midpoint, R, r, angle)
    if midpoint.carrier.kind == CARRIED_APART:
        carry(rod, tracked, midpoint.carrier, formula)
    push_rates(rod, midpoint, omega, u, roll_rate)
    push_time(pace, rod, t, trial.error[rod])
    pace.order[rod] = formula.order


@wp.kernel
def reject_step(rods: Swimmers, pace: Pace):
    """Count the step as repeated; ``dim = rods``."""
    rod = wp.tid()
    if rods.status[rod] == OK:
        pace.rejected[rod] = pace.rejected[rod] + 1

"""A step of extensible and shearable rods, all of the same length: it is foretold, tried, and accepted or rejected.

The order is 2, and 1 from the start. Nothing of the present state changes before the step is accepted. A rod whose
result is not valid keeps its last state and gets a status; the other rods continue.
"""

import warp as wp

from warp_rods.kernels.clock import STEP
from warp_rods.kernels.cosserat.outcome import find_errors, find_statuses, store_frames
from warp_rods.kernels.cosserat.rod import drag_at_once, drag_of, screw_after, stiffest, stress_of
from warp_rods.kernels.cosserat.state import Frames, Past, Rods, Trial, Work
from warp_rods.kernels.cosserat.step import eliminate, predict_frames, substitute
from warp_rods.kernels.lanes import WIDTH, Lanes, Screw, Screws, mul, rods_in, store  # noqa: F401 (operators)
from warp_rods.kernels.layout import Matrices2D, Scalars1D, Vectors2D, real
from warp_rods.kernels.multistep import LEVELS, Pace, Weights, formula_of, push_time, times_of, weights_at
from warp_rods.kernels.screws import moved_frame, scaled
from warp_rods.kernels.status import OK

wp.set_module_options({"enable_backward": False})

FALLING, ITERATIONS = wp.constant(24), wp.constant(32)
"""Iterations in which a drag across falls by half each, and all of them."""


@wp.struct
class Formulas:
    """Weights of the levels, newest first, and ``a``, of each rod; and the weights of one level more."""

    value: Weights  # e
    slope: Weights  # d
    more: Weights
    rate: Lanes  # a


@wp.func
def formulas_of(tile: int, pace: Pace, trial: Trial) -> Formulas:
    """The formulas of the steps to ``trial.end`` of the orders ``trial.order``."""
    e, d, more, a = Weights(), Weights(), Weights(), Lanes(real(1.0))
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        at, t = times_of(pace, rod), trial.end[rod]
        formula = formula_of(at, trial.order[rod], t)
        w = weights_at(at, wp.min(trial.order[rod] + 1, pace.levels[rod]), t)
        a[lane] = formula.rate
        for j in range(LEVELS):
            e[j, lane] = formula.value[j]
            d[j, lane] = formula.slope[j]
            more[j, lane] = w[j]
    formulas = Formulas()
    formulas.value = e
    formulas.slope = d
    formulas.more = more
    formulas.rate = a
    return formulas


@wp.func
def show(tile: int, frames: Frames, rotation: Matrices2D, position: Vectors2D):
    """Frames as arrays [rod, node]."""
    for node in range(frames.rotation.shape[1]):
        store(rotation, tile, node, frames.rotation[tile, node])
        store(position, tile, node, frames.position[tile, node])


@wp.kernel
def lay_out(rods: Rods, strain: Screws, middle: int, now: Frames):
    """Frames with ``strain`` between nodes, from that of the node ``middle`` outwards; ``dim = tiles``."""
    tile = wp.tid()
    ds = Lanes(rods.spacing)
    R, r = moved_frame(now.rotation[tile, middle], now.position[tile, middle], Screw())
    for node in range(middle + 1, now.rotation.shape[1]):
        R, r = moved_frame(R, r, scaled(ds, strain[tile, node - 1]))
        now.rotation[tile, node] = R
        now.position[tile, node] = r
    Q, q = moved_frame(now.rotation[tile, middle], now.position[tile, middle], Screw())
    for back in range(middle):
        node = middle - 1 - back
        Q, q = moved_frame(Q, q, scaled(real(-1.0) * ds, strain[tile, node]))
        now.rotation[tile, node] = Q
        now.position[tile, node] = q


@wp.kernel
def start(rods: Rods, now: Frames, past: Past):
    """The stress of the present frames, as that of the past, too; ``dim = tiles``."""
    tile = wp.tid()
    for node in range(now.rotation.shape[1] - 1):
        P = stress_of(tile, node, rods, screw_after(tile, node, now))
        now.stress[tile, node] = P
        past.stress_before[tile, node] = P


@wp.kernel
def settle(rods: Rods, now: Frames, past: Past, trial: Trial, star: Frames, work: Work):
    """Turn the directors at once until moments across balance, as they have no drag across; ``dim = tiles``.

    Newton's method in steps of no length, the first ones with a drag across that falls. Where it leads nowhere a rod
    stays as it is.
    """
    tile = wp.tid()
    accepted = Lanes()
    for node in range(now.rotation.shape[1]):
        star.rotation[tile, node] = now.rotation[tile, node]
        star.position[tile, node] = now.position[tile, node]
        star.stress[tile, node] = now.stress[tile, node]
        trial.screw[tile, node] = Screw()
    across = stiffest(rods.stiffness[tile])
    for iteration in range(ITERATIONS):
        across = real(0.5) * across
        if iteration == FALLING:
            across = Lanes()
        eliminate(tile, rods, star, past, drag_at_once(across), Lanes(), Lanes(), work)
        substitute(tile, rods, star, trial, work)
    find_statuses(tile, rods, star, trial)
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        if rods.status[rod] == OK and trial.status[rod] == OK:
            accepted[lane] = real(1.0)
    for node in range(now.rotation.shape[1]):
        trial.screw[tile, node] = Screw()
    store_frames(tile, accepted, star, now, past, trial)
    for node in range(now.rotation.shape[1]):
        past.stress_before[tile, node] = now.stress[tile, node]


@wp.kernel
def predict(
    rods: Rods,
    now: Frames,
    past: Past,
    pace: Pace,
    clock: Scalars1D,
    trial: Trial,
    star: Frames,
    rotation: Matrices2D,
    position: Vectors2D,
):
    """When the step ends, its order, and the extrapolated frames, those of now for a frozen rod; ``dim = tiles``."""
    tile = wp.tid()
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        trial.end[rod] = pace.at[rod, 0] + clock[STEP]
        trial.order[rod] = wp.min(pace.levels[rod], 2)
        if rods.status[rod] != OK:
            trial.order[rod] = 1
        trial.error[rod] = real(-1.0)
    predict_frames(tile, formulas_of(tile, pace, trial).value, now, past, star, trial)
    show(tile, star, rotation, position)


@wp.kernel
def try_step(rods: Rods, past: Past, pace: Pace, trial: Trial, star: Frames, work: Work):
    """From the extrapolated frames to those at the end of the step, with status and error; ``dim = tiles``."""
    tile = wp.tid()
    formulas = formulas_of(tile, pace, trial)
    foretold = formulas.value[0] - formulas.value[1]
    drag = scaled(formulas.rate, drag_of(tile, rods))
    eliminate(tile, rods, star, past, drag, formulas.slope[1], foretold, work)
    substitute(tile, rods, star, trial, work)
    find_statuses(tile, rods, star, trial)
    find_errors(tile, formulas.more, rods, pace, star, past, trial)


@wp.kernel
def accept_step(rods: Rods, now: Frames, past: Past, pace: Pace, trial: Trial, star: Frames, failed_at: Scalars1D):
    """Make the result of the step the present state, or freeze a rod without a valid one; ``dim = tiles``."""
    tile = wp.tid()
    accepted = Lanes()
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        if rods.status[rod] == OK:
            if trial.status[rod] == OK:
                accepted[lane] = real(1.0)
                pace.order[rod] = trial.order[rod]
                push_time(pace, rod, trial.end[rod], trial.error[rod])
            else:
                rods.status[rod] = trial.status[rod]
                failed_at[rod] = pace.at[rod, 0]
    store_frames(tile, accepted, star, now, past, trial)


@wp.kernel
def reject_step(rods: Rods, pace: Pace):
    """Count the step as repeated; ``dim = rods``."""
    rod = wp.tid()
    if rods.status[rod] == OK:
        pace.rejected[rod] = pace.rejected[rod] + 1

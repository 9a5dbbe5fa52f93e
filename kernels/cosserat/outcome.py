"""The end of a step of extensible and shearable rods: status, error, and how its frames become the present ones."""

import warp as wp

from warp_rods.kernels.cosserat.rod import screw_after
from warp_rods.kernels.cosserat.state import Frames, Past, Rods, Trial
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    Matrix,
    Screw,
    add,
    div,
    dot,
    larger,
    mul,
    rods_in,
    rows,
    sqrt,
    where,
)
from warp_rods.kernels.layout import real
from warp_rods.kernels.multistep import INFINITE, Pace, Weights, local_error_scale, times_of
from warp_rods.kernels.screws import angular, bracket, linear, minus, plus, scaled
from warp_rods.kernels.status import NOT_FINITE, OK, TOO_BENT

wp.set_module_options({"enable_backward": False})

LARGEST_ANGLE = wp.constant(real(3.0))
"""The angle between adjacent nodes, and of a node in a step, above which a screw is close to being undefined."""


@wp.func_native(rows("Matrix", "mab", "for (int i = 0; i < 9; ++i) R[i] = M[0] != 0.0 ? A[i] : B[i];"))
def chosen(m: Lanes, a: Matrix, b: Matrix) -> Matrix:
    """a where m is not zero, b elsewhere."""


@wp.func_native(rows("Screw", "mab", "for (int i = 0; i < 6; ++i) R[i] = M[0] != 0.0 ? A[i] : B[i];"))
def chosen(m: Lanes, a: Screw, b: Screw) -> Screw: ...  # noqa: F811


@wp.func_native(rows("Lanes", "a", "R[0] = A[0]; for (int i = 1; i < 6; ++i) R[0] += A[i];"))
def sum_of(a: Screw) -> Lanes:
    """The sum of the components."""


@wp.func
def extrapolated(tile: int, node: int, w: Weights, past: Past) -> Screw:
    """The screw from the present frame of a node to that of the polynomial through the levels, with weights w."""
    x1, x2 = past.screw[tile, node], past.screw_before[tile, node]
    # log(exp(−x1) exp(−x2)), to third order
    older = minus(scaled(Lanes(real(0.5)), bracket(x1, x2)), plus(x1, x2))
    return minus(scaled(w[2], older), scaled(w[1], x1))


@wp.func
def error_of(tile: int, w: Weights, rods: Rods, star: Frames, past: Past, trial: Trial) -> Lanes:
    """Root mean square over the nodes of the distance to the polynomial with weights w: of strains over 1 + their own,
    or of places if larger."""
    strain, distance, places = Lanes(), Lanes(), Lanes()
    nodes = star.rotation.shape[1]
    before = minus(trial.screw[tile, 0], extrapolated(tile, 0, w, past))
    places += dot(linear(before), linear(before))
    for node in range(1, nodes):
        d = minus(trial.screw[tile, node], extrapolated(tile, node, w, past))
        turned = angular(minus(d, before))
        theta = angular(screw_after(tile, node - 1, star))
        strain += dot(theta, theta)
        distance += dot(turned, turned)
        places += dot(linear(d), linear(d))
        before = plus(d, Screw())
    scale = real(1.0) / (rods.spacing * rods.spacing * real(nodes - 1))
    relative = sqrt(scale * distance) / (real(1.0) + sqrt(scale * strain))
    return larger(relative, sqrt(places / real(nodes)))


@wp.func
def find_errors(tile: int, w: Weights, rods: Rods, pace: Pace, star: Frames, past: Past, trial: Trial):
    """Errors of the steps; infinite where the result is not valid. The whole first step counts."""
    error = error_of(tile, w, rods, star, past, trial)
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        order = trial.order[rod]
        trial.error[rod] = error[lane]
        if pace.levels[rod] > order:
            trial.error[rod] = local_error_scale(times_of(pace, rod), order, trial.end[rod]) * error[lane]
        if trial.status[rod] != OK:
            trial.error[rod] = INFINITE
        if rods.status[rod] != OK:
            trial.status[rod] = rods.status[rod]
            trial.error[rod] = real(-1.0)


@wp.func
def find_statuses(tile: int, rods: Rods, star: Frames, trial: Trial):
    """OK for rods that are finite and bend by less than half a turn between nodes; none turns by more in a step."""
    largest_square, non_finite = Lanes(), Lanes()
    last = star.rotation.shape[1] - 1
    for node in range(last + 1):
        turned = angular(trial.screw[tile, node])
        largest_square = larger(largest_square, dot(turned, turned))
        # Zero times a number is zero; zero times infinity or NaN is NaN.
        non_finite += real(0.0) * sum_of(trial.screw[tile, node])
        if node < last:
            theta = angular(screw_after(tile, node, star))
            largest_square = larger(largest_square, dot(theta, theta))
            non_finite += real(0.0) * sum_of(star.stress[tile, node])
    for lane in range(rods_in(tile, trial.status.shape[0])):
        status = OK
        if non_finite[lane] != real(0.0):
            status = NOT_FINITE
        elif largest_square[lane] > LARGEST_ANGLE * LARGEST_ANGLE:
            status = TOO_BENT
        trial.status[tile * WIDTH + lane] = status


@wp.func
def store_frames(tile: int, accepted: Lanes, star: Frames, now: Frames, past: Past, trial: Trial):
    """Make the frames at the end of the step the present ones, of the rods where ``accepted`` is not zero."""
    for node in range(now.rotation.shape[1]):
        past.screw_before[tile, node] = chosen(accepted, past.screw[tile, node], past.screw_before[tile, node])
        past.screw[tile, node] = chosen(accepted, trial.screw[tile, node], past.screw[tile, node])
        past.stress_before[tile, node] = chosen(accepted, now.stress[tile, node], past.stress_before[tile, node])
        now.stress[tile, node] = chosen(accepted, star.stress[tile, node], now.stress[tile, node])
        now.rotation[tile, node] = chosen(accepted, star.rotation[tile, node], now.rotation[tile, node])
        now.position[tile, node] = where(accepted, star.position[tile, node], now.position[tile, node])

"""The formulas of a step for the rods of a tile, each with its own times and order (``multistep.py``)."""

import warp as wp

from warp_rods.kernels.free.state import Trial
from warp_rods.kernels.lanes import WIDTH, Lanes, rods_in
from warp_rods.kernels.multistep import LEVELS, Pace, Weights, formula_of, times_of, weights_at

wp.set_module_options({"enable_backward": False})


@wp.struct
class Formulas:
    """Weights of the levels, newest first, and ``a``, of each rod."""

    value: Weights  # e
    slope: Weights  # d
    rate: Lanes  # a


@wp.func
def formulas_of(tile: int, pace: Pace, trial: Trial):
    """The formulas of the steps to ``trial.end`` of the orders ``trial.order``."""
    e, d, a = Weights(), Weights(), Lanes()
    count = rods_in(tile, trial.end.shape[0])
    for lane in range(count):
        rod = tile * WIDTH + lane
        formula = formula_of(times_of(pace, rod), trial.order[rod], trial.end[rod])
        a[lane] = formula.rate
        for j in range(LEVELS):
            e[j, lane] = formula.value[j]
            d[j, lane] = formula.slope[j]
    for lane in range(count, WIDTH):
        a[lane] = a[count - 1]
        for j in range(LEVELS):
            e[j, lane] = e[j, count - 1]
            d[j, lane] = d[j, count - 1]
    formulas = Formulas()
    formulas.value = e
    formulas.slope = d
    formulas.rate = a
    return formulas


@wp.func
def extrapolation(tile: int, pace: Pace, trial: Trial, more: int):
    """Weights of the extrapolation to ``trial.end`` with ``more`` levels than the order, or all levels there are."""
    w = Weights()
    for lane in range(rods_in(tile, trial.end.shape[0])):
        rod = tile * WIDTH + lane
        e = weights_at(times_of(pace, rod), wp.min(trial.order[rod] + more, pace.levels[rod]), trial.end[rod])
        for j in range(LEVELS):
            w[j, lane] = e[j]
    return w

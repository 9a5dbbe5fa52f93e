"""Growth of surface-bound filaments: length against time from a table (docs/model.md §3.8)."""

import warp as wp

from warp_rods.kernels.layout import Scalars2D, real

wp.set_module_options({"enable_backward": False})


@wp.struct
class Growth:
    """Length of each rod against time, linear between the knots and constant outside them [rod, knot]."""

    time: Scalars2D
    length: Scalars2D


NEXT_KNOT = wp.constant(real(1.0e-6))
"""A knot that is closer than this part of a step has been reached."""


@wp.func
def step_to_knot(growth: Growth, rod: int, t: real, step: real) -> real:
    """The step from t, ended at the next knot if it would pass it."""
    shortest = step
    for k in range(growth.time.shape[1]):
        left = growth.time[rod, k] - t
        if left > NEXT_KNOT * step and left < shortest:
            shortest = left
    return shortest


@wp.func
def length_at(growth: Growth, rod: int, t: real):
    """Length and dL/dt at time t."""
    length = growth.length[rod, 0]
    rate = real(0.0)
    for k in range(growth.time.shape[1] - 1):
        start = growth.time[rod, k]
        if t >= start:
            rate = (growth.length[rod, k + 1] - growth.length[rod, k]) / (growth.time[rod, k + 1] - start)
            length = growth.length[rod, k] + rate * (t - start)
    last = growth.time.shape[1] - 1
    if t >= growth.time[rod, last]:
        length = growth.length[rod, last]
        rate = real(0.0)
    return length, rate

"""Past states of surface-bound filaments, and the step that each rod takes from them (docs/model.md §1.5, §3.5)."""

import warp as wp

from warp_rods.kernels.bound.growth import Growth, step_to_knot
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.clock import STEP
from warp_rods.kernels.layout import (
    Integers1D,
    Integers2D,
    Matrices1D,
    Pairs2D,
    Scalars1D,
    Scalars2D,
    Vectors1D,
    Vectors2D,
    real,
)
from warp_rods.kernels.multistep import LEVELS, Levels, Pace, combine
from warp_rods.kernels.status import OK

wp.set_module_options({"enable_backward": False})

LevelsArray = wp.array(dtype=Levels)


@wp.struct
class History:
    """The state of each rod at its levels, newest first."""

    now: Scalars2D  # Ω [rod, node]
    first: Scalars2D
    second: Scalars2D
    third: Scalars2D
    fourth: Scalars2D
    turn: Scalars2D  # ψ, the angle by which the tracked node has turned about n [rod, level]
    rotation: Matrices1D  # frame of the tracked node
    position: Vectors1D
    rotation_before: Matrices1D  # the same one step ago
    position_before: Vectors1D
    angular_velocity: Vectors2D  # ω of the tracked node [rod, level]
    velocity: Vectors2D  # u of the tracked node
    contact_velocity: Pairs2D  # v along and across of the last step [rod, node], see ``contact.py``
    contact_lag: Pairs2D  # r − r* of the last step, along and across
    contact_foretold: Pairs2D  # the velocity of r** in the step that is tried
    failed_at: Scalars1D  # time at which the rod was frozen


@wp.struct
class Plan:
    """The step that each rod takes [rod]: its end, the weights of its formula, and what they give."""

    end: Scalars1D
    value: LevelsArray
    slope: LevelsArray
    rate: Scalars1D  # a
    turn_slope: Scalars1D  # Σ d ψ
    geodesic_slope: Scalars2D  # Σ d Ω [rod, node]
    turn: Scalars2D  # δα at half nodes [rod, node]; first the right-hand side
    angle: Scalars1D  # ψ at the end of the step
    velocity: Vectors1D  # u of the tracked node there
    angular_velocity: Vectors1D  # ω
    status: Integers1D  # OK, or why the result is not valid
    together: Integers1D  # 1: a step of the same length for all rods
    error: Scalars1D  # of the step
    lower: Scalars1D  # of a step of the order below, and of that above; negative: not known
    higher: Scalars1D
    unfit: Integers2D  # OK, or why a side of the rod [rod, side] cannot follow its surface


@wp.func
def geodesic_at(past: History, w: Levels, rod: int, i: int) -> real:
    """Σ w Ω of the levels."""
    return combine(
        w, past.now[rod, i], past.first[rod, i], past.second[rod, i], past.third[rod, i], past.fourth[rod, i]
    )


@wp.func
def turn_at(past: History, w: Levels, rod: int) -> real:
    """Σ w ψ of the levels."""
    total = real(0.0)
    for j in range(LEVELS):
        total += w[j] * past.turn[rod, j]
    return total


@wp.func
def push_geodesic(past: History, rod: int, i: int, newest: real):
    """Take this Ω as that of the newest level."""
    past.fourth[rod, i] = past.third[rod, i]
    past.third[rod, i] = past.second[rod, i]
    past.second[rod, i] = past.first[rod, i]
    past.first[rod, i] = past.now[rod, i]
    past.now[rod, i] = newest


@wp.kernel
def choose_equal_steps(f: Filaments, pace: Pace, plan: Plan, clock: Scalars1D):
    """Steps of the length in the clock and of second order, for every rod that is not frozen; ``dim = rods``."""
    rod = wp.tid()
    f.active[rod] = wp.where(f.status[rod] == OK, 1, 0)
    plan.together[rod] = 1
    pace.step[rod] = clock[STEP]
    pace.order[rod] = wp.min(pace.levels[rod], 2)


@wp.kernel
def reset(flag: Integers1D):
    """Set the flag to 0; ``dim = 1``."""
    flag[0] = 0


@wp.kernel
def choose_own_steps(f: Filaments, pace: Pace, plan: Plan, growth: Growth, target: Scalars1D, behind: Integers1D):
    """Let every rod that is not frozen take a step of its own until it has reached ``target[0]``; ``dim = rods``.

    No step passes a knot of the length against time, which the error of a long one might not see.
    """
    rod = wp.tid()
    f.active[rod] = 0
    plan.together[rod] = 0
    if f.status[rod] == OK and pace.at[rod, 0] < target[0]:
        f.active[rod] = 1
        behind[0] = 1
        pace.step[rod] = step_to_knot(growth, rod, pace.at[rod, 0], pace.step[rod])


@wp.kernel
def count_rejected(f: Filaments, pace: Pace):
    """Count the step as repeated; ``dim = rods``."""
    rod = wp.tid()
    pace.rejected[rod] = pace.rejected[rod] + f.active[rod]


@wp.kernel
def activate(f: Filaments):
    """Let the next kernels evaluate every rod; ``dim = rods``."""
    f.active[wp.tid()] = 1


@wp.kernel
def extrapolate(f: Filaments, past: History, plan: Plan):
    """Ω at the end of the step, and Σ d Ω; ``dim = (rods, nodes)``."""
    rod, i = wp.tid()
    if f.active[rod] == 1:
        f.geodesic[rod, i] = geodesic_at(past, plan.value[rod], rod, i)
        plan.geodesic_slope[rod, i] = geodesic_at(past, plan.slope[rod], rod, i)

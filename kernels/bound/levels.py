"""Past states of surface-bound filaments, and the step that each rod takes from them (docs/model.md §1.5, §3.5)."""

import warp as wp

from warp_rods.kernels.bound.growth import Growth, step_to_knot
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.bound.state import Vectors1D as TileVectors
from warp_rods.kernels.lanes import WIDTH, Lanes1D, Lanes2D, Pairs, add, mul, rods_in  # noqa: F401 (operators)
from warp_rods.kernels.layout import Integers1D, Matrices1D, Scalars1D, Scalars2D, Vectors1D, Vectors2D, real
from warp_rods.kernels.multistep import LEVELS, Levels, Pace, Weights, combine
from warp_rods.kernels.status import OK

wp.set_module_options({"enable_backward": False})

WeightsArray = wp.array(dtype=Weights)


@wp.struct
class History:
    """The state of each rod at its levels, newest first: Ω [tile, node], the others [rod]."""

    now: Lanes2D  # Ω [tile, node]
    first: Lanes2D
    second: Lanes2D
    third: Lanes2D
    fourth: Lanes2D
    turn: Scalars2D  # ψ, the angle by which the tracked node has turned about n [rod, level]
    rotation: Matrices1D  # frame of the tracked node
    position: Vectors1D
    rotation_before: Matrices1D  # the same one step ago
    position_before: Vectors1D
    angular_velocity: Vectors2D  # ω of the tracked node [rod, level]
    velocity: Vectors2D  # u of the tracked node
    contact_velocity: Pairs  # v along and across of the last step [tile, node], see ``contact.py``
    contact_lag: Pairs  # r − r* of the last step
    contact_velocity_tried: Pairs  # those of the step that is tried
    contact_lag_tried: Pairs
    contact_foretold: Pairs  # the velocity of r** in the step that is tried
    failed_at: Scalars1D  # time at which the rod was frozen


@wp.struct
class Plan:
    """The step that each rod takes: its end, the weights of its formula [tile], and what they give [rod]."""

    value: WeightsArray
    slope: WeightsArray
    rate: Lanes1D  # a
    turn_slope: Lanes1D  # Σ d ψ
    end: Scalars1D
    angle: Scalars1D  # ψ at the end of the step
    velocity: Vectors1D  # u of the tracked node there
    angular_velocity: Vectors1D  # ω
    status: Integers1D  # OK, or why the result is not valid
    together: Integers1D  # 1: a step of the same length for all rods
    error: Scalars1D  # of the step
    lower: Scalars1D  # of a step of the order below, and of that above; negative: not known
    higher: Scalars1D
    tangent: TileVectors  # of the node from which frames are laid out [tile], and its place
    place: TileVectors
    unfit: Scalars1D  # OK, or why the rod cannot follow its surface


@wp.func
def geodesic_at(past: History, w: Weights, tile: int, i: int):
    """Σ w Ω of the levels."""
    return combine(
        w, past.now[tile, i], past.first[tile, i], past.second[tile, i], past.third[tile, i], past.fourth[tile, i]
    )


@wp.func
def set_geodesic(f: Filaments, past: History, w: Weights, tile: int):
    """Ω from those of the levels; that of a free end is σ3 (D.59)."""
    last = f.geodesic.shape[1] - 1
    for i in range(last + 1):
        f.geodesic[tile, i] = geodesic_at(past, w, tile, i)
    if f.start_clamped == 0:
        f.geodesic[tile, 0] = f.intrinsic[tile, 0][2]
    if f.end_clamped == 0:
        f.geodesic[tile, last] = f.intrinsic[tile, last][2]


@wp.func
def turn_at(past: History, w: Levels, rod: int) -> real:
    """Σ w ψ of the levels."""
    total = real(0.0)
    for j in range(LEVELS):
        total += w[j] * past.turn[rod, j]
    return total


@wp.func
def choose_equal_steps(tile: int, f: Filaments, pace: Pace, plan: Plan, step: real):
    """Steps of this length and of second order, for every rod that is not frozen."""
    for lane in range(rods_in(tile, f.status.shape[0])):
        rod = tile * WIDTH + lane
        f.active[rod] = wp.where(f.status[rod] == OK, 1, 0)
        plan.together[rod] = 1
        pace.step[rod] = step
        pace.order[rod] = wp.min(pace.levels[rod], 2)


@wp.kernel
def reset(flag: Integers1D):
    """Set the flag to 0; ``dim = 1``."""
    flag[0] = 0


@wp.func
def choose_own_steps(tile: int, f: Filaments, pace: Pace, plan: Plan, growth: Growth, target: real, behind: Integers1D):
    """Let every rod that is not frozen take a step of its own until it has reached ``target``.

    No step passes a knot of the length against time, which the error of a long one might not see.
    """
    for lane in range(rods_in(tile, f.status.shape[0])):
        rod = tile * WIDTH + lane
        f.active[rod] = 0
        plan.together[rod] = 0
        if f.status[rod] == OK and pace.at[rod, 0] < target:
            f.active[rod] = 1
            behind[0] = 1
            pace.step[rod] = step_to_knot(growth, rod, pace.at[rod, 0], pace.step[rod])


@wp.kernel
def count_rejected(f: Filaments, pace: Pace):
    """Count the step as repeated; ``dim = rods``."""
    rod = wp.tid()
    pace.rejected[rod] = pace.rejected[rod] + f.active[rod]

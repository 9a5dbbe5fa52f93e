"""Time step of surface-bound filaments: Ω by SBDF2 in increments, length by its table (model §3, "Time", growth).

A rod whose increment is not finite keeps its last state and gets a status.
"""

import warp as wp

from warp_rods.kernels.bound.rod import spin, velocity_along
from warp_rods.kernels.bound.state import Filaments, scalars
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})

WELL = 0
NOT_FINITE = 1
OFF_SURFACE = 2
TOO_BENT = 3
TOO_FAST = 4

HALF_TURN = wp.constant(real(3.141592653589793))


@wp.struct
class History:
    """What the two-step scheme remembers, and its clock."""

    pace: wp.array(dtype=wp.vec2d)  # one element: Δt, and its ratio to the step before (0: there was none)
    clock: wp.array(dtype=wp.float64)  # one element: t
    geodesic: scalars  # Ω one step ago
    rate: scalars  # ∂Ω/∂t one step ago
    increment: scalars  # δ = Ωⁿ⁺¹ − Ω*
    spin: wp.array(dtype=wp.vec3d)  # ω of the middle node one step ago
    velocity: wp.array(dtype=wp.vec3d)  # u of the middle node one step ago
    failed_at: wp.array(dtype=wp.float64)  # t at which the status was set


@wp.struct
class Growth:
    """Length of each rod against time, linear between knots, constant outside them."""

    time: scalars  # [rod, knot]
    length: scalars


@wp.kernel
def grow(f: Filaments, past: History, growth: Growth):
    """Length and dL/dt at the end of the step."""
    rod = wp.tid()
    if f.status[rod] != WELL:
        return
    t = past.clock[0] + past.pace[0][0]
    length = growth.length[rod, 0]
    rate = real(0.0)
    for k in range(growth.time.shape[1] - 1):
        begin = growth.time[rod, k]
        if t >= begin:
            rate = (growth.length[rod, k + 1] - growth.length[rod, k]) / (growth.time[rod, k + 1] - begin)
            length = growth.length[rod, k] + rate * (t - begin)
    last = growth.time.shape[1] - 1
    if t >= growth.time[rod, last]:
        length = growth.length[rod, last]
        rate = real(0.0)
    f.spacing[rod] = length / real(f.geodesic.shape[1] - 1)
    f.growth_rate[rod] = rate


@wp.kernel
def increment_right_hand_side(f: Filaments, past: History):
    """Δt((1 + w) R − w R_old) − w(Ω − Ω_old), w the ratio of steps; Euler at w = 0."""
    rod, i = wp.tid()
    dt = past.pace[0][0]
    w = past.pace[0][1]
    extrapolated = (real(1.0) + w) * f.rate[rod, i] - w * past.rate[rod, i]
    past.increment[rod, i] = dt * extrapolated - w * (f.geodesic[rod, i] - past.geodesic[rod, i])


@wp.func
def node_velocity(f: Filaments, rod: int, i: int) -> wp.vec3d:
    """u of a node in its frame."""
    return wp.vec3d(velocity_along(f, rod, i), f.across[rod, i], f.lift[rod, i])


@wp.func
def verdict(f: Filaments, past: History, rod: int) -> int:
    """Whether the next state is finite, bends by less than half a turn a cell, and is less than a length away."""
    sharpest = real(0.0)
    total = real(0.0)
    for i in range(f.geodesic.shape[1]):
        turn = f.geodesic[rod, i] + past.pace[0][1] * (f.geodesic[rod, i] - past.geodesic[rod, i])
        turn += past.increment[rod, i]
        sharpest = wp.max(sharpest, wp.abs(turn))
        total += turn
    h = f.spacing[rod]
    u = node_velocity(f, rod, f.anchor)
    way = past.pace[0][0] * (wp.length(u) + h * wp.length(spin(f, rod, f.anchor)))
    if not (wp.isfinite(total) and wp.isfinite(way)):
        return NOT_FINITE
    if sharpest * h > HALF_TURN:
        return TOO_BENT
    if way > h * real(f.geodesic.shape[1] - 1):
        return TOO_FAST
    return WELL


@wp.kernel
def judge(f: Filaments, past: History):
    """Freeze a rod before a step that it would not survive: see ``verdict``."""
    rod = wp.tid()
    if f.status[rod] == WELL:
        f.status[rod] = verdict(f, past, rod)
        if f.status[rod] != WELL:
            past.failed_at[rod] = past.clock[0]


@wp.kernel
def advance_geodesic(f: Filaments, past: History):
    """Ωⁿ⁺¹ = Ω + w(Ω − Ω_old) + δ; history moved on."""
    rod, i = wp.tid()
    if f.status[rod] != WELL:
        return
    now = f.geodesic[rod, i]
    f.geodesic[rod, i] = now + past.pace[0][1] * (now - past.geodesic[rod, i]) + past.increment[rod, i]
    past.geodesic[rod, i] = now
    past.rate[rod, i] = f.rate[rod, i]


@wp.kernel
def tick(past: History):
    """t += Δt; from now on the step before is as long as this one."""
    dt = past.pace[0][0]
    past.clock[0] = past.clock[0] + dt
    past.pace[0] = wp.vec2d(dt, real(1.0))

"""Time step of surface-bound filaments: Ω by SBDF2 in increments, length by its table (model §3, "Time", growth).

A rod whose increment is not finite keeps its last state and gets a status.
"""

import warp as wp

from warp_rods.kernels.bound.rod import node_velocity, spin
from warp_rods.kernels.bound.state import Filaments, scalars
from warp_rods.kernels.clock import RATIO, STEP, TIME, per_clock
from warp_rods.kernels.layout import real
from warp_rods.kernels.status import NOT_FINITE, SOUND, TOO_BENT, TOO_FAST

wp.set_module_options({"enable_backward": False})

HALF_TURN = wp.constant(real(wp.pi))


@wp.struct
class History:
    """What the two-step scheme remembers [rod] and [rod, node]."""

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
def grow(f: Filaments, growth: Growth, clock: per_clock):
    """Length and dL/dt at the end of the step."""
    rod = wp.tid()
    if f.status[rod] != SOUND:
        return
    t = clock[TIME] + clock[STEP]
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
def increment_right_hand_side(f: Filaments, past: History, clock: per_clock):
    """Δt((1 + w) R − w R_old) − w(Ω − Ω_old), w the ratio of steps; Euler at w = 0."""
    rod, i = wp.tid()
    dt = clock[STEP]
    w = clock[RATIO]
    extrapolated = (real(1.0) + w) * f.rate[rod, i] - w * past.rate[rod, i]
    past.increment[rod, i] = dt * extrapolated - w * (f.geodesic[rod, i] - past.geodesic[rod, i])


@wp.func
def status_of(f: Filaments, past: History, clock: per_clock, rod: int) -> int:
    """Whether the next state is finite, bends by less than half a turn a cell, and is less than a length away."""
    sharpest = real(0.0)
    total = real(0.0)
    for i in range(f.geodesic.shape[1]):
        turn = f.geodesic[rod, i] + clock[RATIO] * (f.geodesic[rod, i] - past.geodesic[rod, i])
        turn += past.increment[rod, i]
        sharpest = wp.max(sharpest, wp.abs(turn))
        total += turn
    h = f.spacing[rod]
    u = node_velocity(f, rod, f.anchor)
    distance = clock[STEP] * (wp.length(u) + h * wp.length(spin(f, rod, f.anchor)))
    if not (wp.isfinite(total) and wp.isfinite(distance)):
        return NOT_FINITE
    if sharpest * h > HALF_TURN:
        return TOO_BENT
    if distance > h * real(f.geodesic.shape[1] - 1):
        return TOO_FAST
    return SOUND


@wp.kernel
def freeze_failing(f: Filaments, past: History, clock: per_clock):
    """Freeze a rod before a step that would take it out of bounds: see ``status_of``."""
    rod = wp.tid()
    if f.status[rod] == SOUND:
        f.status[rod] = status_of(f, past, clock, rod)
        if f.status[rod] != SOUND:
            past.failed_at[rod] = clock[TIME]


@wp.kernel
def advance_geodesic(f: Filaments, past: History, clock: per_clock):
    """Ωⁿ⁺¹ = Ω + w(Ω − Ω_old) + δ; history moved on."""
    rod, i = wp.tid()
    if f.status[rod] != SOUND:
        return
    now = f.geodesic[rod, i]
    f.geodesic[rod, i] = now + clock[RATIO] * (now - past.geodesic[rod, i]) + past.increment[rod, i]
    past.geodesic[rod, i] = now
    past.rate[rod, i] = f.rate[rod, i]

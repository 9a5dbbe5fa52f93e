"""The time step of filaments: Ω by the two-step formula, length from its table (docs/model.md §3.5, §3.8).

A rod whose next state would be invalid is frozen at its present state and gets a status (docs/model.md §3.9).
"""

import warp as wp

from warp_rods.kernels.bound.rod import angular_velocity, node_velocity
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.clock import RATIO, STEP, TIME
from warp_rods.kernels.layout import Integers2D, Matrices2D, Scalars1D, Scalars2D, Vectors1D, Vectors2D, real
from warp_rods.kernels.status import NOT_FINITE, OK, TOO_BENT, TOO_FAST

wp.set_module_options({"enable_backward": False})

HALF_TURN = wp.constant(real(wp.pi))


@wp.struct
class History:
    """Values of the previous step that the two-step formula uses [rod] and [rod, node]."""

    geodesic: Scalars2D  # Ω one step ago
    geodesic_rate: Scalars2D  # ∂Ω/∂t one step ago
    increment: Scalars2D  # δ = Ωⁿ⁺¹ − Ω*
    angular_velocity: Vectors1D  # ω of the tracked node one step ago
    velocity: Vectors1D  # u of the tracked node one step ago
    failed_at: Scalars1D  # time at which the rod was frozen
    position: Vectors2D  # the frames one step ago, to which a rod returns that cannot follow its surface
    rotation: Matrices2D
    curvature: Vectors2D
    unfit: Integers2D  # OK, or why a side of the rod [rod, side] cannot follow its surface


@wp.struct
class Growth:
    """Length of each rod against time, linear between the knots and constant outside them [rod, knot]."""

    time: Scalars2D
    length: Scalars2D


@wp.func
def set_length(f: Filaments, growth: Growth, rod: int, t: real):
    """Spacing and dL/dt at time t."""
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
    f.spacing[rod] = length / real(f.geodesic.shape[1] - 1)
    f.growth_rate[rod] = rate


@wp.kernel
def grow(f: Filaments, growth: Growth, clock: Scalars1D):
    """Spacing and dL/dt at the end of the step."""
    rod = wp.tid()
    if f.status[rod] == OK:
        set_length(f, growth, rod, clock[TIME] + clock[STEP])


@wp.kernel
def set_increment_rhs(f: Filaments, past: History, clock: Scalars1D):
    """Δt((1 + ρ) Fⁿ − ρ Fⁿ⁻¹) − ρ(Ωⁿ − Ωⁿ⁻¹) with F = ∂Ω/∂t; ρ = 0 is an Euler step."""
    rod, i = wp.tid()
    dt = clock[STEP]
    rho = clock[RATIO]
    extrapolated = (real(1.0) + rho) * f.geodesic_rate[rod, i] - rho * past.geodesic_rate[rod, i]
    past.increment[rod, i] = dt * extrapolated - rho * (f.geodesic[rod, i] - past.geodesic[rod, i])


@wp.func
def status_of(f: Filaments, past: History, clock: Scalars1D, rod: int) -> int:
    """OK if the next state is finite, bends by less than half a turn a cell, and moves by less than its length."""
    largest = real(0.0)
    total = real(0.0)
    for i in range(f.geodesic.shape[1]):
        geodesic = f.geodesic[rod, i] + clock[RATIO] * (f.geodesic[rod, i] - past.geodesic[rod, i])
        geodesic += past.increment[rod, i]
        largest = wp.max(largest, wp.abs(geodesic))
        total += geodesic
    h = f.spacing[rod]
    u = node_velocity(f, rod, f.tracked)
    distance = clock[STEP] * (wp.length(u) + h * wp.length(angular_velocity(f, rod, f.tracked)))
    if not (wp.isfinite(total) and wp.isfinite(distance)):
        return NOT_FINITE
    if largest * h > HALF_TURN:
        return TOO_BENT
    if distance > h * real(f.geodesic.shape[1] - 1):
        return TOO_FAST
    return OK


@wp.kernel
def freeze_failing(f: Filaments, past: History, clock: Scalars1D):
    """Freeze a rod whose next state would be invalid; see ``status_of``."""
    rod = wp.tid()
    if f.status[rod] == OK:
        f.status[rod] = status_of(f, past, clock, rod)
        if f.status[rod] != OK:
            past.failed_at[rod] = clock[TIME]


@wp.kernel
def advance_geodesic(f: Filaments, past: History, clock: Scalars1D):
    """Ωⁿ⁺¹ = Ωⁿ + ρ(Ωⁿ − Ωⁿ⁻¹) + δ; the present values become those of the previous step."""
    rod, i = wp.tid()
    if f.status[rod] != OK:
        return
    now = f.geodesic[rod, i]
    f.geodesic[rod, i] = now + clock[RATIO] * (now - past.geodesic[rod, i]) + past.increment[rod, i]
    past.geodesic[rod, i] = now
    past.geodesic_rate[rod, i] = f.geodesic_rate[rod, i]


@wp.kernel
def freeze_unfit(f: Filaments, past: History, growth: Growth, clock: Scalars1D, laid_out: int):
    """Freeze a rod that cannot follow its surface, at its state before the step; ``laid_out``: 1 if it has none yet."""
    rod = wp.tid()
    found = wp.max(past.unfit[rod, 0], past.unfit[rod, 1])
    if f.status[rod] != OK or found == OK:
        return
    f.status[rod] = found
    past.failed_at[rod] = clock[TIME]
    if laid_out == 1:
        return
    set_length(f, growth, rod, clock[TIME])
    for i in range(f.geodesic.shape[1]):
        f.geodesic[rod, i] = past.geodesic[rod, i]
        if i != f.tracked or f.start_clamped + f.end_clamped == 0:  # the frame of a clamped node does not change
            f.position[rod, i] = past.position[rod, i]
            f.rotation[rod, i] = past.rotation[rod, i]
            f.curvature[rod, i] = past.curvature[rod, i]

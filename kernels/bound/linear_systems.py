"""The linear system for the tension λ of surface-bound filaments (docs/model.md §3.4)."""

import warp as wp

from warp_rods.kernels.bound.membrane_motion import shortening_rate
from warp_rods.kernels.bound.rod import free_end_tension, resistance_at
from warp_rods.kernels.bound.state import Filaments, Systems
from warp_rods.kernels.lanes import Block, Lanes, add, block, div, mul, sub  # noqa: F401 (operators)
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.func
def inner_row(f: Filaments, tile: int, i: int) -> Block:
    """(lower, diagonal, upper, rhs) of (u1(i+½) − u1(i−½))/Δs − Ω u2 = K11 V in λ; zero at the ends."""
    if i == 0 or i == f.geodesic.shape[1] - 1:
        return Block()
    Z = resistance_at(f, tile, i)
    geodesic = f.geodesic[tile, i]
    one = real(1.0)
    mobility = geodesic / Z[2]
    half_coupling = real(0.5) * mobility * Z[1]
    per_length = one / f.spacing[tile]
    after = per_length + half_coupling
    before = per_length - half_coupling
    return block(
        -before * f.u1_left[tile, i - 1],
        after * f.u1_left[tile, i] - before * f.u1_right[tile, i - 1] - mobility * geodesic,
        after * f.u1_right[tile, i],
        mobility * f.transverse_force[tile, i]
        - after * f.u1_constant[tile, i]
        + before * f.u1_constant[tile, i - 1]
        + shortening_rate(f, tile, i),
    )


@wp.func
def start_row(f: Filaments, tile: int) -> Block:
    """λ of a free first end (D.61), or u1 = ½Δs K11 V at the half node next to a clamped one, so that u1 = 0 there."""
    if f.start_clamped == 0:
        return block(Lanes(), Lanes(real(1.0)), Lanes(), free_end_tension(f.curvature[tile, 0], f.moment[tile, 0]))
    u1 = real(0.5) * f.spacing[tile] * shortening_rate(f, tile, 0)
    return block(Lanes(), f.u1_left[tile, 0], f.u1_right[tile, 0], u1 - f.u1_constant[tile, 0])


@wp.func
def end_row(f: Filaments, tile: int) -> Block:
    """The same for the last end.

    A constant tension of a straight rod clamped at both ends is undetermined and has no effect. A factor slightly
    above 1 makes the system regular and selects the smallest tension.
    """
    last = f.geodesic.shape[1] - 1
    if f.end_clamped == 0:
        return block(
            Lanes(), Lanes(real(1.0)), Lanes(), free_end_tension(f.curvature[tile, last], f.moment[tile, last])
        )
    regular = real(1.0) + real(f.start_clamped) * real(1.0e-12)
    left = f.u1_left[tile, last - 1]
    u1 = real(-0.5) * f.spacing[tile] * shortening_rate(f, tile, last)
    return block(-left, -regular * f.u1_right[tile, last - 1], Lanes(), f.u1_constant[tile, last - 1] - u1)


@wp.func
def set_tension_rows(f: Filaments, tile: int, systems: Systems):
    """Rows for λ: u1' − Ω u2 = K11 V at inner nodes; at an end λ of (D.61), or u1 next to a clamped one."""
    last = f.geodesic.shape[1] - 1
    for i in range(last + 1):
        row = inner_row(f, tile, i)
        if i == 0:
            row = start_row(f, tile)
        elif i == last:
            row = end_row(f, tile)
        systems.lower[tile, i] = row[0]
        systems.diagonal[tile, i] = row[1]
        systems.upper[tile, i] = row[2]
        systems.rhs[tile, i] = row[3]

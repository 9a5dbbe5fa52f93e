"""Terms of a membrane that moves along n with velocity V (docs/moving_membranes.md).

V_1 = (n×q)·∇V; V' is the derivative along the rod. All terms vanish on a membrane at rest, and are not evaluated there.
"""

import warp as wp

from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.lanes import Lanes, Vector, add, div, mul, sub, vector  # noqa: F401 (operators)
from warp_rods.kernels.layout import real
from warp_rods.kernels.stencils import derivative, half_average

wp.set_module_options({"enable_backward": False})


@wp.func
def shortening_rate(f: Filaments, tile: int, i: int) -> Lanes:
    """K11 V in u1' = Ω u2 + K11 V: the rate at which motion along n alone would shorten the rod."""
    if f.membrane_moves == 0:
        return Lanes()
    return f.curvature[tile, i][0] * f.normal_velocity[tile, i]


@wp.func
def rotational_drag_across(f: Filaments, tile: int, i: int) -> Lanes:
    """ζr K22 V_1 at a node, the rotational drag of the moving membrane in Y2."""
    if f.membrane_moves == 0:
        return Lanes()
    return f.drag[tile, i][2] * f.curvature[tile, i][2] * f.normal_velocity_slope[tile, i]


@wp.func
def rotational_drag_along(f: Filaments, tile: int, i: int) -> Lanes:
    """ζr K12 V_1 at i + ½, the rotational drag of the moving membrane in Y1."""
    if f.membrane_moves == 0:
        return Lanes()
    drag = half_average(f.drag, tile, i)[2]
    return drag * half_average(f.curvature, tile, i)[1] * half_average(f.normal_velocity_slope, tile, i)


@wp.func
def membrane_angular_velocity(f: Filaments, tile: int, i: int) -> Vector:
    """The part of ω that is due to V: (V_1, −V', −K12 V)."""
    if f.membrane_moves == 0:
        return Vector()
    slope = derivative(f.normal_velocity, tile, i, f.spacing[tile])
    return vector(f.normal_velocity_slope[tile, i], -slope, -f.curvature[tile, i][1] * f.normal_velocity[tile, i])


@wp.func
def turning_rate(f: Filaments, tile: int, i: int) -> Lanes:
    """K12 V: u2' where a section does not spin about n, as a clamped one."""
    if f.membrane_moves == 0:
        return Lanes()
    return f.curvature[tile, i][1] * f.normal_velocity[tile, i]


@wp.func
def turning_slope(f: Filaments, tile: int, i: int, h: Lanes) -> Lanes:
    """(K12 V)' at a node; three points at the ends."""
    last = f.geodesic.shape[1] - 1
    if i > 0 and i < last:
        return (turning_rate(f, tile, i + 1) - turning_rate(f, tile, i - 1)) / (real(2.0) * h)
    inwards = wp.where(i == 0, 1, -1)
    here = turning_rate(f, tile, i)
    near, far = turning_rate(f, tile, i + inwards) - here, turning_rate(f, tile, i + 2 * inwards) - here
    return (real(4.0) * near - far) / (real(2 * inwards) * h)


@wp.func
def membrane_geodesic_rate(f: Filaments, tile: int, i: int) -> Lanes:
    """The part of ∂Ω/∂t that is due to V: Ω K11 V − (K12 V)' − K12 V' + K11 V_1."""
    if f.membrane_moves == 0:
        return Lanes()
    K = f.curvature[tile, i]
    h = f.spacing[tile]
    rate = f.geodesic[tile, i] * shortening_rate(f, tile, i) - turning_slope(f, tile, i, h)
    return rate - K[1] * derivative(f.normal_velocity, tile, i, h) + K[0] * f.normal_velocity_slope[tile, i]

"""What a membrane that moves along n with velocity V adds to the structure equations (docs/moving_membranes.md).

V_1 = (n×q)·∇V, V' is the derivative along the rod. Where the membrane rests all of this is zero, and costs nothing.
"""

import warp as wp

from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.layout import real
from warp_rods.kernels.stencils import derivative, half_average

wp.set_module_options({"enable_backward": False})


@wp.func
def shortening(f: Filaments, rod: int, i: int) -> real:
    """K11 V: how fast the membrane shortens what lies on it along the rod, in u1' = Ω u2 + K11 V."""
    if f.moving == 0:
        return real(0.0)
    return f.curvature[rod, i][0] * f.normal_velocity[rod, i]


@wp.func
def roll_drag_across(f: Filaments, rod: int, i: int) -> real:
    """ζr K22 V_1 at a node: what turning with the membrane costs the motion across."""
    if f.moving == 0:
        return real(0.0)
    return f.drag[rod][2] * f.curvature[rod, i][2] * f.normal_velocity_slope[rod, i]


@wp.func
def roll_drag_along(f: Filaments, rod: int, i: int) -> real:
    """ζr K12 V_1 at i + 1/2: what it costs the motion along."""
    if f.moving == 0:
        return real(0.0)
    return f.drag[rod][2] * half_average(f.curvature, rod, i)[1] * half_average(f.normal_velocity_slope, rod, i)


@wp.func
def membrane_spin(f: Filaments, rod: int, i: int) -> wp.vec3d:
    """The part of ω that V alone makes: (V_1, −V', −K12 V)."""
    if f.moving == 0:
        return wp.vec3d()
    slope = derivative(f.normal_velocity, rod, i, f.spacing[rod])
    return wp.vec3d(f.normal_velocity_slope[rod, i], -slope, -f.curvature[rod, i][1] * f.normal_velocity[rod, i])


@wp.func
def membrane_turning(f: Filaments, rod: int, i: int) -> real:
    """The part of ∂Ω/∂t that V alone makes, at an inner node: Ω K11 V − (K12 V)' − K12 V' + K11 V_1."""
    if f.moving == 0:
        return real(0.0)
    K = f.curvature[rod, i]
    h = f.spacing[rod]
    before = f.curvature[rod, i - 1][1] * f.normal_velocity[rod, i - 1]
    after = f.curvature[rod, i + 1][1] * f.normal_velocity[rod, i + 1]
    flow = f.geodesic[rod, i] * shortening(f, rod, i) - (after - before) / (real(2.0) * h)
    return flow - K[1] * derivative(f.normal_velocity, rod, i, h) + K[0] * f.normal_velocity_slope[rod, i]

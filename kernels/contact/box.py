"""The box of a scene: periods along the axes, and soft walls (docs/model.md §6.2, §6.3).

A period of 0 marks an axis that is not periodic. Positions are never wrapped: the nearest image of each pair counts.
"""

import functools

import warp as wp

from warp_rods.kernels.layout import Matrices2D, Scalars1D, Vectors2D, real
from warp_rods.kernels.stencils import trapezoid_weight
from warp_rods.kernels.surface.geometry import ParameterArray, Parameters

wp.set_module_options({"enable_backward": False})

FAR_AWAY = wp.constant(real(-1e300))


@wp.func
def nearest(d: real, period: real) -> real:
    """The component of a separation along one axis, between nearest images."""
    if period == real(0.0):
        return d
    return d - period * wp.rint(d / period)


@wp.func
def nearest_image(d: wp.vec3d, period: wp.vec3d) -> wp.vec3d:
    """The separation between the nearest images of two points."""
    return wp.vec3d(nearest(d[0], period[0]), nearest(d[1], period[1]), nearest(d[2], period[2]))


@wp.func
def slab(x: wp.vec3d, p: Parameters):
    """φ = |z| − h/2 of two walls, with ∇φ and ∇∇φ as for a membrane."""
    outward = wp.where(x[2] < real(0.0), real(-1.0), real(1.0))
    return wp.abs(x[2]) - real(0.5) * p.v[0], wp.vec3d(real(0.0), real(0.0), outward), wp.mat33d()


@wp.func
def pore(x: wp.vec3d, p: Parameters):
    """φ = ρ − R of a cylinder of radius p[0] about the axis p[1:4], with ∇φ; it is a distance, so ∇∇φ ∇φ = 0."""
    axis = wp.vec3d(p.v[1], p.v[2], p.v[3])
    across = x - wp.dot(x, axis) * axis
    rho = wp.length(across)
    outward = wp.vec3d()
    if rho > real(0.0):
        outward = across / rho
    return rho - p.v[0], outward, wp.mat33d()


@wp.func
def nowhere(x: wp.vec3d, p: Parameters):
    """φ, ∇φ and ∇∇φ of a room that has flat walls only."""
    return FAR_AWAY, wp.vec3d(), wp.mat33d()


@wp.func
def distance(phi: real, gradient: wp.vec3d, hessian: wp.mat33d):
    """(d, ∇d) of d = φ/|∇φ|, the distance to φ = 0 to first order; a point where ∇φ vanishes is far inside."""
    size = wp.length(gradient)
    if size == real(0.0):
        return FAR_AWAY, wp.vec3d()
    n = gradient / size
    return phi / size, n - (hessian * n) * (phi / (size * size))


@wp.func
def cap_depths(x: wp.vec3d, low: wp.vec3d, high: wp.vec3d, wall_range: real) -> wp.vec3d:
    """d + δ at the faces of a box, along the outward normal of each face; zero where it is negative."""
    reach = wp.vec3d(wall_range, wall_range, wall_range)
    return wp.max(x - high + reach, wp.vec3d()) - wp.max(low - x + reach, wp.vec3d())


@wp.func
def touched(depths: wp.vec3d) -> wp.vec3d:
    """1 along each axis with a cap that is touched, otherwise 0."""
    one, zero = real(1.0), real(0.0)
    return wp.vec3d(
        wp.where(depths[0] == zero, zero, one), wp.where(depths[1] == zero, zero, one),
        wp.where(depths[2] == zero, zero, one),
    )  # fmt: skip


@functools.cache
def walls_of(field: wp.Function):
    """The kernel of a soft wall along φ = 0 of a ``field``: W = ½ k (d + δ)² per length where d > −δ; ``dim = rods``.

    d is the distance outside the surface, or inside it for ``side`` = −1. The faces of the box from ``low`` to ``high``
    are walls, too, where they are finite: the caps of a tube. φ counts in the box from ``known_low`` to ``known_high``
    only. The kernel adds −∇W to ``force``, k ∇d∇d to ``stiffness``, and stores the energy ∫ W ds of each rod.
    """

    @wp.kernel(module="unique", enable_backward=False)
    def add_wall_force(
        position: Vectors2D,
        spacing: Scalars1D,
        parameters: ParameterArray,
        low: wp.vec3d,
        high: wp.vec3d,
        known_low: wp.vec3d,
        known_high: wp.vec3d,
        side: real,
        strength: real,
        wall_range: real,
        force: Vectors2D,
        stiffness: Matrices2D,
        energy: Scalars1D,
    ):
        rod = wp.tid()
        total = real(0.0)
        nodes = position.shape[1]
        for i in range(nodes):
            phi, g, H = field(position[rod, i], parameters[0])
            d, gradient = distance(side * phi, side * g, side * H)
            depth = d + wall_range
            x = position[rod, i]
            known = wp.min(x - known_low) >= real(0.0) and wp.min(known_high - x) >= real(0.0)
            if known and depth > real(0.0):
                force[rod, i] -= (strength * depth) * gradient
                stiffness[rod, i] += strength * wp.outer(gradient, gradient)
                total += trapezoid_weight(i, nodes, spacing[rod]) * depth * depth
            depths = cap_depths(x, low, high, wall_range)
            if wp.length(depths) > real(0.0):
                force[rod, i] -= strength * depths
                stiffness[rod, i] += strength * wp.diag(touched(depths))
                total += trapezoid_weight(i, nodes, spacing[rod]) * wp.dot(depths, depths)
        energy[rod] = real(0.5) * strength * total

    return add_wall_force

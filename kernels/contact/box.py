"""Where rods live, as kernels see it: periods along the axes, and soft walls.

A period of 0 stands for an axis without one. Positions are never wrapped: of a pair the nearest images count.
"""

import functools

import warp as wp

from warp_rods.kernels.layout import real
from warp_rods.kernels.stencils import trapezoid_weight
from warp_rods.kernels.surface.geometry import Parameters

wp.set_module_options({"enable_backward": False})

FAR = wp.constant(real(-1e300))


@wp.func
def nearest(d: real, period: real) -> real:
    """A separation along one axis, between nearest images."""
    if period == real(0.0):
        return d
    return d - period * wp.rint(d / period)


@wp.func
def nearest_image(d: wp.vec3d, period: wp.vec3d) -> wp.vec3d:
    """The separation of two points' nearest images."""
    return wp.vec3d(nearest(d[0], period[0]), nearest(d[1], period[1]), nearest(d[2], period[2]))


@wp.func
def slab(x: wp.vec3d, p: Parameters):
    """φ = |z| − h/2: two walls, and φ, ∇φ, ∇∇φ like those of a membrane."""
    outward = wp.where(x[2] < real(0.0), real(-1.0), real(1.0))
    return wp.abs(x[2]) - real(0.5) * p.v[0], wp.vec3d(real(0.0), real(0.0), outward), wp.mat33d()


@wp.func
def distance(phi: real, gradient: wp.vec3d, hessian: wp.mat33d):
    """(d, ∇d) of d = φ/|∇φ|, the distance to φ = 0 to first order; where ∇φ vanishes the wall is far."""
    size = wp.length(gradient)
    if size == real(0.0):
        return FAR, wp.vec3d()
    n = gradient / size
    return phi / size, n - (hessian * n) * (phi / (size * size))


@functools.cache
def walls_of(field: wp.Function):
    """The kernel of a soft wall along φ = 0 of a ``field``: W = ½ k (d + δ)² per length where d > −δ; ``dim = rods``.

    d is the distance outside, with ``side`` = −1 inside: rods are kept on the other side. Adds −∇W to ``force`` and
    keeps each rod's energy ∫ W ds.
    """

    @wp.kernel(module="unique", enable_backward=False)
    def confine(
        position: wp.array2d(dtype=wp.vec3d),
        spacing: wp.array(dtype=wp.float64),
        parameters: wp.array(dtype=Parameters),
        side: real,
        strength: real,
        reach: real,
        force: wp.array2d(dtype=wp.vec3d),
        energy: wp.array(dtype=wp.float64),
    ):
        rod = wp.tid()
        total = real(0.0)
        for i in range(position.shape[1]):
            phi, g, H = field(position[rod, i], parameters[0])
            d, outward = distance(side * phi, side * g, side * H)
            inside = d + reach
            if inside > real(0.0):
                force[rod, i] -= (strength * inside) * outward
                total += trapezoid_weight(i, position.shape[1], spacing[rod]) * inside * inside
        energy[rod] = real(0.5) * strength * total

    return confine

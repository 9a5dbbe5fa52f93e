"""Surfaces for tiles of rods: fields lane by lane, and their geometry (docs/model.md §5.1; (5.15) to (5.23))."""

import functools

import warp as wp

from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    Symmetric,
    Vector,
    add,
    cross,
    div,
    dot,
    mul,
    sqrt,
    sub,
    vector,
)
from warp_rods.kernels.layout import real
from warp_rods.kernels.surface.geometry import Parameters

wp.set_module_options({"enable_backward": False})


@functools.cache
def in_lanes(field: wp.Function) -> wp.Function:
    """A field x, p -> φ, ∇φ, ∇∇φ of a tile from that of a point. The loop over lanes becomes vector instructions."""

    @wp.func
    def evaluate(x: Vector, p: Parameters):
        phi, g, H = Lanes(), Vector(), Symmetric()
        k = int(0)  # noqa: RUF046, UP018 (a variable, so that the loop is not unrolled)
        while k < WIDTH:
            value, gradient, hessian = field(wp.vec3d(x[0, k], x[1, k], x[2, k]), p)
            phi[k] = value
            g[0, k] = gradient[0]
            g[1, k] = gradient[1]
            g[2, k] = gradient[2]
            H[0, k] = hessian[0, 0]
            H[1, k] = hessian[0, 1]
            H[2, k] = hessian[0, 2]
            H[3, k] = hessian[1, 1]
            H[4, k] = hessian[1, 2]
            H[5, k] = hessian[2, 2]
            k += 1
        return phi, g, H

    return evaluate


@wp.func
def shift_to_surface(phi: Lanes, gradient: Vector, H: Symmetric, d: Vector) -> Vector:
    """What one Newton step subtracts from the point x + d, from φ, ∇φ, ∇∇φ at x; φ there is in error by O(d³)."""
    Hd = H * d
    there = phi + dot(gradient, d) + real(0.5) * dot(d, Hd)
    g = gradient + Hd
    return g * (there / dot(g, g))


@wp.func
def to_tangent(q: Vector, n: Vector) -> Vector:
    """The unit vector along the projection of q onto the tangent plane."""
    v = q - n * dot(q, n)
    return v * (real(1.0) / sqrt(dot(v, v)))


@wp.func
def curvature(H: Symmetric, q: Vector, across: Vector, per_size: Lanes) -> Vector:
    """(K11, K12, K22) in the pair (q, n×q): K_ij = −q_i·∇∇φ·q_j/|∇φ| (5.16); ``per_size`` is 1/|∇φ|."""
    Hq = H * q
    return vector(dot(q, Hq), dot(across, Hq), dot(across, H * across)) * -per_size


@wp.func
def curvature_of(gradient: Vector, H: Symmetric, tangent: Vector) -> Vector:
    """(K11, K12, 0) for a unit vector near the tangent plane, of which the part in that plane counts."""
    size2, out = dot(gradient, gradient), dot(tangent, gradient)
    q = tangent - gradient * (out / size2)
    Hq = H * q
    scale = real(-1.0) / (size2 - out * out)
    return vector(sqrt(size2) * scale * dot(q, Hq), scale * dot(cross(gradient, q), Hq), Lanes())

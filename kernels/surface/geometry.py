"""Geometry of a surface φ(x) = 0 from φ, ∇φ and ∇∇φ (docs/model.md §5.1; (5.15) to (5.23)).

A surface is one Warp function ``field(x, p) -> (φ, ∇φ, ∇∇φ)`` of a point x and parameters p; outward is where φ > 0.
"""

import functools
from types import SimpleNamespace
from typing import Any

import warp as wp

from warp_rods.kernels.lanes import mul, sub  # noqa: F401 (operators)
from warp_rods.kernels.layout import Integers2D, Matrices1D, Scalars1D, Scalars2D, Vectors1D, real
from warp_rods.kernels.surface.trigonometry import cosine, sine  # noqa: F401 (used by written fields)

wp.set_module_options({"enable_backward": False})

Numbers = wp.types.vector(8, wp.float64)


@wp.struct
class Parameters:
    """Parameters of one surface; surfaces of one kind share their field."""

    v: Numbers  # parameters in the order of the table of surfaces, padded with zeros
    grid: wp.array3d(dtype=wp.float64)  # spline coefficients of a surface given on a grid; otherwise empty


ParameterArray = wp.array(dtype=Parameters)


def _signature(x: wp.vec3d, p: Parameters): ...


def _rate_signature(x: wp.vec3d, p: Parameters, rates: Parameters): ...


def written_field(name: str, source: str) -> wp.Function:
    """A field from source code, in a Warp module of this name; the source may use ``wp`` and ``Parameters``.

    Its sines and cosines become those without calls.
    """
    source = source.replace("wp.sin(", "sine(").replace("wp.cos(", "cosine(")
    return wp.Function(_signature, key=name, namespace="", module=wp.get_module(name), source=source)


def written_rate(name: str, source: str) -> wp.Function:
    """As ``written_field``, of a function x, p, dp/dt -> ∂tφ, ∇∂tφ."""
    return wp.Function(_rate_signature, key=name, namespace="", module=wp.get_module(name), source=source)


@wp.func
def normal(gradient: wp.vec3d) -> wp.vec3d:
    """Outward unit normal n = ∇φ/|∇φ|."""
    return gradient / wp.length(gradient)


@wp.func
def to_surface(x: wp.vec3d, phi: real, gradient: wp.vec3d) -> wp.vec3d:
    """One Newton step along ∇φ towards φ = 0."""
    return x - gradient * (phi / wp.dot(gradient, gradient))


@wp.func
def to_tangent(q: wp.vec3d, n: wp.vec3d) -> wp.vec3d:
    """The unit vector along the projection of q onto the tangent plane."""
    return wp.normalize(q - n * wp.dot(q, n))


@wp.func
def frame(q: wp.vec3d, n: wp.vec3d) -> wp.mat33d:
    """Directors (q, n×q, n) as columns (D.66); q is a unit tangent."""
    return wp.matrix_from_cols(q, wp.cross(n, q), n)


@wp.func
def curvature(gradient: wp.vec3d, hessian: wp.mat33d, q: wp.vec3d) -> wp.vec3d:
    """(K11, K12, K22) in the pair (q, n×q): K_ij = −q_i·∇n·q_j = −q_i·∇∇φ·q_j/|∇φ| (5.16)."""
    size = wp.length(gradient)
    q1 = wp.cross(gradient / size, q)
    Hq = hessian * q
    return wp.vec3d(wp.dot(q, Hq), wp.dot(q1, Hq), wp.dot(q1, hessian * q1)) * (real(-1.0) / size)


@wp.func
def gaussian(K: Any):
    """Gaussian curvature 𝒦 = K11 K22 − K12², of one point or of a tile."""
    return K[0] * K[2] - K[1] * K[1]


@wp.func
def normal_motion(gradient: wp.vec3d, hessian: wp.mat33d, phi_t: real, gradient_t: wp.vec3d):
    """The normal velocity V = −∂tφ/|∇φ| of a moving surface, and ∇V."""
    size = wp.length(gradient)
    n = gradient / size
    return -phi_t / size, (hessian * n) * (phi_t / (size * size)) - gradient_t / size


@functools.cache
def sampler(field: wp.Function) -> SimpleNamespace:
    """Kernels on points: ``.value`` (φ), ``.evaluate`` (φ, ∇φ, ∇∇φ), ``.project`` (Newton steps to φ = 0)."""

    @wp.kernel(module="unique", enable_backward=False)
    def value(
        points: Vectors1D,
        parameters: ParameterArray,
        phi: Scalars1D,
    ):
        i = wp.tid()
        found, _g, _H = field(points[i], parameters[0])
        phi[i] = found

    @wp.kernel(module="unique", enable_backward=False)
    def evaluate(
        points: Vectors1D,
        parameters: ParameterArray,
        phi: Scalars1D,
        gradient: Vectors1D,
        hessian: Matrices1D,
    ):
        i = wp.tid()
        value, g, H = field(points[i], parameters[0])
        phi[i] = value
        gradient[i] = g
        hessian[i] = H

    @wp.kernel(module="unique", enable_backward=False)
    def project(points: Vectors1D, parameters: ParameterArray, iterations: int):
        i = wp.tid()
        x = points[i]
        for _ in range(iterations):
            value, g, _H = field(x, parameters[0])
            x = to_surface(x, value, g)
        points[i] = x

    return SimpleNamespace(value=value, evaluate=evaluate, project=project)


@functools.cache
def crossings_of(field: wp.Function) -> wp.Kernel:
    """A kernel that finds where lines cross φ = 0."""

    @wp.kernel(module="unique", enable_backward=False)
    def find_crossings(
        foot: Vectors1D,
        direction: Vectors1D,
        place: Scalars2D,
        begin: Scalars1D,
        end: Scalars1D,
        parameters: ParameterArray,
        crossed: Integers2D,
    ):
        """Changes of the sign of φ between places [line, sample] along lines that lie from ``begin`` to ``end``.

        crossed: 1 where φ > 0 at a place and not at the next, −1 where it is the other way round, otherwise as before.
        """
        line = wp.tid()
        before, last = real(0.0), wp.int32(-1)
        for k in range(place.shape[1]):
            t = place[line, k]
            if t >= begin[line] and t <= end[line]:
                phi, _g, _H = field(foot[line] + t * direction[line], parameters[0])
                if last >= 0 and (before > real(0.0)) != (phi > real(0.0)):
                    crossed[line, last] = wp.where(phi > real(0.0), -1, 1)
                before = phi
                last = k

    return find_crossings

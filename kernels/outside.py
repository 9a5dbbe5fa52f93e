"""What acts on rods from outside, at their nodes in space: background flow, force and couple per length.

A flow is a Warp function ``flow(x, t, p) -> (u, ½∇×u)`` of a point and the time; p is the profile of those that are
polynomials of second degree::

    u = u0 + G y + a (1 − y·Qy),    y = x − centre

A force is a Warp function ``force(x, s, t) -> (force, couple)``, s from −1/2 to 1/2 along a rod.
"""

import functools

import warp as wp

from warp_rods.kernels.layout import Scalars1D, Vectors1D, Vectors2D, real

wp.set_module_options({"enable_backward": False})


@wp.struct
class Profile:
    """A flow of second degree in the place."""

    centre: wp.vec3d
    velocity: wp.vec3d  # u0
    gradient: wp.mat33d  # G, ∂u_i/∂x_j at the centre
    axis: wp.vec3d  # a
    form: wp.mat33d  # Q, symmetric


@wp.struct
class Outside:
    """What acts from outside, in space [rod, node]."""

    flowing: int  # 1: there is a flow
    pushing: int  # 1: there is a force per length
    turning: int  # 1: there is a couple per length
    profile: Profile
    weight: Vectors1D  # gravity, a force per length [rod]
    velocity: Vectors2D  # u∞
    spin: Vectors2D  # ½∇×u∞
    force: Vectors2D
    couple: Vectors2D


@wp.func
def profile_flow(x: wp.vec3d, t: real, p: Profile):
    """The flow of a profile, and half its curl."""
    y = x - p.centre
    Qy = p.form * y
    u = p.velocity + p.gradient * y + (real(1.0) - wp.dot(y, Qy)) * p.axis
    G = p.gradient
    curl = wp.vec3d(G[2, 1] - G[1, 2], G[0, 2] - G[2, 0], G[1, 0] - G[0, 1]) - real(2.0) * wp.cross(Qy, p.axis)
    return u, real(0.5) * curl


def _flow_signature(x: wp.vec3d, t: wp.float64, p: Profile): ...


def _force_signature(x: wp.vec3d, s: wp.float64, t: wp.float64): ...


def written_flow(name: str, source: str) -> wp.Function:
    """A flow from source code, in a Warp module of this name; the source may use ``wp`` and ``Profile``."""
    return wp.Function(_flow_signature, key=name, namespace="", module=wp.get_module(name), source=source)


def written_force(name: str, source: str) -> wp.Function:
    """A force from source code, in a Warp module of this name."""
    return wp.Function(_force_signature, key=name, namespace="", module=wp.get_module(name), source=source)


@wp.func
def time_of(end: Scalars1D, rod: int) -> real:
    """The time of a rod: one for each, or one for all."""
    return end[wp.min(rod, end.shape[0] - 1)]


@functools.cache
def flow_kernel(flow: wp.Function) -> wp.Kernel:
    """A kernel that evaluates a flow at the times ``end`` [rod] or [1]; ``dim = (rods, nodes)``."""

    @wp.kernel(module="unique", enable_backward=False)
    def evaluate(position: Vectors2D, end: Scalars1D, outside: Outside):
        rod, node = wp.tid()
        u, spin = flow(position[rod, node], time_of(end, rod), outside.profile)
        outside.velocity[rod, node] = u
        outside.spin[rod, node] = spin

    return evaluate


@functools.cache
def force_kernel(force: wp.Function) -> wp.Kernel:
    """A kernel that evaluates force and couple, gravity included, at the times ``end``; ``dim = (rods, nodes)``."""

    @wp.kernel(module="unique", enable_backward=False)
    def evaluate(position: Vectors2D, end: Scalars1D, outside: Outside):
        rod, node = wp.tid()
        s = real(node) / real(position.shape[1] - 1) - real(0.5)
        f, c = force(position[rod, node], s, time_of(end, rod))
        outside.force[rod, node] = outside.weight[rod] + f
        outside.couple[rod, node] = c

    return evaluate

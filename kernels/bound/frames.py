"""Frames of surface-bound filaments in time and along the rod (docs/model.md §3.6).

The frame of the tracked node advances by an Adams-Bashforth mean and one exponential (5.52), (5.53), (D.74); a clamped
end stays. The other frames follow from it outwards (D.77), (D.81), (D.82), each projected onto the surface once.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_rods.kernels.bound.rod import angular_velocity, node_velocity, strain_of
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.bound.step import History
from warp_rods.kernels.clock import RATIO, STEP, TIME
from warp_rods.kernels.layout import Scalars1D, Vectors1D, real
from warp_rods.kernels.lie import advance, advance_along
from warp_rods.kernels.status import KINK, LEFT_DATA, OFF_SURFACE, OK
from warp_rods.kernels.surface.geometry import (
    ParameterArray,
    Parameters,
    curvature,
    frame,
    normal,
    normal_motion,
    to_surface,
    to_tangent,
)

wp.set_module_options({"enable_backward": False})

LARGEST_PROJECTION = wp.constant(real(1.0e-3))
"""Fraction of Δs. A tracked node that would be projected by more than this (and 0.1 Δt |u|) has left its surface."""

LARGEST_TURN = wp.constant(real(0.2))
"""Sine of the angle by which the tangent of a cell may leave the tangent plane before it is turned into it."""
LARGEST_SHIFT = wp.constant(real(0.1))
"""Fraction of Δs by which a node may be projected onto the surface."""
LARGEST_DISTANCE = wp.constant(real(0.01))
"""Fraction of Δs by which a node may be off the surface after it was projected."""
HALF_TURN = wp.constant(real(wp.pi))
"""Bending of a cell, in radians."""


@wp.func
def extrapolate(now: wp.vec3d, previous: wp.vec3d, ratio: real) -> wp.vec3d:
    """Two-step Adams-Bashforth mean over the next step, whose length is ``ratio`` times that of the last one."""
    return now + real(0.5) * ratio * (now - previous)


@wp.func
def first_column(R: wp.mat33d) -> wp.vec3d:
    return wp.vec3d(R[0, 0], R[1, 0], R[2, 0])


@wp.func
def second_column(R: wp.mat33d) -> wp.vec3d:
    return wp.vec3d(R[0, 1], R[1, 1], R[2, 1])


@wp.func
def third_column(R: wp.mat33d) -> wp.vec3d:
    return wp.vec3d(R[0, 2], R[1, 2], R[2, 2])


@wp.func
def is_inside(x: wp.vec3d, low: wp.vec3d, high: wp.vec3d) -> bool:
    """Whether x is in the box from ``low`` to ``high``."""
    return wp.min(x - low) >= real(0.0) and wp.min(high - x) >= real(0.0)


@functools.cache
def on_surface(field: wp.Function) -> SimpleNamespace:
    """Kernels that depend on the surface: ``place``, ``advance_tracked``, ``rebuild``, ``residuals``."""

    @wp.func
    def project(p: Parameters, x: wp.vec3d) -> wp.vec3d:
        """One Newton step towards the surface."""
        phi, g, _H = field(x, p)
        return to_surface(x, phi, g)

    @wp.func
    def store_frame(f: Filaments, past: History, p: Parameters, rod: int, i: int, R: wp.mat33d, r: wp.vec3d) -> real:
        """Store node i at r, with the tangent of R projected into the tangent plane; returns the distance |φ|/|∇φ|."""
        past.position[rod, i] = f.position[rod, i]
        past.rotation[rod, i] = f.rotation[rod, i]
        past.curvature[rod, i] = f.curvature[rod, i]
        phi, g, H = field(r, p)
        n = normal(g)
        q = to_tangent(first_column(R), n)
        f.position[rod, i] = r
        f.rotation[rod, i] = frame(q, n)
        f.curvature[rod, i] = curvature(g, H, q)
        return wp.abs(phi) / wp.length(g)

    @wp.func
    def curvature_at(p: Parameters, R: wp.mat33d, r: wp.vec3d) -> wp.vec3d:
        """(K11, K12, K22) at r for the tangent of R."""
        _phi, g, H = field(r, p)
        return curvature(g, H, to_tangent(first_column(R), normal(g)))

    @wp.func
    def advance_cell(f: Filaments, past: History, p: Parameters, rod: int, i: int, j: int, guess: wp.vec3d) -> bool:
        """Node j from its neighbour i: exp(Δs (A_i + A_j)/2) (D.77) in two sweeps, then projected onto the surface.

        The chord keeps the length that the exponential gives it, so that the projection does not stretch the rod.
        Returns whether the cell follows the surface: the projection and the turn of the tangent are small, and finite.
        """
        ds = f.spacing[rod] * real(j - i)
        R = f.rotation[rod, i]
        r = f.position[rod, i]
        strain_i = strain_of(f.curvature[rod, i], f.geodesic[rod, i])
        mean = real(0.5) * (strain_i + strain_of(guess, f.geodesic[rod, j]))
        Q, x = advance_along(R, r, mean, ds)
        mean = real(0.5) * (strain_i + strain_of(curvature_at(p, Q, x), f.geodesic[rod, j]))
        Q, x = advance_along(R, r, mean, ds)
        foot = project(p, x)
        chord = foot - r
        distance = store_frame(f, past, p, rod, j, Q, r + chord * (wp.length(x - r) / wp.length(chord)))
        turn = wp.abs(wp.dot(first_column(Q), third_column(f.rotation[rod, j])))
        h = f.spacing[rod]
        on_surface = wp.length(foot - x) < LARGEST_SHIFT * h and distance < LARGEST_DISTANCE * h
        return on_surface and turn < LARGEST_TURN and wp.length(mean) * h < HALF_TURN

    @wp.kernel(module="unique", enable_backward=False)
    def place(f: Filaments, past: History, parameters: ParameterArray, node: int):
        """Project the position and rotation of one node onto the surface, by Newton steps."""
        rod = wp.tid()
        r = f.position[rod, node]
        for _ in range(20):
            r = project(parameters[0], r)
        store_frame(f, past, parameters[0], rod, node, f.rotation[rod, node], r)

    @wp.kernel(module="unique", enable_backward=False)
    def advance_tracked(f: Filaments, past: History, parameters: ParameterArray, clock: Scalars1D):
        """Advance the frame of the tracked node by one step, and project it onto the surface.

        Two Newton steps are needed, because the error of the first is of second order in a step that may be long.
        """
        rod = wp.tid()
        if f.status[rod] != OK:
            return
        node = f.tracked
        dt = clock[STEP]
        ratio = clock[RATIO]
        omega = angular_velocity(f, rod, node)
        u = node_velocity(f, rod, node)
        omega_mean = extrapolate(omega, past.angular_velocity[rod], ratio)
        u_mean = extrapolate(u, past.velocity[rod], ratio)
        past.angular_velocity[rod] = omega
        past.velocity[rod] = u
        R, r = advance(f.rotation[rod, node], f.position[rod, node], omega_mean, u_mean, dt)
        x = project(parameters[0], project(parameters[0], r))
        if not (wp.length(x - r) < LARGEST_PROJECTION * f.spacing[rod] + real(0.1) * dt * wp.length(u_mean)):
            f.status[rod] = OFF_SURFACE
            past.failed_at[rod] = clock[TIME]
            return
        store_frame(f, past, parameters[0], rod, node, R, x)

    @wp.kernel(module="unique", enable_backward=False)
    def rebuild(f: Filaments, past: History, parameters: ParameterArray, node: int, low: wp.vec3d, high: wp.vec3d):
        """Frames from that of ``node`` towards both ends; one thread for each side of a rod.

        ``past.unfit`` [rod, side]: KINK if a cell does not follow the surface, LEFT_DATA if a node is outside the box
        from ``low`` to ``high``.
        """
        rod, side = wp.tid()
        if f.status[rod] != OK:
            return
        unfit = int(OK)
        if not is_inside(f.position[rod, node], low, high):
            unfit = int(LEFT_DATA)
        direction = 2 * side - 1
        count = node
        if side == 1:
            count = f.geodesic.shape[1] - 1 - node
        guess = f.curvature[rod, node]
        for k in range(count):
            i = node + direction * k
            follows = advance_cell(f, past, parameters[0], rod, i, i + direction, guess)
            if not follows and unfit == OK:
                unfit = int(KINK)
            if not is_inside(f.position[rod, i + direction], low, high) and unfit == OK:
                unfit = int(LEFT_DATA)
            guess = real(2.0) * f.curvature[rod, i + direction] - f.curvature[rod, i]
        past.unfit[rod, side] = unfit

    @wp.kernel(module="unique", enable_backward=False)
    def residuals(f: Filaments, parameters: ParameterArray, largest: Vectors1D):
        """The largest |φ|/|∇φ|, |q·n| and relative error of the length of a segment over the nodes of each rod."""
        rod = wp.tid()
        nodes = f.geodesic.shape[1]
        found = wp.vec3d()
        origin = wp.vec3d()
        for i in range(nodes):
            phi, g, _H = field(f.position[rod, i], parameters[0])
            q = first_column(f.rotation[rod, i])
            stretch = real(0.0)
            if i > 0:
                before = strain_of(f.curvature[rod, i - 1], f.geodesic[rod, i - 1])
                mean = real(0.5) * (before + strain_of(f.curvature[rod, i], f.geodesic[rod, i]))
                _R, chord = advance_along(f.rotation[rod, i], origin, mean, f.spacing[rod])
                actual = wp.length(f.position[rod, i] - f.position[rod, i - 1])
                stretch = wp.abs(actual / wp.length(chord) - real(1.0))
            found = wp.max(found, wp.vec3d(wp.abs(phi) / wp.length(g), wp.abs(wp.dot(q, normal(g))), stretch))
        largest[rod] = found

    return SimpleNamespace(place=place, advance_tracked=advance_tracked, rebuild=rebuild, residuals=residuals)


@functools.cache
def motion_of(field: wp.Function, rate: wp.Function) -> wp.Kernel:
    """The kernel of V and V_1 at nodes of a moving membrane; ``rate``: x, p, dp/dt -> ∂tφ, ∇∂tφ."""

    @wp.kernel(module="unique", enable_backward=False)
    def motion(f: Filaments, parameters: ParameterArray):
        """``parameters``: p, and dp/dt."""
        rod, i = wp.tid()
        r = f.position[rod, i]
        _phi, g, H = field(r, parameters[0])
        phi_t, gradient_t = rate(r, parameters[0], parameters[1])
        V, gradient = normal_motion(g, H, phi_t, gradient_t)
        f.normal_velocity[rod, i] = V
        f.normal_velocity_slope[rod, i] = wp.dot(second_column(f.rotation[rod, i]), gradient)

    return motion

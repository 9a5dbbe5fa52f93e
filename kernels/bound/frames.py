"""Frames of surface-bound filaments (model §3, "Time"; thesis 5.52, 5.53, D.74, D.81, D.82).

The frame of the middle node by AB2-Magnus (a clamped end's stays); the others outwards from it, each projected to
the surface once.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_rods.kernels.bound.rod import node_velocity, spin, strain
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.bound.step import History
from warp_rods.kernels.clock import RATIO, STEP, TIME
from warp_rods.kernels.layout import real
from warp_rods.kernels.lie import advance, advance_along
from warp_rods.kernels.status import OFF_SURFACE, SOUND
from warp_rods.kernels.surface.geometry import (
    Parameters,
    curvature,
    frame,
    normal,
    normal_motion,
    to_surface,
    to_tangent,
)

wp.set_module_options({"enable_backward": False})

FAR = wp.constant(real(1.0e-3))
"""A middle node that one Newton step must move by more than this share of Δs has left its surface."""


@wp.func
def extrapolate(now: wp.vec3d, before: wp.vec3d, ratio: real) -> wp.vec3d:
    """Two-step Adams-Bashforth mean over the coming step, whose length is ``ratio`` times the last."""
    return now + real(0.5) * ratio * (now - before)


@wp.func
def first_column(R: wp.mat33d) -> wp.vec3d:
    return wp.vec3d(R[0, 0], R[1, 0], R[2, 0])


@wp.func
def second_column(R: wp.mat33d) -> wp.vec3d:
    return wp.vec3d(R[0, 1], R[1, 1], R[2, 1])


@functools.cache
def on_surface(field: wp.Function) -> SimpleNamespace:
    """The kernels that need the surface: ``.advance_middle``, ``.rebuild``, ``.place``, ``.residuals``, ``.motion``."""

    @wp.func
    def on_phi(p: Parameters, x: wp.vec3d) -> wp.vec3d:
        """One Newton step towards the surface."""
        phi, g, _H = field(x, p)
        return to_surface(x, phi, g)

    @wp.func
    def settle(f: Filaments, p: Parameters, rod: int, i: int, R: wp.mat33d, r: wp.vec3d):
        """Store node i at r with the tangent of R turned into the tangent plane."""
        _phi, g, H = field(r, p)
        n = normal(g)
        q = to_tangent(first_column(R), n)
        f.position[rod, i] = r
        f.rotation[rod, i] = frame(q, n)
        f.curvature[rod, i] = curvature(g, H, q)

    @wp.func
    def next_curvature(p: Parameters, R: wp.mat33d, r: wp.vec3d) -> wp.vec3d:
        _phi, g, H = field(r, p)
        return curvature(g, H, to_tangent(first_column(R), normal(g)))

    @wp.func
    def cell(f: Filaments, p: Parameters, rod: int, i: int, j: int, guess: wp.vec3d):
        """Node j from its neighbour i: exp(Δs (A_i + A_j)/2) (D.77), two sweeps, then onto the surface.

        The chord keeps the length that its helix gives it, so that projecting does not stretch the rod.
        """
        ds = f.spacing[rod] * real(j - i)
        R = f.rotation[rod, i]
        r = f.position[rod, i]
        here = strain(f.curvature[rod, i], f.geodesic[rod, i])
        mean = real(0.5) * (here + strain(guess, f.geodesic[rod, j]))
        Q, x = advance_along(R, r, mean, ds)
        mean = real(0.5) * (here + strain(next_curvature(p, Q, x), f.geodesic[rod, j]))
        Q, x = advance_along(R, r, mean, ds)
        chord = on_phi(p, x) - r
        settle(f, p, rod, j, Q, r + chord * (wp.length(x - r) / wp.length(chord)))

    @wp.kernel(module="unique", enable_backward=False)
    def place(f: Filaments, parameters: wp.array(dtype=Parameters), node: int):
        """One node's frame put on the surface, as given in position and rotation, by Newton steps."""
        rod = wp.tid()
        r = f.position[rod, node]
        for _ in range(20):
            r = on_phi(parameters[0], r)
        settle(f, parameters[0], rod, node, f.rotation[rod, node], r)

    @wp.kernel(module="unique", enable_backward=False)
    def advance_middle(
        f: Filaments, past: History, parameters: wp.array(dtype=Parameters), clock: wp.array(dtype=wp.float64)
    ):
        """The middle frame over one step by AB2-Magnus, and onto the surface.

        Two Newton steps: the first leaves an error of second order in a step that may be long at the start.
        """
        rod = wp.tid()
        if f.status[rod] != SOUND:
            return
        middle = f.anchor
        dt = clock[STEP]
        ratio = clock[RATIO]
        omega = spin(f, rod, middle)
        u = node_velocity(f, rod, middle)
        omega_mean = extrapolate(omega, past.spin[rod], ratio)
        u_mean = extrapolate(u, past.velocity[rod], ratio)
        past.spin[rod] = omega
        past.velocity[rod] = u
        R, r = advance(f.rotation[rod, middle], f.position[rod, middle], omega_mean, u_mean, dt)
        x = on_phi(parameters[0], on_phi(parameters[0], r))
        if not (wp.length(x - r) < FAR * f.spacing[rod] + real(0.1) * dt * wp.length(u_mean)):
            f.status[rod] = OFF_SURFACE
            past.failed_at[rod] = clock[TIME]
            return
        settle(f, parameters[0], rod, middle, R, x)

    @wp.kernel(module="unique", enable_backward=False)
    def rebuild(f: Filaments, parameters: wp.array(dtype=Parameters), middle: int):
        """Frames from the middle node to either end; one thread a half rod."""
        rod, side = wp.tid()
        if f.status[rod] != SOUND:
            return
        direction = 2 * side - 1
        count = middle
        if side == 1:
            count = f.geodesic.shape[1] - 1 - middle
        guess = f.curvature[rod, middle]
        for k in range(count):
            i = middle + direction * k
            cell(f, parameters[0], rod, i, i + direction, guess)
            guess = real(2.0) * f.curvature[rod, i + direction] - f.curvature[rod, i]

    @wp.kernel(module="unique", enable_backward=False)
    def residuals(f: Filaments, parameters: wp.array(dtype=Parameters), worst: wp.array(dtype=wp.vec3d)):
        """Worst |φ|/|∇φ|, |q·n| and relative error of a segment's length over each rod's nodes."""
        rod = wp.tid()
        nodes = f.geodesic.shape[1]
        w = wp.vec3d()
        origin = wp.vec3d()
        for i in range(nodes):
            phi, g, _H = field(f.position[rod, i], parameters[0])
            q = first_column(f.rotation[rod, i])
            stretch = real(0.0)
            if i > 0:
                before = strain(f.curvature[rod, i - 1], f.geodesic[rod, i - 1])
                mean = real(0.5) * (before + strain(f.curvature[rod, i], f.geodesic[rod, i]))
                _R, chord = advance_along(f.rotation[rod, i], origin, mean, f.spacing[rod])
                actual = wp.length(f.position[rod, i] - f.position[rod, i - 1])
                stretch = wp.abs(actual / wp.length(chord) - real(1.0))
            w = wp.max(w, wp.vec3d(wp.abs(phi) / wp.length(g), wp.abs(wp.dot(q, normal(g))), stretch))
        worst[rod] = w

    @wp.kernel(module="unique", enable_backward=False)
    def motion(f: Filaments, parameters: wp.array(dtype=Parameters), span: real):
        """V and V_1 at nodes; parameters now, half a span of time before and after."""
        rod, i = wp.tid()
        r = f.position[rod, i]
        phi0, g0, _H0 = field(r, parameters[1])
        phi1, g1, _H1 = field(r, parameters[2])
        _phi, g, H = field(r, parameters[0])
        V, slope = normal_motion(g, H, (phi1 - phi0) / span, (g1 - g0) / span)
        f.normal_velocity[rod, i] = V
        f.normal_velocity_slope[rod, i] = wp.dot(second_column(f.rotation[rod, i]), slope)

    return SimpleNamespace(
        place=place, advance_middle=advance_middle, rebuild=rebuild, residuals=residuals, motion=motion
    )

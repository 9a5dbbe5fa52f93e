"""Frames of surface-bound filaments in time and along the rod (docs/model.md §3.6).

The frame of the tracked node is carried to the end of a step by one exponential, of its rates (4.29), (D.74) in steps
of its own, by the formula of Ω in steps together; a clamped end stays. The other frames follow from it outwards (D.77),
(D.81), (D.82), each projected onto the surface once.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_rods.kernels.bound.growth import Growth, set_length
from warp_rods.kernels.bound.levels import History, Plan, geodesic_at, turn_at
from warp_rods.kernels.bound.rod import strain_of
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.bound.step import accept, take_back
from warp_rods.kernels.layout import Scalars1D, Vectors1D, real
from warp_rods.kernels.lie import advance_along, se3_compose, se3_exp, se3_inverse, se3_log
from warp_rods.kernels.magnus import levels_of_rates, twist_over
from warp_rods.kernels.multistep import Levels, Pace, formula_of, times_of, weights_at
from warp_rods.kernels.status import HALF_TURN, KINK, LEFT_DATA, OFF_SURFACE, OK
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
    """Kernels that depend on the surface: ``place``, ``predict``, ``rebuild``, ``take``, ``show``, ``residuals``."""

    @wp.func
    def project(p: Parameters, x: wp.vec3d) -> wp.vec3d:
        """One Newton step towards the surface."""
        phi, g, _H = field(x, p)
        return to_surface(x, phi, g)

    @wp.func
    def store_frame(f: Filaments, p: Parameters, rod: int, i: int, R: wp.mat33d, r: wp.vec3d) -> real:
        """Store node i at r, with the tangent of R projected into the tangent plane; returns the distance |φ|/|∇φ|."""
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
    def advance_cell(f: Filaments, p: Parameters, rod: int, i: int, j: int, guess: wp.vec3d) -> bool:
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
        distance = store_frame(f, p, rod, j, Q, r + chord * (wp.length(x - r) / wp.length(chord)))
        turn = wp.abs(wp.dot(first_column(Q), third_column(f.rotation[rod, j])))
        h = f.spacing[rod]
        on_surface = wp.length(foot - x) < LARGEST_SHIFT * h and distance < LARGEST_DISTANCE * h
        return on_surface and turn < LARGEST_TURN and wp.length(mean) * h < HALF_TURN

    @wp.func
    def carried(
        past: History,
        p: Parameters,
        rod: int,
        R0: wp.mat33d,
        r0: wp.vec3d,
        at: Levels,
        levels: int,
        start: real,
        end: real,
        turn: real,
    ):
        """The frame of the tracked node carried from ``start`` to ``end`` by its rates and a turn about n.

        Returns rotation, position before and after two Newton steps towards the surface: the error of the first step
        is of second order in a step that may be long.
        """
        theta, mu = twist_over(past.angular_velocity, past.velocity, rod, at, levels, start, end)
        D, d = se3_exp(wp.vec3d(theta[0], theta[1], turn), mu)
        R, r = se3_compose(R0, r0, D, d)
        return R, r, project(p, project(p, r))

    @wp.func
    def stepped(
        past: History, p: Parameters, plan: Plan, rod: int, omega: wp.vec3d, u: wp.vec3d, scale: real, turn: real
    ):
        """The frame of the tracked node by the backward formula of Ω: x = x* + scale (A − d_1 ξ), A = (ω, u).

        x are screws from the last frame Sₙ, and ξ that to the frame before it. scale is 1/a, or 0 for the extrapolated
        frame. Stiff forces are stable only if place and shape, on both of which they depend, are advanced alike.
        """
        R0 = past.rotation[rod]
        r0 = past.position[rod]
        theta, mu = scale * omega, scale * u
        e1 = plan.value[rod][1]
        if e1 != real(0.0):
            back, away = se3_inverse(R0, r0)
            Q, q = se3_compose(back, away, past.rotation_before[rod], past.position_before[rod])
            xi_theta, xi_mu = se3_log(Q, q)
            b = e1 - scale * plan.slope[rod][1]
            theta += b * xi_theta
            mu += b * xi_mu
        D, d = se3_exp(wp.vec3d(theta[0], theta[1], turn), mu)
        R, r = se3_compose(R0, r0, D, d)
        return R, r, project(p, project(p, r))

    @wp.kernel(module="unique", enable_backward=False)
    def place(f: Filaments, past: History, parameters: ParameterArray, node: int):
        """Project the position and rotation of one node onto the surface, by Newton steps."""
        rod = wp.tid()
        r = f.position[rod, node]
        for _ in range(20):
            r = project(parameters[0], r)
        store_frame(f, parameters[0], rod, node, f.rotation[rod, node], r)

    @wp.kernel(module="unique", enable_backward=False)
    def predict(f: Filaments, past: History, pace: Pace, plan: Plan, growth: Growth, parameters: ParameterArray):
        """The formula of the step, and spacing and frame of the tracked node at its end; ``dim = rods``."""
        rod = wp.tid()
        if f.active[rod] == 0:
            return
        at = times_of(pace, rod)
        t = at[0] + pace.step[rod]
        formula = formula_of(at, pace.order[rod], t)
        plan.end[rod] = t
        plan.value[rod] = formula.value
        plan.slope[rod] = formula.slope
        plan.rate[rod] = formula.rate
        plan.turn_slope[rod] = turn_at(past, formula.slope, rod)
        set_length(f, growth, rod, t)
        R = past.rotation[rod]
        r = past.position[rod]
        levels = levels_of_rates(pace, rod, wp.max(pace.order[rod], 2))
        if levels > 0 and f.start_clamped + f.end_clamped == 0:
            turn = turn_at(past, formula.value, rod) - past.turn[rod, 0]
            if plan.together[rod] == 1:
                R, _r, r = stepped(past, parameters[0], plan, rod, wp.vec3d(), wp.vec3d(), real(0.0), turn)
            else:
                R, _r, r = carried(past, parameters[0], rod, R, r, at, levels, at[0], t, turn)
        elif f.membrane_moves == 1:
            r = project(parameters[0], project(parameters[0], r))
        store_frame(f, parameters[0], rod, f.tracked, R, r)

    @wp.kernel(module="unique", enable_backward=False)
    def rebuild(f: Filaments, plan: Plan, parameters: ParameterArray, node: int, low: wp.vec3d, high: wp.vec3d):
        """Frames from that of ``node`` towards both ends; one thread for each side of a rod.

        ``plan.unfit`` [rod, side]: KINK if a cell does not follow the surface, LEFT_DATA if a node is outside the box
        from ``low`` to ``high``.
        """
        rod, side = wp.tid()
        if f.active[rod] == 0:
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
            follows = advance_cell(f, parameters[0], rod, i, i + direction, guess)
            if not follows and unfit == OK:
                unfit = int(KINK)
            if not is_inside(f.position[rod, i + direction], low, high) and unfit == OK:
                unfit = int(LEFT_DATA)
            guess = real(2.0) * f.curvature[rod, i + direction] - f.curvature[rod, i]
        plan.unfit[rod, side] = unfit

    @wp.func
    def accept_frame(f: Filaments, past: History, pace: Pace, plan: Plan, p: Parameters, rod: int) -> int:
        """Carry the tracked node over the step that was taken; OFF_SURFACE if it would be projected too far."""
        if f.start_clamped + f.end_clamped > 0:
            return OK
        at = times_of(pace, rod)
        R0 = past.rotation[rod]
        r0 = past.position[rod]
        turn = past.turn[rod, 0] - past.turn[rod, 1]
        levels = levels_of_rates(pace, rod, wp.max(pace.order[rod], 2))
        R, r, x = carried(past, p, rod, R0, r0, at, levels, at[1], at[0], turn)
        if plan.together[rod] == 1:
            omega, u = plan.angular_velocity[rod], plan.velocity[rod]
            R, r, x = stepped(past, p, plan, rod, omega, u, real(1.0) / plan.rate[rod], turn)
        allowed = LARGEST_PROJECTION * f.spacing[rod] + real(0.1) * wp.length(x - r0)
        if not (wp.length(x - r) < allowed):
            return OFF_SURFACE
        past.rotation_before[rod] = R0
        past.position_before[rod] = r0
        _phi, g, _H = field(x, p)
        n = normal(g)
        past.rotation[rod] = frame(to_tangent(first_column(R), n), n)
        past.position[rod] = x
        return OK

    @wp.kernel(module="unique", enable_backward=False)
    def take(f: Filaments, past: History, pace: Pace, plan: Plan, parameters: ParameterArray):
        """Make the result of the step the present state; a rod without a valid one is frozen; ``dim = rods``."""
        rod = wp.tid()
        if f.active[rod] == 0:
            return
        start = pace.at[rod, 0]
        status = plan.status[rod]
        if status == OK:
            accept(f, past, pace, plan, rod)
            status = accept_frame(f, past, pace, plan, parameters[0], rod)
            if status != OK:
                take_back(f, past, pace, rod)
        if status != OK:
            f.status[rod] = status
            past.failed_at[rod] = start

    @wp.kernel(module="unique", enable_backward=False)
    def show(f: Filaments, past: History, pace: Pace, growth: Growth, target: Scalars1D, parameters: ParameterArray):
        """Ω, spacing and tracked frame at the time ``target[0]`` within the last step, or at its end."""
        rod = wp.tid()
        at = times_of(pace, rod)
        t = wp.min(target[0], at[0])
        w = weights_at(at, wp.min(pace.order[rod] + 1, pace.levels[rod]), t)
        for i in range(f.geodesic.shape[1]):
            f.geodesic[rod, i] = geodesic_at(past, w, rod, i)
        set_length(f, growth, rod, t)
        R = past.rotation[rod]
        r = past.position[rod]
        if t < at[0] and f.start_clamped + f.end_clamped == 0:
            turn = turn_at(past, w, rod) - past.turn[rod, 1]
            before = past.rotation_before[rod]
            R, _r, r = carried(
                past,
                parameters[0],
                rod,
                before,
                past.position_before[rod],
                at,
                levels_of_rates(pace, rod, wp.max(pace.order[rod], 2)),
                at[1],
                t,
                turn,
            )
        store_frame(f, parameters[0], rod, f.tracked, R, r)

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

    return SimpleNamespace(place=place, predict=predict, rebuild=rebuild, take=take, show=show, residuals=residuals)


@functools.cache
def motion_of(field: wp.Function, rate: wp.Function) -> wp.Kernel:
    """The kernel of V and V_1 at nodes of a moving membrane; ``rate``: x, p, dp/dt -> ∂tφ, ∇∂tφ."""

    @wp.kernel(module="unique", enable_backward=False)
    def motion(f: Filaments, parameters: ParameterArray):
        """``parameters``: p, and dp/dt."""
        rod, i = wp.tid()
        if f.active[rod] == 0:
            return
        r = f.position[rod, i]
        _phi, g, H = field(r, parameters[0])
        phi_t, gradient_t = rate(r, parameters[0], parameters[1])
        V, gradient = normal_motion(g, H, phi_t, gradient_t)
        f.normal_velocity[rod, i] = V
        f.normal_velocity_slope[rod, i] = wp.dot(second_column(f.rotation[rod, i]), gradient)

    return motion

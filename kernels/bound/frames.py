"""Frames of surface-bound filaments in time and along the rod (docs/model.md §3.6).

The frame of the tracked node is carried to the end of a step by one exponential, of its rates (4.29), (D.74) in steps
of its own, by the formula of Ω in steps together; a clamped end moves
with its membrane alone. The other frames follow from it outwards (D.77),
(D.81), (D.82), each projected onto the surface once.
"""

import functools
from types import SimpleNamespace

import warp as wp

from warp_rods.kernels.bound.cells import about_one_cell_further, one_cell_further
from warp_rods.kernels.bound.growth import Growth, length_at
from warp_rods.kernels.bound.levels import (
    History,
    Plan,
    WeightsArray,
    choose_equal_steps,
    choose_own_steps,
    set_geodesic,
    turn_at,
)
from warp_rods.kernels.bound.rod import strain_of
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.bound.step import accept, choose_next_step, keep_fields, repeat_or_accept, take_back
from warp_rods.kernels.clock import STEP
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    Lanes1D,
    Vector,
    add,
    cross,
    div,
    dot,
    inside,
    less,
    load,
    magnitude,
    mul,
    number_of,
    repeat_last,
    rods_in,
    set_number,
    sqrt,
    square,
    store_where,
    sub,
    vector_of,
    where,
)
from warp_rods.kernels.layout import Integers1D, Scalars1D, Vectors1D, real
from warp_rods.kernels.lie import advance_along, se3_compose, se3_exp, se3_inverse, se3_log
from warp_rods.kernels.magnus import levels_of_rates, twist_over
from warp_rods.kernels.multistep import (
    INFINITE,
    LEVELS,
    Formula,
    Levels,
    Pace,
    Weights,
    formula_of,
    times_of,
    weights_at,
)
from warp_rods.kernels.status import HALF_TURN, KINK, LEFT_DATA, NOT_FINITE, OFF_SURFACE, OK
from warp_rods.kernels.surface import tiles as surface
from warp_rods.kernels.surface.geometry import (
    ParameterArray,
    Parameters,
    frame,
    normal,
    normal_motion,
    to_surface,
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
def number_in(field: Lanes1D, rod: int) -> real:
    """The value of one rod."""
    return field[rod // WIDTH][rod % WIDTH]


@wp.func
def weight_of(weights: WeightsArray, rod: int, level: int) -> real:
    """The weight of a level of one rod."""
    return weights[rod // WIDTH][level, rod % WIDTH]


@wp.func
def tracked_moves(f: Filaments) -> bool:
    """Whether the tracked frame moves: a clamped one does so with its membrane alone."""
    return f.start_clamped + f.end_clamped == 0 or f.membrane_moves == 1


@wp.func
def first_reason(unfit: Lanes, ok: Lanes, reason: real) -> Lanes:
    """``unfit``, or the reason where it is 0 and ``ok`` is 0."""
    return where(unfit, unfit, where(ok, Lanes(), Lanes(reason)))


@functools.cache
def on_surface(field: wp.Function) -> SimpleNamespace:
    """Kernels that depend on the surface: ``place``, ``predict``, ``lay_out``, ``take``, ``show``, ``residuals``."""
    in_lanes = surface.in_lanes(field)

    @wp.func
    def project(p: Parameters, x: wp.vec3d) -> wp.vec3d:
        """One Newton step towards the surface."""
        phi, g, _H = field(x, p)
        return to_surface(x, phi, g)

    @wp.func
    def project_twice(p: Parameters, x: Vector) -> Vector:
        """Two Newton steps towards the surface: the error of the first is of second order in a step in time."""
        first, g, _H = in_lanes(x, p)
        y = x - g * (first / dot(g, g))
        second, h, _H = in_lanes(y, p)
        return y - h * (second / dot(h, h))

    @wp.func
    def store_frame(f: Filaments, p: Parameters, tile: int, i: int, tangent: Vector, r: Vector) -> Lanes:
        """Store the frame of node i at r, with the tangent projected into the tangent plane.

        Returns the distance |φ|/|∇φ|.
        """
        phi, g, H = in_lanes(r, p)
        per_size = real(1.0) / sqrt(dot(g, g))
        n = g * per_size
        q = surface.to_tangent(tangent, n)
        across = cross(n, q)
        f.tangent[tile, i] = q
        f.across[tile, i] = across
        f.normal[tile, i] = n
        f.curvature[tile, i] = surface.curvature(H, q, across, per_size)
        return magnitude(phi) * per_size

    @wp.func
    def advance_cell(f: Filaments, p: Parameters, tile: int, i: int, j: int, r: Vector, guess: Vector):
        """Node j from its neighbour i at r: exp(Δs (A_i + A_j)/2) (D.77) in two sweeps, then projected once.

        The first sweep, of less digits, takes ``guess`` for the curvature at j, the second that where the first one
        ends. φ where the second ends, which is very close, follows from its derivatives there. The chord keeps the
        length that the exponential gives it, so that the projection does not stretch the rod. Returns the place, and 1
        where the cell follows the surface: the projection and the turn of the tangent are small, and finite.
        """
        h = f.spacing[tile]
        ds = real(j - i) * h
        here, geodesic = strain_of(f.curvature[tile, i], f.geodesic[tile, i]), f.geodesic[tile, j]
        first, q = about_one_cell_further(f, tile, i, r, real(0.5) * (here + strain_of(guess, geodesic)), ds)
        phi, g, H = in_lanes(first, p)
        mean = real(0.5) * (here + strain_of(surface.curvature_of(g, H, q), geodesic))
        x, q = one_cell_further(f, tile, i, r, mean, ds)
        shift = surface.shift_to_surface(phi, g, H, x - first)
        arc, chord = x - r, x - shift - r
        place = r + chord * sqrt(dot(arc, arc) / dot(chord, chord))
        distance = store_frame(f, p, tile, j, q, place)
        near = less(dot(shift, shift), square(LARGEST_SHIFT * h)) * less(distance, LARGEST_DISTANCE * h)
        turn = magnitude(dot(q, f.normal[tile, j]))
        return place, near * less(turn, LARGEST_TURN) * less(dot(mean, mean) * square(h), HALF_TURN * HALF_TURN)

    @wp.func
    def lay_out_side(
        f: Filaments, p: Parameters, tile: int, start: int, way: int, start_place: Vector, low: wp.vec3d, high: wp.vec3d
    ) -> Lanes:
        """Frames from that of node ``start`` to an end (``way``: ±1); returns OK, or why rods cannot follow."""
        moving = load(f.active, tile)
        count = start
        if way == 1:
            count = f.geodesic.shape[1] - 1 - start
        r = start_place
        unfit = first_reason(Lanes(), inside(r, low, high), real(LEFT_DATA))
        before = f.curvature[tile, start]
        guess = before
        for k in range(count):
            i = start + way * k
            r, follows = advance_cell(f, p, tile, i, i + way, r, guess)
            store_where(f.position, tile, i + way, moving, r)
            unfit = first_reason(unfit, less(square(f.geodesic[tile, i + way]), INFINITE), real(NOT_FINITE))
            unfit = first_reason(unfit, follows, real(KINK))
            unfit = first_reason(unfit, inside(r, low, high), real(LEFT_DATA))
            here = f.curvature[tile, i + way]
            guess = real(2.0) * here - before
            before = here
        return unfit

    @wp.kernel(module="unique", enable_backward=False)
    def lay_out(f: Filaments, plan: Plan, parameters: ParameterArray, node: int, low: wp.vec3d, high: wp.vec3d):
        """Frames from ``plan.place`` and ``plan.tangent`` of ``node`` towards both ends; ``dim = tiles``.

        ``plan.unfit``: KINK if a cell does not follow the surface, LEFT_DATA if a node is outside the box from ``low``
        to ``high``.
        """
        tile = wp.tid()
        moving = load(f.active, tile)
        r = plan.place[tile]
        store_frame(f, parameters[0], tile, node, plan.tangent[tile], r)
        store_where(f.position, tile, node, moving, r)
        first = lay_out_side(f, parameters[0], tile, node, -1, r, low, high)
        second = lay_out_side(f, parameters[0], tile, node, 1, r, low, high)
        store_where(plan.unfit, tile, moving, where(less(first, second), second, first))

    @wp.func
    def carried(
        past: History,
        rod: int,
        R0: wp.mat33d,
        r0: wp.vec3d,
        at: Levels,
        levels: int,
        start: real,
        end: real,
        turn: real,
    ):
        """The frame of the tracked node carried from ``start`` to ``end`` by its rates and a turn about n."""
        theta, mu = twist_over(past.angular_velocity, past.velocity, rod, at, levels, start, end)
        D, d = se3_exp(wp.vec3d(theta[0], theta[1], turn), mu)
        return se3_compose(R0, r0, D, d)

    @wp.func
    def stepped(past: History, rod: int, back: real, theta: wp.vec3d, mu: wp.vec3d, turn: real):
        """The frame of the tracked node by the backward formula of Ω, and a turn about n.

        x are screws from the last frame Sₙ, and ξ that to the frame before it: x = (θ, μ) + ``back`` ξ, where
        x* + (A − d_1 ξ)/a with A = (ω, u) has (θ, μ) = A/a and e_1 − d_1/a; the extrapolated frame 0 and e_1. Stiff
        forces are stable only if place and shape, on both of which they depend, are advanced alike.
        """
        R0 = past.rotation[rod]
        r0 = past.position[rod]
        if back != real(0.0):
            inverse, away = se3_inverse(R0, r0)
            Q, q = se3_compose(inverse, away, past.rotation_before[rod], past.position_before[rod])
            xi_theta, xi_mu = se3_log(Q, q)
            theta += back * xi_theta
            mu += back * xi_mu
        D, d = se3_exp(wp.vec3d(theta[0], theta[1], turn), mu)
        return se3_compose(R0, r0, D, d)

    @wp.kernel(module="unique", enable_backward=False)
    def place(f: Filaments, plan: Plan, parameters: ParameterArray, node: int, direction: Vectors1D):
        """Project the place of one node onto the surface, and take the direction there; ``dim = tiles``."""
        tile = wp.tid()
        tangent, x = Vector(), Vector()
        for lane in range(rods_in(tile, f.status.shape[0])):
            rod = tile * WIDTH + lane
            f.active[rod] = 1
            r = f.position[rod, node]
            for _ in range(20):
                r = project(parameters[0], r)
            for j in range(3):
                tangent[j, lane] = direction[rod][j]
                x[j, lane] = r[j]
        plan.tangent[tile] = tangent
        plan.place[tile] = x

    @wp.func
    def set_length(f: Filaments, growth: Growth, tile: int, lane: int, t: real):
        """Spacing and dL/dt of a rod at time t."""
        rod = tile * WIDTH + lane
        length, rate = length_at(growth, rod, t)
        spacing, rates = f.spacing[tile], f.growth_rate[tile]
        spacing[lane] = length / real(f.geodesic.shape[1] - 1)
        rates[lane] = rate
        f.spacing[tile] = spacing
        f.growth_rate[tile] = rates
        f.spacing_of_rod[rod] = spacing[lane]

    @wp.func
    def foretold_frame(f: Filaments, past: History, pace: Pace, plan: Plan, formula: Formula, rod: int):
        """The extrapolated frame of the tracked node at the end of the step."""
        R = past.rotation[rod]
        r = past.position[rod]
        levels = levels_of_rates(pace, rod, wp.max(pace.order[rod], 2))
        if levels > 0 and tracked_moves(f):
            at = times_of(pace, rod)
            turn = turn_at(past, formula.value, rod) - past.turn[rod, 0]
            if plan.together[rod] == 1:
                return stepped(past, rod, formula.value[1], wp.vec3d(), wp.vec3d(), turn)
            return carried(past, rod, R, r, at, levels, at[0], plan.end[rod], turn)
        return R, r

    @wp.kernel(module="unique", enable_backward=False)
    def predict(
        f: Filaments,
        past: History,
        pace: Pace,
        plan: Plan,
        growth: Growth,
        own: int,
        clock: Scalars1D,
        behind: Integers1D,
        parameters: ParameterArray,
    ):
        """The formulas of the next steps, Ω at their ends, and the tracked frames there; ``dim = tiles``.

        Steps of the length in the clock, or each rod's own until it reaches ``clock[0]`` (``own`` = 1).
        """
        tile = wp.tid()
        if own == 1:
            choose_own_steps(tile, f, pace, plan, growth, clock[0], behind)
        else:
            choose_equal_steps(tile, f, pace, plan, clock[STEP])
        value, slope, rate, turn_slope = Weights(), Weights(), Lanes(real(1.0)), Lanes()
        tangent, x = Vector(), Vector()
        for lane in range(rods_in(tile, f.status.shape[0])):
            rod = tile * WIDTH + lane
            if f.active[rod] == 1:
                at = times_of(pace, rod)
                t = at[0] + pace.step[rod]
                formula = formula_of(at, pace.order[rod], t)
                for j in range(LEVELS):
                    value[j, lane] = formula.value[j]
                    slope[j, lane] = formula.slope[j]
                rate[lane] = formula.rate
                turn_slope[lane] = turn_at(past, formula.slope, rod)
                plan.end[rod] = t
                set_length(f, growth, tile, lane, t)
                R, r = foretold_frame(f, past, pace, plan, formula, rod)
                for j in range(3):
                    tangent[j, lane] = R[j, 0]
                    x[j, lane] = r[j]
        plan.value[tile] = value
        plan.slope[tile] = slope
        plan.rate[tile] = rate
        plan.turn_slope[tile] = turn_slope
        if tracked_moves(f):
            x = project_twice(parameters[0], x)
        plan.tangent[tile] = tangent
        plan.place[tile] = x
        set_geodesic(f, past, value, tile)

    @wp.func
    def next_frame(past: History, pace: Pace, plan: Plan, rod: int):
        """The tracked frame at the end of the step that was taken, before it is projected onto the surface."""
        at = times_of(pace, rod)
        turn = past.turn[rod, 0] - past.turn[rod, 1]
        if plan.together[rod] == 1:
            scale = real(1.0) / number_in(plan.rate, rod)
            back = weight_of(plan.value, rod, 1) - scale * weight_of(plan.slope, rod, 1)
            theta, mu = scale * plan.angular_velocity[rod], scale * plan.velocity[rod]
            return stepped(past, rod, back, theta, mu, turn)
        levels = levels_of_rates(pace, rod, wp.max(pace.order[rod], 2))
        return carried(past, rod, past.rotation[rod], past.position[rod], at, levels, at[1], at[0], turn)

    @wp.func
    def freeze(f: Filaments, past: History, rod: int, status: int, time: real):
        """Let a rod take no more steps."""
        f.status[rod] = status
        past.failed_at[rod] = time

    @wp.func
    def store_tracked_frames(
        f: Filaments, past: History, pace: Pace, p: Parameters, tile: int, taken: Lanes, tangent: Vector, r: Vector
    ):
        """Project the new tracked frames onto the surface; a rod that is projected too far returns to its last state.

        Returns where rods have taken the step.
        """
        kept = taken
        x = project_twice(p, r)
        _phi, g, _H = in_lanes(x, p)
        n = g * (real(1.0) / sqrt(dot(g, g)))
        q = surface.to_tangent(tangent, n)
        for lane in range(rods_in(tile, f.status.shape[0])):
            rod = tile * WIDTH + lane
            if taken[lane] != real(0.0):
                end = wp.vec3d(x[0, lane], x[1, lane], x[2, lane])
                shift = wp.length(end - wp.vec3d(r[0, lane], r[1, lane], r[2, lane]))
                allowed = LARGEST_PROJECTION * f.spacing_of_rod[rod] + real(0.1) * wp.length(end - past.position[rod])
                if shift < allowed:
                    past.rotation_before[rod] = past.rotation[rod]
                    past.position_before[rod] = past.position[rod]
                    along = wp.vec3d(q[0, lane], q[1, lane], q[2, lane])
                    past.rotation[rod] = frame(along, wp.vec3d(n[0, lane], n[1, lane], n[2, lane]))
                    past.position[rod] = end
                else:
                    freeze(f, past, rod, OFF_SURFACE, pace.at[rod, 1])
                    take_back(past, pace, rod)
                    kept[lane] = real(0.0)
        return kept

    @wp.kernel(module="unique", enable_backward=False)
    def take(
        f: Filaments, past: History, pace: Pace, plan: Plan, own: int, target: Scalars1D, parameters: ParameterArray
    ):
        """Make the result of the step the present state; a rod without a valid one is frozen; ``dim = tiles``.

        For steps of each rod's own (``own`` = 1) only where the error is small enough, and with the choice of the next.
        """
        tile = wp.tid()
        taken, tangent, r = Lanes(), Vector(), Vector()
        for lane in range(rods_in(tile, f.status.shape[0])):
            rod = tile * WIDTH + lane
            if own == 1 and f.active[rod] == 1:
                repeat_or_accept(f, past, pace, plan, target, rod)
            if f.active[rod] == 1:
                if plan.status[rod] == OK:
                    accept(past, pace, plan, rod)
                    taken[lane] = real(1.0)
                    if tracked_moves(f):
                        R, place = next_frame(past, pace, plan, rod)
                        for j in range(3):
                            tangent[j, lane] = R[j, 0]
                            r[j, lane] = place[j]
                else:
                    freeze(f, past, rod, plan.status[rod], pace.at[rod, 0])
        if tracked_moves(f):
            taken = store_tracked_frames(f, past, pace, parameters[0], tile, taken, tangent, r)
        if own == 1:
            for lane in range(rods_in(tile, f.status.shape[0])):
                choose_next_step(f, pace, plan, target, tile * WIDTH + lane)
        keep_fields(f, past, tile, repeat_last(tile, f.status.shape[0], taken))

    @wp.kernel(module="unique", enable_backward=False)
    def show(
        f: Filaments,
        past: History,
        pace: Pace,
        plan: Plan,
        growth: Growth,
        target: Scalars1D,
        parameters: ParameterArray,
    ):
        """Ω, spacing and tracked frames at the time ``target[0]`` in the last step, or at its end; ``dim = tiles``."""
        tile = wp.tid()
        w, tangent, x, within = Weights(), Vector(), Vector(), Lanes()
        for lane in range(rods_in(tile, f.status.shape[0])):
            rod = tile * WIDTH + lane
            f.active[rod] = 1
            at = times_of(pace, rod)
            t = wp.min(target[0], at[0])
            e = weights_at(at, wp.min(pace.order[rod] + 1, pace.levels[rod]), t)
            set_length(f, growth, tile, lane, t)
            R = past.rotation[rod]
            r = past.position[rod]
            if t < at[0] and tracked_moves(f):
                turn = turn_at(past, e, rod) - past.turn[rod, 1]
                before, origin = past.rotation_before[rod], past.position_before[rod]
                levels = levels_of_rates(pace, rod, wp.max(pace.order[rod], 2))
                R, r = carried(past, rod, before, origin, at, levels, at[1], t, turn)
                within[lane] = real(1.0)
            for j in range(LEVELS):
                w[j, lane] = e[j]
            for j in range(3):
                tangent[j, lane] = R[j, 0]
                x[j, lane] = r[j]
        set_geodesic(f, past, w, tile)
        plan.tangent[tile] = tangent
        plan.place[tile] = where(within, project_twice(parameters[0], x), x)

    @wp.kernel(module="unique", enable_backward=False)
    def residuals(f: Filaments, parameters: ParameterArray, largest: Vectors1D):
        """The largest |φ|/|∇φ|, |q·n| and relative error of the length of a segment over the nodes of each rod."""
        rod = wp.tid()
        found = wp.vec3d()
        before = wp.vec3d()
        for i in range(f.geodesic.shape[1]):
            phi, g, _H = field(f.position[rod, i], parameters[0])
            q = vector_of(f.tangent, rod, i)
            K = vector_of(f.curvature, rod, i)
            strain = wp.vec3d(K[1], -K[0], number_of(f.geodesic, rod, i))
            stretch = real(0.0)
            if i > 0:
                mean = real(0.5) * (before + strain)
                _R, chord = advance_along(wp.identity(n=3, dtype=real), wp.vec3d(), mean, f.spacing_of_rod[rod])
                actual = wp.length(f.position[rod, i] - f.position[rod, i - 1])
                stretch = wp.abs(actual / wp.length(chord) - real(1.0))
            found = wp.max(found, wp.vec3d(wp.abs(phi) / wp.length(g), wp.abs(wp.dot(q, normal(g))), stretch))
            before = strain
        largest[rod] = found

    return SimpleNamespace(place=place, predict=predict, lay_out=lay_out, take=take, show=show, residuals=residuals)


@functools.cache
def motion_of(field: wp.Function, rate: wp.Function) -> wp.Kernel:
    """The kernel of V and V_1 at nodes of a moving membrane; ``rate``: x, p, dp/dt -> ∂tφ, ∇∂tφ."""

    @wp.kernel(module="unique", enable_backward=False)
    def motion(f: Filaments, parameters: ParameterArray):
        """``parameters``: p, and dp/dt; ``dim = (rods, nodes)``."""
        rod, i = wp.tid()
        if f.active[rod] == 0:
            return
        r = f.position[rod, i]
        _phi, g, H = field(r, parameters[0])
        phi_t, gradient_t = rate(r, parameters[0], parameters[1])
        V, gradient = normal_motion(g, H, phi_t, gradient_t)
        set_number(f.normal_velocity, rod, i, V)
        set_number(f.normal_velocity_slope, rod, i, wp.dot(vector_of(f.across, rod, i), gradient))

    return motion

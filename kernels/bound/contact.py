"""Contact as drag in a step of surface-bound filaments (docs/model.md §6.4, ``contact_drag.py``).

With the velocity v = Σ d_j r_j that belongs to r*, the formula of a step is u = a (r − r*) + v, so that what holds a
node back from leaving r** = r* + θ (r − r*)ⁿ is a drag, in the tangent plane C11, C12, C22::

    F(r*) − D (u − v**),     v** = v + a θ (r − r*)ⁿ,     v ← v + (u − v)/(a Δt)

v and r − r* are carried from step to step as their own velocities give them. Differences of places in space,
(r*ⁿ⁺¹ − r*ⁿ)/Δt, are unstable in stiff contact.
"""

import warp as wp

from warp_rods.kernels.bound.angles import velocity_increment
from warp_rods.kernels.bound.levels import History, Plan
from warp_rods.kernels.bound.rod import velocity_along_at
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.contact_drag import alternating, drag_in_plane, principal, share_foretold
from warp_rods.kernels.layout import Matrices2D, Quadruples2D, real
from warp_rods.kernels.multistep import Formula, Pace, times_of

wp.set_module_options({"enable_backward": False})


@wp.func
def drag_times(C: wp.vec3d, u: wp.vec2d) -> wp.vec2d:
    """C u in the tangent plane."""
    return wp.vec2d(C[0] * u[0] + C[1] * u[1], C[1] * u[0] + C[2] * u[1])


@wp.func
def velocity_at(f: Filaments, plan: Plan, weights: Quadruples2D, rod: int, i: int) -> wp.vec2d:
    """(u1, u2) of a node at the end of the step."""
    return wp.vec2d(
        velocity_along_at(f, rod, i), f.velocity_across[rod, i] + velocity_increment(plan.turn, weights, rod, i)
    )


@wp.func
def formula_at(plan: Plan, pace: Pace, rod: int) -> Formula:
    """The formula of the step of a rod."""
    formula = Formula()
    formula.value = plan.value[rod]
    formula.slope = plan.slope[rod]
    formula.rate = plan.rate[rod]
    formula.order = pace.order[rod]
    return formula


@wp.kernel
def set_contact_drag(f: Filaments, past: History, pace: Pace, plan: Plan, stiffness: Matrices2D):
    """C of each node from K [rod, node] in space, and D v** added to the force; ``dim = rods``."""
    rod = wp.tid()
    if f.active[rod] == 0:
        return
    terms = alternating(times_of(pace, rod), pace.levels[rod], formula_at(plan, pace, rod), plan.end[rod])
    drag = wp.min(f.drag[rod][0], f.drag[rod][1])
    for i in range(f.geodesic.shape[1]):
        R = f.rotation[rod, i]
        in_frame = wp.transpose(R) * stiffness[rod, i] * R
        K = wp.vec3d(in_frame[0, 0], in_frame[0, 1], in_frame[1, 1])
        kappa = principal(K)
        share = share_foretold(kappa[0] + kappa[1], drag, terms)
        C = drag_in_plane(K, drag, share, terms)
        beyond = terms.rate * terms.ratio * share
        foretold = past.contact_velocity[rod, i] + beyond * past.contact_lag[rod, i]
        push = drag_times(C, foretold)
        past.contact_foretold[rod, i] = foretold
        f.contact_drag[rod, i] = C
        f.force[rod, i] += R * wp.vec3d(push[0], push[1], real(0.0))


@wp.func
def contact_error(f: Filaments, past: History, plan: Plan, weights: Quadruples2D, rod: int, dt: real) -> real:
    """Error of a step in places: what D (u − v**) would move the nodes on the average, against drag and D, over L."""
    total = real(0.0)
    nodes = f.geodesic.shape[1]
    drag = f.drag[rod]
    for i in range(nodes):
        C = f.contact_drag[rod, i]
        lag = drag_times(C, velocity_at(f, plan, weights, rod, i) - past.contact_foretold[rod, i])
        total += wp.length(lag) / (wp.min(drag[0], drag[1]) + C[0] + C[2])
    length = f.spacing[rod] * real(nodes - 1)
    return dt * total / (real(nodes) * length)


@wp.kernel
def find_contact_errors(f: Filaments, past: History, pace: Pace, plan: Plan, weights: Quadruples2D):
    """Let the errors of the step count ``contact_error``; ``dim = rods``."""
    rod = wp.tid()
    if f.active[rod] == 1:
        dt = plan.end[rod] - pace.at[rod, 0]
        plan.error[rod] = wp.max(plan.error[rod], contact_error(f, past, plan, weights, rod, dt))


@wp.kernel
def keep_contact_velocity(f: Filaments, past: History, pace: Pace, plan: Plan, weights: Quadruples2D):
    """v and r − r* for the next step; before the step is the newest level; ``dim = (rods, nodes)``."""
    rod, i = wp.tid()
    if f.active[rod] == 1:
        v = past.contact_velocity[rod, i]
        lag = (velocity_at(f, plan, weights, rod, i) - v) / plan.rate[rod]
        past.contact_lag[rod, i] = lag
        past.contact_velocity[rod, i] = v + lag / (plan.end[rod] - pace.at[rod, 0])

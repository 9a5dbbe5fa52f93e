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
from warp_rods.kernels.bound.state import Filaments, Systems
from warp_rods.kernels.contact_drag import alternating, drag_in_plane, principal, share_foretold
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Lanes,
    Pair,
    Vector,
    add,
    div,
    dot,
    load,
    mul,
    pair,
    smaller,
    sqrt,
    sub,
    vector,
)
from warp_rods.kernels.layout import real
from warp_rods.kernels.multistep import Pace

wp.set_module_options({"enable_backward": False})


@wp.func
def drag_times(C: Vector, u: Pair) -> Pair:
    """C u in the tangent plane."""
    return pair(C[0] * u[0] + C[1] * u[1], C[1] * u[0] + C[2] * u[1])


@wp.func
def velocity_at(f: Filaments, systems: Systems, tile: int, i: int) -> Pair:
    """(u1, u2) of a node at the end of the step."""
    increment = velocity_increment(systems.turn, systems.weights, tile, i)
    return pair(velocity_along_at(f, tile, i), f.velocity_across[tile, i] + increment)


@wp.func
def set_contact_drag(f: Filaments, past: History, pace: Pace, plan: Plan, tile: int):
    """C of each node from K [rod, node] in space, and D v** added to the load."""
    e, d = plan.value[tile], plan.slope[tile]
    terms = alternating(tile, pace, pace.order, plan.end, e, d, plan.rate[tile])
    for i in range(f.geodesic.shape[1]):
        drag = smaller(f.drag[tile, i][0], f.drag[tile, i][1])
        q, across = f.tangent[tile, i], f.across[tile, i]
        stiffness = load(f.contact_stiffness, tile, i)
        K2 = stiffness * across
        K = vector(dot(q, stiffness * q), dot(q, K2), dot(across, K2))
        kappa = principal(K)
        share = share_foretold(kappa[0] + kappa[1], drag, terms)
        C = drag_in_plane(K, drag, share, terms)
        beyond = terms.rate * terms.ratio * share
        foretold = past.contact_velocity[tile, i] + beyond * past.contact_lag[tile, i]
        push = drag_times(C, foretold)
        past.contact_foretold[tile, i] = foretold
        f.contact_drag[tile, i] = C
        f.load[tile, i] = f.load[tile, i] + vector(push[0], push[1], Lanes())


@wp.func
def contact_error(f: Filaments, past: History, systems: Systems, tile: int, dt: Lanes) -> Lanes:
    """Error of a step in places: what D (u − v**) would move the nodes on the average, against drag and D, over L."""
    total = Lanes()
    nodes = f.geodesic.shape[1]
    for i in range(nodes):
        drag = f.drag[tile, i]
        C = f.contact_drag[tile, i]
        lag = drag_times(C, velocity_at(f, systems, tile, i) - past.contact_foretold[tile, i])
        total += sqrt(dot(lag, lag)) / (smaller(drag[0], drag[1]) + C[0] + C[2])
    length = f.spacing[tile] * real(nodes - 1)
    return dt * total / (real(nodes) * length)


@wp.func
def find_contact_velocity(f: Filaments, past: History, plan: Plan, systems: Systems, tile: int, dt: Lanes):
    """v and r − r* for the next step, kept beside those of this one."""
    for i in range(f.geodesic.shape[1]):
        v = past.contact_velocity[tile, i]
        lag = (velocity_at(f, systems, tile, i) - v) / plan.rate[tile]
        past.contact_lag_tried[tile, i] = lag
        past.contact_velocity_tried[tile, i] = v + lag / dt

"""Contact as drag in a step of surface-bound filaments (docs/model.md §6.4).

Contact with the force F(r) and the stiffness K = −∂F/∂r at the extrapolated places r* would be implicit with
F(r*) − K (r − r*) for F. As both nodes of a pair move, take 2K. The formula of a step is u = a (r − r*) + v, where v is
the velocity Σ d_j r_j, so that contact becomes a drag D = 2K/a::

    F(r*) − D (u − v),      v ← v + (u − v)/(a Δt)

v is carried from step to step as its own velocities give it. Differences of places, (r*ⁿ⁺¹ − r*ⁿ)/Δt, are unstable in
stiff contact. The parts of D in the tangent plane are C11, C12, C22.
"""

import warp as wp

from warp_rods.kernels.bound.angles import velocity_increment
from warp_rods.kernels.bound.levels import History, Plan
from warp_rods.kernels.bound.rod import velocity_along_at
from warp_rods.kernels.bound.state import Filaments, Systems
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Lanes,
    Pair,
    Vector,
    add,
    div,
    dot,
    load_times,
    mul,
    pair,
    smaller,
    sqrt,
    sub,
    vector,
)
from warp_rods.kernels.layout import real

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
def set_contact_drag(f: Filaments, past: History, plan: Plan, tile: int):
    """C of each node from K [rod, node] in space, and D v added to the load."""
    scale = real(2.0) / plan.rate[tile]
    for i in range(f.geodesic.shape[1]):
        q, across = f.tangent[tile, i], f.across[tile, i]
        Kq = load_times(f.contact_stiffness, tile, i, q)
        K2 = load_times(f.contact_stiffness, tile, i, across)
        C = scale * vector(dot(q, Kq), dot(q, K2), dot(across, K2))
        push = drag_times(C, past.contact_velocity[tile, i])
        f.contact_drag[tile, i] = C
        f.load[tile, i] = f.load[tile, i] + vector(push[0], push[1], Lanes())


@wp.func
def contact_error(f: Filaments, past: History, systems: Systems, tile: int, dt: Lanes) -> Lanes:
    """Error of a step in places: what D (u − v)/2 would move the nodes on the average, against drag and D, over L.

    Half of D stands for the other node of a pair. Where that moves alike this half is in error.
    """
    total = Lanes()
    nodes = f.geodesic.shape[1]
    drag = f.drag[tile]
    for i in range(nodes):
        C = f.contact_drag[tile, i]
        lag = drag_times(C, velocity_at(f, systems, tile, i) - past.contact_velocity[tile, i])
        total += sqrt(dot(lag, lag)) / (smaller(drag[0], drag[1]) + C[0] + C[2])
    length = f.spacing[tile] * real(nodes - 1)
    return real(0.5) * dt * total / (real(nodes) * length)


@wp.func
def find_contact_velocity(f: Filaments, past: History, plan: Plan, systems: Systems, tile: int, dt: Lanes):
    """v of the next step, kept beside that of this one."""
    scale = plan.rate[tile] * dt
    for i in range(f.geodesic.shape[1]):
        v = past.contact_velocity[tile, i]
        past.contact_velocity_tried[tile, i] = v + (velocity_at(f, systems, tile, i) - v) / scale

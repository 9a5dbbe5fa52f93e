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
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.layout import Matrices2D, Quadruples2D, real
from warp_rods.kernels.multistep import Pace

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


@wp.kernel
def set_contact_drag(f: Filaments, past: History, plan: Plan, stiffness: Matrices2D):
    """C of each node from K [rod, node] in space, and D v added to the force; ``dim = (rods, nodes)``."""
    rod, i = wp.tid()
    if f.active[rod] == 0:
        return
    R = f.rotation[rod, i]
    D = (real(2.0) / plan.rate[rod]) * (wp.transpose(R) * stiffness[rod, i] * R)
    C = wp.vec3d(D[0, 0], D[0, 1], D[1, 1])
    push = drag_times(C, past.contact_velocity[rod, i])
    f.contact_drag[rod, i] = C
    f.force[rod, i] += R * wp.vec3d(push[0], push[1], real(0.0))


@wp.func
def contact_error(f: Filaments, past: History, plan: Plan, weights: Quadruples2D, rod: int, dt: real) -> real:
    """Error of a step in places: what D (u − v)/2 would move the nodes on the average, against drag and D, over L.

    Half of D stands for the other node of a pair. Where that moves alike this half is in error.
    """
    total = real(0.0)
    nodes = f.geodesic.shape[1]
    drag = f.drag[rod]
    for i in range(nodes):
        C = f.contact_drag[rod, i]
        lag = drag_times(C, velocity_at(f, plan, weights, rod, i) - past.contact_velocity[rod, i])
        total += wp.length(lag) / (wp.min(drag[0], drag[1]) + C[0] + C[2])
    length = f.spacing[rod] * real(nodes - 1)
    return real(0.5) * dt * total / (real(nodes) * length)


@wp.kernel
def find_contact_errors(f: Filaments, past: History, pace: Pace, plan: Plan, weights: Quadruples2D):
    """Let the errors of the step count ``contact_error``; ``dim = rods``."""
    rod = wp.tid()
    if f.active[rod] == 1:
        dt = plan.end[rod] - pace.at[rod, 0]
        plan.error[rod] = wp.max(plan.error[rod], contact_error(f, past, plan, weights, rod, dt))


@wp.kernel
def keep_contact_velocity(f: Filaments, past: History, pace: Pace, plan: Plan, weights: Quadruples2D):
    """v of the next step; before the step is the newest level; ``dim = (rods, nodes)``."""
    rod, i = wp.tid()
    if f.active[rod] == 1:
        v = past.contact_velocity[rod, i]
        scale = plan.rate[rod] * (plan.end[rod] - pace.at[rod, 0])
        past.contact_velocity[rod, i] = v + (velocity_at(f, plan, weights, rod, i) - v) / scale

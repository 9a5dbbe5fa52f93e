"""External forces and contact on active rods, in their Bishop frame (docs/model.md §2.4).

Contact with the force F(r) and the stiffness K = −∂F/∂r at the extrapolated places r* would be implicit with
F(r*) − K (r − r*) for F. As both nodes of a pair move, take 2K. The formula of a step is u = a (r − r*) + v, where v is
the velocity Σ d_j r_j, so that contact becomes a drag D = 2K/a::

    F(r*) − D (u − v),      v ← v + (u − v)/(a Δt)

v is carried from step to step as its own velocities give it; from places in space it would differ from u by terms of
second order in Δs. Drag along and drag across are kept apart: D is replaced by the block-diagonal matrix
(D00 + |D0⊥|, D⊥⊥ + D⊥0 D0⊥/|D0⊥|), which is not less than D and vanishes where D does, so that rods slide freely.
"""

import warp as wp

from warp_rods.kernels.free.state import Balance, Contact, Load, Swimmers, Trial
from warp_rods.kernels.layout import Matrices2D, Scalars1D, Vectors2D, real

wp.set_module_options({"enable_backward": False})


@wp.func
def body_force(rod: int, node: int, rotation: Matrices2D, force: Vectors2D):
    """Components in the Bishop frame of a force in space."""
    return wp.transpose(rotation[rod, node]) * force[rod, node]


@wp.func
def contact_drag(rod: int, node: int, rotation: Matrices2D, stiffness: Matrices2D, scale: real):
    """Drag along and across, the blocks of a matrix that is not less than ``scale`` K."""
    R = rotation[rod, node]
    D = scale * (wp.transpose(R) * stiffness[rod, node] * R)
    coupling = wp.vec2d(D[0, 1], D[0, 2])
    size = wp.length(coupling)
    across = wp.mat22d(D[1, 1], D[1, 2], D[1, 2], D[2, 2])
    if size > real(0.0):
        across += wp.outer(coupling, coupling) / size
    return D[0, 0] + size, across


@wp.kernel
def find_force(rotation: Matrices2D, force: Vectors2D, load: Load):
    """The load of an external force in space; ``dim = (rods, nodes)``."""
    rod, node = wp.tid()
    here = body_force(rod, node, rotation, force)
    load.transverse_force[rod, node] = wp.vec2d(here[1], here[2])
    if node < force.shape[1] - 1:
        load.axial_force[rod, node] = real(0.5) * (here[0] + body_force(rod, node + 1, rotation, force)[0])


@wp.kernel
def add_contact_drag(rotation: Matrices2D, contact: Contact, trial: Trial, load: Load):
    """Add contact as drag, D = 2K/a, and the force D v; ``dim = (rods, nodes)``."""
    rod, node = wp.tid()
    scale = real(2.0) / trial.rate[rod]
    along, across = contact_drag(rod, node, rotation, contact.stiffness, scale)
    v = contact.velocity[rod, node]
    load.transverse_drag[rod, node] = across
    load.transverse_force[rod, node] = load.transverse_force[rod, node] + across * wp.vec2d(v[1], v[2])
    if node < contact.velocity.shape[1] - 1:
        along_next, _across = contact_drag(rod, node + 1, rotation, contact.stiffness, scale)
        drag = real(0.5) * (along + along_next)
        load.axial_drag[rod, node] = drag
        load.axial_force[rod, node] = load.axial_force[rod, node] + drag * v[0]


@wp.func
def step_velocity(rod: int, contact: Contact, balance: Balance, scale: real):
    """v at the end of the step; scale: a Δt."""
    for node in range(contact.velocity.shape[1]):
        v = contact.velocity[rod, node]
        across = balance.transverse_velocity[rod, node]
        u = wp.vec3d(balance.axial_velocity[rod, node], across[0], across[1])
        contact.velocity_tried[rod, node] = v + (u - v) / scale


@wp.func
def contact_error(rod: int, rods: Swimmers, contact: Contact, balance: Balance, dt: real):
    """Error of a step in places: what D (u − v)/2 would move the nodes on the average, against drag and D.

    Half of D stands for the other node of a pair. Where that moves alike, or is a wall, this half is in error.
    """
    total = real(0.0)
    nodes = contact.velocity.shape[1]
    for node in range(nodes):
        v = contact.velocity[rod, node]
        drag = balance.load.axial_drag[rod, node]
        along = drag * (balance.axial_velocity[rod, node] - v[0]) / (real(1.0) + drag)
        lag = balance.transverse_velocity[rod, node] - wp.vec2d(v[1], v[2])
        D = balance.load.transverse_drag[rod, node]
        across = D * lag / (rods.drag_ratio[rod] + wp.trace(D))
        total += wp.sqrt(along * along + wp.dot(across, across))
    return real(0.5) * dt * total / real(nodes)


def force_field(function):
    """A kernel that evaluates ``function(x, tangent, t)``, a ``wp.func``, at every node; ``dim = (rods, nodes)``.

    The first two numbers of ``time`` add up to t: the clock gives the end of the step.
    """

    @wp.kernel(module="unique", enable_backward=False)
    def evaluate(position: Vectors2D, rotation: Matrices2D, time: Scalars1D, force: Vectors2D):
        rod, node = wp.tid()
        R = rotation[rod, node]
        tangent = wp.vec3d(R[0, 0], R[1, 0], R[2, 0])
        force[rod, node] = function(position[rod, node], tangent, time[0] + time[1])

    return evaluate

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

from warp_rods.kernels.free.state import Balance, Contact, Load, Swimmers
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    add,
    block,
    div,
    dot,
    mul,
    pair,
    rods_in,
    sqrt,
    sub,
    transposed_times,
    vector,
    where,
)
from warp_rods.kernels.lanes import load as of_tile
from warp_rods.kernels.layout import Matrices2D, Scalars1D, Vectors2D, real

wp.set_module_options({"enable_backward": False})


@wp.kernel
def find_force(rotation: Matrices2D, force: Vectors2D, load: Load):
    """The load of an external force in space; ``dim = tiles``."""
    tile = wp.tid()
    before = Lanes()
    for node in range(force.shape[1]):
        here = transposed_times(of_tile(rotation, tile, node), of_tile(force, tile, node))
        load.transverse_force[tile, node] = pair(here[1], here[2])
        if node > 0:
            load.axial_force[tile, node - 1] = real(0.5) * (before + here[0])
        before = here[0]


@wp.func
def contact_drag(tile: int, node: int, rotation: Matrices2D, stiffness: Matrices2D, scale: Lanes):
    """Drag along and across, the blocks of a matrix that is not less than ``scale`` K."""
    R = of_tile(rotation, tile, node)
    D = scale * transposed_times(R, of_tile(stiffness, tile, node) * R)
    size = sqrt(D[1] * D[1] + D[2] * D[2])
    per_size = where(size, real(1.0) / size, Lanes())
    first, second = D[1] * per_size, D[2] * per_size
    across = block(D[4] + first * D[1], D[5] + first * D[2], D[5] + second * D[1], D[8] + second * D[2])
    return D[0] + size, across


@wp.kernel
def add_contact_drag(rotation: Matrices2D, contact: Contact, rate: Scalars1D, load: Load):
    """Add contact as drag, D = 2K/a, and the force D v; ``dim = tiles``."""
    tile = wp.tid()
    scale = Lanes(real(1.0))
    for lane in range(rods_in(tile, rate.shape[0])):
        scale[lane] = real(2.0) / rate[tile * WIDTH + lane]
    along_before, v_before = Lanes(), Lanes()
    for node in range(contact.velocity.shape[1]):
        along, across = contact_drag(tile, node, rotation, contact.stiffness, scale)
        v = contact.velocity[tile, node]
        load.transverse_drag[tile, node] = across
        load.transverse_force[tile, node] += across * pair(v[1], v[2])
        if node > 0:
            drag = real(0.5) * (along_before + along)
            load.axial_drag[tile, node - 1] = drag
            load.axial_force[tile, node - 1] += drag * v_before
        along_before = along
        v_before = v[0]


@wp.func
def step_velocity(tile: int, contact: Contact, balance: Balance, scale: Lanes):
    """v at the end of the step; scale: a Δt."""
    for node in range(contact.velocity.shape[1]):
        v = contact.velocity[tile, node]
        u = vector(balance.axial_velocity[tile, node], balance.transverse_velocity[tile, node])
        contact.velocity_tried[tile, node] = v + (u - v) / scale


@wp.func
def contact_errors(tile: int, rods: Swimmers, contact: Contact, balance: Balance):
    """Errors of a step in places, over its length.

    What D (u − v)/2 would move the nodes on the average, against drag and D. Half of D stands for the other node of a
    pair. Where that moves alike, or is a wall, this half is in error.
    """
    total = Lanes()
    nodes = contact.velocity.shape[1]
    for node in range(nodes):
        v = contact.velocity[tile, node]
        drag = balance.load.axial_drag[tile, node]
        along = drag * (balance.axial_velocity[tile, node] - v[0]) / (real(1.0) + drag)
        lag = balance.transverse_velocity[tile, node] - pair(v[1], v[2])
        D = balance.load.transverse_drag[tile, node]
        across = D * lag / (rods.drag_ratio[tile] + D[0] + D[3])
        total += sqrt(along * along + dot(across, across))
    return real(0.5) * total / real(nodes)


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

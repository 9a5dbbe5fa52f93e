"""External forces and contact on active rods, in their Bishop frame (docs/model.md §2.4, ``contact_drag.py``).

With the velocity v = Σ d_j r_j that belongs to r*, the formula of a step is u = a (r − r*) + v, so that what holds a
node back from leaving r** = r* + θ (r − r*)ⁿ is a drag::

    F(r*) − D (u − v**),     v** = v + a θ (r − r*)ⁿ,     v ← v + (u − v)/(a Δt)

v and r − r* are carried from step to step as the rod's own velocities give them; from places in space they would
differ from u by terms of second order in Δs. Drag along and drag across are kept apart: K is replaced by the
block-diagonal matrix (K00 + |K0⊥|, K⊥⊥ + K⊥0 K0⊥/|K0⊥|), which is not less than K and vanishes where K does, so that
rods slide freely.
"""

import warp as wp

from warp_rods.kernels.contact_drag import (
    Alternating,
    alternating,
    drag_for,
    drag_in_plane,
    principal,
    share_foretold,
)
from warp_rods.kernels.free.state import Balance, Contact, Load, Swimmers, Trial
from warp_rods.kernels.layout import Matrices2D, Scalars1D, Vectors2D, real
from warp_rods.kernels.multistep import Pace, formula_of, times_of
from warp_rods.kernels.status import OK

wp.set_module_options({"enable_backward": False})


@wp.func
def body_force(rod: int, node: int, rotation: Matrices2D, force: Vectors2D):
    """Components in the Bishop frame of a force in space."""
    return wp.transpose(rotation[rod, node]) * force[rod, node]


@wp.func
def stiffness_blocks(rod: int, node: int, rotation: Matrices2D, stiffness: Matrices2D):
    """Stiffness along and across (K11, K12, K22), the blocks of a matrix that is not less than K."""
    R = rotation[rod, node]
    K = wp.transpose(R) * stiffness[rod, node] * R
    coupling = wp.vec2d(K[0, 1], K[0, 2])
    size = wp.length(coupling)
    across = wp.vec3d(K[1, 1], K[1, 2], K[2, 2])
    if size > real(0.0):
        across += wp.vec3d(coupling[0] * coupling[0], coupling[0] * coupling[1], coupling[1] * coupling[1]) / size
    return K[0, 0] + size, across


@wp.func
def node_drag(along: real, across: wp.vec3d, ratio: real, terms: Alternating):
    """Drag along, drag across, and θ of a node; the own drag is 1 along and ``ratio`` across."""
    kappa = principal(across)
    stiffest = wp.max(real(2.0) * along, (kappa[0] + kappa[1]) / ratio)
    share = share_foretold(stiffest, real(1.0), terms)
    return drag_for(real(2.0) * along, real(1.0), share, terms), drag_in_plane(across, ratio, share, terms), share


@wp.kernel
def find_force(rotation: Matrices2D, force: Vectors2D, load: Load):
    """The load of an external force in space; ``dim = (rods, nodes)``."""
    rod, node = wp.tid()
    here = body_force(rod, node, rotation, force)
    load.transverse_force[rod, node] = wp.vec2d(here[1], here[2])
    if node < force.shape[1] - 1:
        load.axial_force[rod, node] = real(0.5) * (here[0] + body_force(rod, node + 1, rotation, force)[0])


@wp.kernel
def add_contact_drag(rods: Swimmers, rotation: Matrices2D, pace: Pace, trial: Trial, contact: Contact, load: Load):
    """Add contact as the drag D and the force D v**; ``dim = rods``."""
    rod = wp.tid()
    if rods.status[rod] != OK:
        return
    at = times_of(pace, rod)
    terms = alternating(at, pace.levels[rod], formula_of(at, trial.order[rod], trial.end[rod]), trial.end[rod])
    ratio = rods.drag_ratio[rod]
    nodes = contact.velocity.shape[1]
    along_before, share_before = real(0.0), real(0.0)
    for node in range(nodes):
        K_along, K_across = stiffness_blocks(rod, node, rotation, contact.stiffness)
        along, across, share = node_drag(K_along, K_across, ratio, terms)
        beyond = terms.rate * terms.ratio
        v = contact.velocity[rod, node] + beyond * share * contact.lag[rod, node]
        D = wp.mat22d(across[0], across[1], across[1], across[2])
        load.transverse_drag[rod, node] = D
        load.transverse_force[rod, node] = load.transverse_force[rod, node] + D * wp.vec2d(v[1], v[2])
        contact.foretold[rod, node] = v
        if node > 0:
            half = node - 1
            drag = real(0.5) * (along_before + along)
            v0 = contact.velocity[rod, half][0]
            v0 += beyond * real(0.5) * (share_before + share) * contact.lag[rod, half][0]
            load.axial_drag[rod, half] = drag
            load.axial_force[rod, half] = load.axial_force[rod, half] + drag * v0
            before = contact.foretold[rod, half]
            contact.foretold[rod, half] = wp.vec3d(v0, before[1], before[2])
        along_before = along
        share_before = share


@wp.func
def step_velocity(rod: int, contact: Contact, balance: Balance, rate: real, dt: real):
    """v and r − r* at the end of the step; rate: a."""
    for node in range(contact.velocity.shape[1]):
        v = contact.velocity[rod, node]
        across = balance.transverse_velocity[rod, node]
        lag = (wp.vec3d(balance.axial_velocity[rod, node], across[0], across[1]) - v) / rate
        contact.lag_tried[rod, node] = lag
        contact.velocity_tried[rod, node] = v + lag / dt


@wp.func
def keep_velocity(rod: int, contact: Contact):
    """Take v and r − r* of the step tried as those of the last step."""
    for node in range(contact.velocity.shape[1]):
        contact.velocity[rod, node] = contact.velocity_tried[rod, node]
        contact.lag[rod, node] = contact.lag_tried[rod, node]


@wp.func
def contact_error(rod: int, rods: Swimmers, contact: Contact, balance: Balance, dt: real):
    """Error of a step in places: what D (u − v**) would move the nodes on the average, against drag and D."""
    total = real(0.0)
    nodes = contact.velocity.shape[1]
    for node in range(nodes):
        v = contact.foretold[rod, node]
        drag = balance.load.axial_drag[rod, node]
        along = drag * (balance.axial_velocity[rod, node] - v[0]) / (real(1.0) + drag)
        D = balance.load.transverse_drag[rod, node]
        across = D * (balance.transverse_velocity[rod, node] - wp.vec2d(v[1], v[2]))
        across /= rods.drag_ratio[rod] + wp.trace(D)
        total += wp.sqrt(along * along + wp.dot(across, across))
    return dt * total / real(nodes)


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

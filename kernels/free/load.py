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
from warp_rods.kernels.free.formulas import formulas_of
from warp_rods.kernels.free.state import Balance, Contact, Load, Swimmers, Trial
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Lanes,
    Vector,
    add,
    block,
    div,
    dot,
    larger,
    mul,
    pair,
    sqrt,
    sub,
    transposed_times,
    vector,
    where,
)
from warp_rods.kernels.lanes import load as of_tile
from warp_rods.kernels.layout import Matrices2D, Scalars1D, Vectors2D, real
from warp_rods.kernels.multistep import Pace

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
def stiffness_blocks(tile: int, node: int, rotation: Matrices2D, stiffness: Matrices2D):
    """Stiffness along and across (K11, K12, K22), the blocks of a matrix that is not less than K."""
    R = of_tile(rotation, tile, node)
    K = transposed_times(R, of_tile(stiffness, tile, node) * R)
    size = sqrt(K[1] * K[1] + K[2] * K[2])
    per_size = where(size, real(1.0) / size, Lanes())
    first, second = K[1] * per_size, K[2] * per_size
    return K[0] + size, vector(K[4] + first * K[1], K[5] + first * K[2], K[8] + second * K[2])


@wp.func
def node_drag(along: Lanes, across: Vector, own_along: Lanes, own_across: Lanes, terms: Alternating):
    """Drag along, drag across, and θ of a node, from the stiffness of contact and the own drags of the rod."""
    one, two = Lanes(real(1.0)), real(2.0)
    kappa = principal(across)
    share = share_foretold(larger(two * along / own_along, (kappa[0] + kappa[1]) / own_across), one, terms)
    return drag_for(two * along, own_along, share, terms), drag_in_plane(across, own_across, share, terms), share


@wp.kernel
def add_contact_drag(rods: Swimmers, rotation: Matrices2D, pace: Pace, trial: Trial, contact: Contact, load: Load):
    """Add contact as the drag D and the force D v**; ``dim = tiles``."""
    tile = wp.tid()
    formulas = formulas_of(tile, pace, trial)
    terms = alternating(tile, pace, trial.order, trial.end, formulas.value, formulas.slope, formulas.rate)
    beyond = terms.rate * terms.ratio
    half = real(0.5)
    along_before, share_before = Lanes(), Lanes()
    for node in range(contact.velocity.shape[1]):
        K_along, K_across = stiffness_blocks(tile, node, rotation, contact.stiffness)
        along, D, share = node_drag(K_along, K_across, rods.drag_along[tile, node], rods.drag_across[tile, node], terms)
        v = contact.velocity[tile, node] + (beyond * share) * contact.lag[tile, node]
        across = block(D[0], D[1], D[1], D[2])
        load.transverse_drag[tile, node] = across
        load.transverse_force[tile, node] += across * pair(v[1], v[2])
        contact.foretold[tile, node] = v
        if node > 0:
            drag = half * (along_before + along)
            v0 = contact.velocity[tile, node - 1][0]
            v0 += beyond * (half * (share_before + share)) * contact.lag[tile, node - 1][0]
            load.axial_drag[tile, node - 1] = drag
            load.axial_force[tile, node - 1] += drag * v0
            before = contact.foretold[tile, node - 1]
            contact.foretold[tile, node - 1] = vector(v0, pair(before[1], before[2]))
        along_before = along
        share_before = share


@wp.func
def step_velocity(tile: int, contact: Contact, balance: Balance, rate: Lanes, dt: Lanes):
    """v and r − r* at the end of the step; rate: a."""
    for node in range(contact.velocity.shape[1]):
        v = contact.velocity[tile, node]
        u = vector(balance.axial_velocity[tile, node], balance.transverse_velocity[tile, node])
        lag = (u - v) / rate
        contact.lag_tried[tile, node] = lag
        contact.velocity_tried[tile, node] = v + lag / dt


@wp.func
def keep_velocity(tile: int, accepted: Lanes, contact: Contact):
    """Take v and r − r* of the step tried as those of the last step, of the rods where ``accepted`` is not zero."""
    for node in range(contact.velocity.shape[1]):
        v, lag = contact.velocity_tried[tile, node], contact.lag_tried[tile, node]
        contact.velocity[tile, node] = where(accepted, v, contact.velocity[tile, node])
        contact.lag[tile, node] = where(accepted, lag, contact.lag[tile, node])


@wp.func
def contact_errors(tile: int, rods: Swimmers, contact: Contact, balance: Balance, dt: Lanes):
    """Errors of a step in places: what D (u − v**) would move the nodes on the average, against drag and D."""
    total = Lanes()
    nodes = contact.velocity.shape[1]
    for node in range(nodes):
        v = contact.foretold[tile, node]
        drag = balance.load.axial_drag[tile, node]
        along = drag * (balance.axial_velocity[tile, node] - v[0]) / (rods.drag_along[tile, node] + drag)
        D = balance.load.transverse_drag[tile, node]
        across = D * (balance.transverse_velocity[tile, node] - pair(v[1], v[2]))
        across = across / (rods.drag_across[tile, node] + D[0] + D[3])
        total += sqrt(along * along + dot(across, across))
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

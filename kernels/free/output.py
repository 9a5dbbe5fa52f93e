"""What is shown of active rods: frames in space, the material's strains, energy and where it goes.

None of it is needed by a step without external forces, so it is made when asked for.
"""

import warp as wp

from warp_rods.kernels.clock import TIME
from warp_rods.kernels.free.rod import activity_drive, balance, bending_rate, roll_at
from warp_rods.kernels.free.state import AppliedForce, Flow, Midpoint, Shape, Swimmers, numbers, pairs, per_rod, vectors
from warp_rods.kernels.layout import real
from warp_rods.kernels.lie import quaternion

wp.set_module_options({"enable_backward": False})

matrices = wp.array2d(dtype=wp.mat33d)


@wp.struct
class Measures:
    """Rates of change [rod, node] and balances [rod] of the present shape."""

    bending_rate: pairs
    twist_rate: numbers
    activity_rate: numbers
    energy_density: numbers
    energy: per_rod  # ½ ∫ b|k|² + c τ² ds
    dissipation: per_rod  # ∫ u0² + η|u⊥|² + ηr ω0² ds
    power: per_rod  # ∫ f u0 + M f ω0 + f_ext·u ds


@wp.func
def rates(rod: int, rods: Swimmers, shape: Shape, flow: Flow, measures: Measures):
    """``dk/dt, dτ/dt, df/dt`` of the semi-discrete equations, from a balanced flow."""
    last = shape.twist.shape[1] - 1
    for node in range(last + 1):
        drive, _sink = activity_drive(rod, node, rods, shape, flow)
        measures.activity_rate[rod, node] = drive / rods.relaxation[rod]
    for node in range(1, last):
        source = real(0.5) * (flow.twist_source[rod, node - 1] + flow.twist_source[rod, node])
        slope = (roll_at(rod, node, rods, shape) - roll_at(rod, node - 1, rods, shape)) / rods.spacing
        measures.twist_rate[rod, node] = slope + source
        measures.bending_rate[rod, node] = bending_rate(rod, node, rods, shape.bending[rod, node], flow)


@wp.func
def energies(rod: int, rods: Swimmers, shape: Shape, flow: Flow, measures: Measures):
    """Energy, dissipation and power: ``dE/dt = power − dissipation`` holds to round-off along ``rates``."""
    half = real(0.5)
    energy, lost, given = real(0.0), real(0.0), real(0.0)
    last = shape.twist.shape[1] - 1
    for node in range(last + 1):
        k = shape.bending[rod, node]
        tau = shape.twist[rod, node]
        u = flow.transverse[rod, node]
        force = flow.force[rod, node]
        weight = real(1.0)
        if node == 0 or node == last:
            weight = half
        density = half * (rods.bending_stiffness[rod] * wp.dot(k, k) + rods.twist_stiffness[rod] * tau * tau)
        measures.energy_density[rod, node] = density
        energy += density
        lost += weight * rods.drag_ratio[rod] * wp.dot(u, u)
        given += weight * (force[1] * u[0] + force[2] * u[1])
    for node in range(last):
        u0 = flow.axial[rod, node]
        roll = roll_at(rod, node, rods, shape)
        f = half * (shape.activity[rod, node] + shape.activity[rod, node + 1])
        external = half * (flow.force[rod, node][0] + flow.force[rod, node + 1][0])
        lost += u0 * u0 + rods.rotational_drag[rod] * roll * roll
        given += (f + external) * u0 + rods.moment[rod] * f * roll
    measures.energy[rod] = rods.spacing * energy
    measures.dissipation[rod] = rods.spacing * lost
    measures.power[rod] = rods.spacing * given


@wp.kernel
def measure(rods: Swimmers, shape: Shape, flow: Flow, measures: Measures):
    """Balance the present shape under ``flow.force``; launch with ``dim = rods``."""
    rod = wp.tid()
    balance(rod, rods, shape, flow)
    rates(rod, rods, shape, flow, measures)
    energies(rod, rods, shape, flow, measures)


@wp.kernel
def lay_out(shape: Shape, midpoint: Midpoint, strain: vectors, rotation: matrices, position: vectors):
    """Strains of the Bishop frame, and the frame that a path product starts from; ``dim = (rods, nodes)``."""
    rod, node = wp.tid()
    k = shape.bending[rod, node]
    strain[rod, node] = wp.vec3d(real(0.0), k[0], k[1])
    if node == shape.twist.shape[1] // 2:
        rotation[rod, node] = midpoint.rotation[rod]
        position[rod, node] = midpoint.position[rod]


@wp.func
def angle_from_midpoint(rod: int, node: int, ds: real, twist: numbers):
    """``∫ τ ds`` from the middle node to ``node``, by the trapezoid rule."""
    middle = twist.shape[1] // 2
    total = real(0.5) * (twist[rod, middle] + twist[rod, node])
    for between in range(wp.min(node, middle) + 1, wp.max(node, middle)):
        total += twist[rod, between]
    if node == middle:
        return real(0.0)
    return total * wp.where(node < middle, -ds, ds)


@wp.kernel
def materialise(
    rods: Swimmers,
    shape: Shape,
    midpoint: Midpoint,
    rotation: matrices,
    strain: vectors,
    orientation: wp.array2d(dtype=wp.quatd),
):
    """Strains and directors of the material, turned by ``θ + ∫τ`` from the Bishop frame; ``dim = (rods, nodes)``."""
    rod, node = wp.tid()
    angle = midpoint.angle[rod] + angle_from_midpoint(rod, node, rods.spacing, shape.twist)
    c = wp.cos(angle)
    s = wp.sin(angle)
    k = shape.bending[rod, node]
    strain[rod, node] = wp.vec3d(shape.twist[rod, node], c * k[0] + s * k[1], c * k[1] - s * k[0])
    zero, one = real(0.0), real(1.0)
    R = rotation[rod, node] * wp.mat33d(one, zero, zero, zero, c, -s, zero, s, c)
    orientation[rod, node] = quaternion(R)


@wp.kernel
def to_body(rotation: matrices, force: vectors, applied: AppliedForce):
    """An external force in space, seen from the Bishop frame; ``dim = (rods, nodes)``."""
    rod, node = wp.tid()
    applied.now[rod, node] = wp.transpose(rotation[rod, node]) * force[rod, node]


def force_field(function):
    """A kernel that evaluates ``function(x, tangent, t)``, a ``wp.func``, at every node; ``dim = (rods, nodes)``."""

    @wp.kernel(module="unique")
    def fill(position: vectors, rotation: matrices, clock: per_rod, force: vectors):
        rod, node = wp.tid()
        R = rotation[rod, node]
        tangent = wp.vec3d(R[0, 0], R[1, 0], R[2, 0])
        force[rod, node] = function(position[rod, node], tangent, clock[TIME])

    return fill

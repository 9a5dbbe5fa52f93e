"""Output of active rods: frames in space, strains of the material frame, rates, energy and powers.

A step without external forces needs none of it, so it is computed when it is read.
"""

import warp as wp

from warp_rods.kernels.cells import advance_cell
from warp_rods.kernels.free.end_power import end_power
from warp_rods.kernels.free.natural import find_rest
from warp_rods.kernels.free.rod import (
    activity_terms,
    bending_moment,
    bending_rate,
    roll_rate_after,
    solve_balance,
    twist_rate,
    twisting_moment,
)
from warp_rods.kernels.free.state import Balance, Midpoint, Shape, Swimmers
from warp_rods.kernels.free.twist import has_twist_rate
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    WIDTH,
    Lanes,
    Lanes1D,
    Lanes2D,
    Pairs,
    add,
    div,
    dot,
    load,
    mul,
    number_of,
    pair_of,
    rods_in,
    store,
    sub,
    vector,
)
from warp_rods.kernels.layout import Matrices2D, Quaternions2D, Scalars1D, Vectors2D, real
from warp_rods.kernels.lie import quaternion

wp.set_module_options({"enable_backward": False})


@wp.struct
class Output:
    """Rates of change [tile, node], energy and powers [tile] of the present shape."""

    bending_rate: Pairs
    twist_rate: Lanes2D
    activity_rate: Lanes2D
    energy_density: Lanes2D
    energy: Lanes1D  # ½ ∫ b|k|² + c τ² ds
    dissipation: Lanes1D  # ∫ u0² + η|u⊥|² + ηr ω0² ds, velocities against the fluid
    power: Lanes1D  # ∫ f u0 + M f ω0 + f_ext·u ds, and that of the flow
    flow_power: Lanes1D  # of the drag at the velocity of the flow


@wp.func
def find_rates(tile: int, rods: Swimmers, shape: Shape, balance: Balance, output: Output):
    """``∂k/∂t, ∂τ/∂t, ∂f/∂t`` discretised in s; those of strains are 0 at ends that are not clamped."""
    last = shape.twist.shape[1] - 1
    before = Lanes()
    for node in range(last + 1):
        rate, _sink = activity_terms(tile, node, rods, shape, balance)
        output.activity_rate[tile, node] = rate / rods.relaxation[tile]
        after = Lanes()
        if node < last:
            after = roll_rate_after(tile, node, rods, shape, balance)
        if has_twist_rate(node, last, rods):
            output.twist_rate[tile, node] = twist_rate(tile, node, rods, before, after, balance)
            output.bending_rate[tile, node] = bending_rate(tile, node, rods, shape.bending[tile, node], balance)
        before = after


@wp.func
def find_energies(tile: int, rods: Swimmers, shape: Shape, balance: Balance, output: Output):
    """Energy, dissipation and power; ``dE/dt = power − dissipation`` holds to round-off for ``find_rates``."""
    half = real(0.5)
    energy, dissipation, power = Lanes(), Lanes(), Lanes()
    last = shape.twist.shape[1] - 1
    for node in range(last + 1):
        m = bending_moment(tile, node, rods, shape.bending, balance)
        m0 = twisting_moment(tile, node, rods, shape.twist)
        u = balance.transverse_velocity[tile, node]
        weight = real(1.0)
        if node == 0 or node == last:
            weight = half
        bent = dot(m, shape.bending[tile, node] - balance.rest[tile, node])
        density = half * (bent + m0 * (shape.twist[tile, node] - rods.natural_twist[tile, node]))
        output.energy_density[tile, node] = density
        energy += weight * density
        dissipation += weight * rods.drag_across[tile, node] * dot(u, u)
        power += weight * dot(balance.load.transverse_force[tile, node], u)
    for node in range(last):
        u0 = balance.axial_velocity[tile, node]
        roll_rate = roll_rate_after(tile, node, rods, shape, balance)
        f = half * (shape.activity[tile, node] + shape.activity[tile, node + 1])
        dissipation += rods.drag_along[tile, node] * u0 * u0
        dissipation += roll_rate * roll_rate / rods.rotational_mobility[tile, node]
        power += (f + balance.load.axial_force[tile, node]) * u0
        power += (rods.moment[tile] * f + balance.load.axial_couple[tile, node]) * roll_rate
        power += dot(balance.load.transverse_couple[tile, node], balance.angular_velocity[tile, node])
    output.energy[tile] = rods.spacing * energy
    output.dissipation[tile] = rods.spacing * dissipation
    output.power[tile] = rods.spacing * power + end_power(tile, rods, shape, balance)
    if rods.flowing == 1:
        add_flow_powers(tile, rods, shape, balance, output)


@wp.func
def add_flow_powers(tile: int, rods: Swimmers, shape: Shape, balance: Balance, output: Output):
    """Drag is ζ (u − w) in a flow w: dissipation is ζ|u − w|², and the flow does the work ζ (w − u)·w.

    Forces contain ζw: what they add to the power, ζw·u, is taken off again.
    """
    surplus, given = Lanes(), Lanes()
    last = shape.twist.shape[1] - 1
    for node in range(last + 1):
        w, u = balance.load.transverse_stream[tile, node], balance.transverse_velocity[tile, node]
        weight = real(1.0)
        if node == 0 or node == last:
            weight = real(0.5)
        drag = weight * rods.drag_across[tile, node]
        surplus += drag * dot(w, w - real(2.0) * u)
        given += drag * dot(w, w - u)
    for node in range(last):
        w0, u0 = balance.load.axial_stream[tile, node], balance.axial_velocity[tile, node]
        roll, roll_rate = balance.load.stream_roll[tile, node], roll_rate_after(tile, node, rods, shape, balance)
        along, about = rods.drag_along[tile, node] * w0, roll / rods.rotational_mobility[tile, node]
        surplus += along * (w0 - real(2.0) * u0) + about * (roll - real(2.0) * roll_rate)
        given += along * (w0 - u0) + about * (roll - roll_rate)
    output.dissipation[tile] += rods.spacing * surplus
    output.power[tile] += rods.spacing * surplus
    output.flow_power[tile] = rods.spacing * given


@wp.kernel
def find_output(rods: Swimmers, shape: Shape, angle: Scalars1D, balance: Balance, output: Output):
    """Solve the balance of the present shape under ``balance.load``, then find ``output``; ``dim = tiles``."""
    tile = wp.tid()
    if rods.bent == 1:
        find_rest(tile, rods, shape, angle, balance)
    solve_balance(tile, rods, shape, balance)
    find_rates(tile, rods, shape, balance, output)
    find_energies(tile, rods, shape, balance, output)


@wp.func
def mean_strain(tile: int, node: int, shape: Shape):
    """The mean strain of the Bishop frame between a node and the next."""
    return vector(Lanes(), real(0.5) * (shape.bending[tile, node] + shape.bending[tile, node + 1]))


@wp.kernel
def lay_out(rods: Swimmers, shape: Shape, middle: Midpoint, rotation: Matrices2D, position: Vectors2D):
    """Frames of all nodes from those of the tracked one outwards (2.48), (D.77); ``dim = tiles``."""
    tile = wp.tid()
    node = rods.tracked
    ds = Lanes(rods.spacing)
    for lane in range(rods_in(tile, rotation.shape[0])):
        rod = tile * WIDTH + lane
        rotation[rod, node] = middle.rotation[rod]
        position[rod, node] = middle.position[rod]
    R = load(rotation, tile, node)
    r = load(position, tile, node)
    for i in range(node, shape.twist.shape[1] - 1):
        R, r = advance_cell(R, r, mean_strain(tile, i, shape), ds)
        store(rotation, tile, i + 1, R)
        store(position, tile, i + 1, r)
    R = load(rotation, tile, node)
    r = load(position, tile, node)
    for back in range(node):
        i = node - 1 - back
        R, r = advance_cell(R, r, mean_strain(tile, i, shape), -ds)
        store(rotation, tile, i, R)
        store(position, tile, i, r)


@wp.func
def angle_from(rod: int, start: int, node: int, ds: real, twist: Lanes2D):
    """``∫ τ ds`` from the node ``start`` to ``node``, by the trapezoid rule."""
    total = real(0.5) * (number_of(twist, rod, start) + number_of(twist, rod, node))
    for between in range(wp.min(node, start) + 1, wp.max(node, start)):
        total += number_of(twist, rod, between)
    if node == start:
        return real(0.0)
    return total * wp.where(node < start, -ds, ds)


@wp.func
def material(R: wp.mat33d, angle: real):
    """The Bishop frame R turned to the material one."""
    c, s, zero, one = wp.cos(angle), wp.sin(angle), real(0.0), real(1.0)
    return R * wp.mat33d(one, zero, zero, zero, c, -s, zero, s, c)


@wp.kernel
def find_material_frame(
    rods: Swimmers,
    shape: Shape,
    midpoint: Midpoint,
    rotation: Matrices2D,
    strain: Vectors2D,
    orientation: Quaternions2D,
):
    """Strains and directors of the material frame, the Bishop frame turned by ``θ + ∫τ``; ``dim = (rods, nodes)``."""
    rod, node = wp.tid()
    angle = midpoint.angle[rod] + angle_from(rod, rods.tracked, node, rods.spacing, shape.twist)
    c = wp.cos(angle)
    s = wp.sin(angle)
    k = pair_of(shape.bending, rod, node)
    strain[rod, node] = wp.vec3d(number_of(shape.twist, rod, node), c * k[0] + s * k[1], c * k[1] - s * k[0])
    orientation[rod, node] = quaternion(material(rotation[rod, node], angle))

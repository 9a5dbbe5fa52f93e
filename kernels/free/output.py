"""Output of active rods: frames in space, strains of the material frame, rates, energy and powers.

A step without external forces needs none of it, so it is computed when it is read.
"""

import warp as wp

from warp_rods.kernels.free.rod import activity_terms, bending_rate, roll_rate_after, solve_balance
from warp_rods.kernels.free.state import Balance, Midpoint, Shape, Swimmers
from warp_rods.kernels.layout import Matrices2D, Pairs2D, Quaternions2D, Scalars1D, Scalars2D, Vectors2D, real
from warp_rods.kernels.lie import quaternion

wp.set_module_options({"enable_backward": False})


@wp.struct
class Output:
    """Rates of change [rod, node], energy and powers [rod] of the present shape."""

    bending_rate: Pairs2D
    twist_rate: Scalars2D
    activity_rate: Scalars2D
    energy_density: Scalars2D
    energy: Scalars1D  # ½ ∫ b|k|² + c τ² ds
    dissipation: Scalars1D  # ∫ u0² + η|u⊥|² + ηr ω0² ds
    power: Scalars1D  # ∫ f u0 + M f ω0 + f_ext·u ds


@wp.func
def find_rates(rod: int, rods: Swimmers, shape: Shape, balance: Balance, output: Output):
    """``∂k/∂t, ∂τ/∂t, ∂f/∂t`` of the equations discretised in s, from a solved balance."""
    last = shape.twist.shape[1] - 1
    for node in range(last + 1):
        rate, _sink = activity_terms(rod, node, rods, shape, balance)
        output.activity_rate[rod, node] = rate / rods.relaxation[rod]
    for node in range(1, last):
        source = real(0.5) * (balance.twist_source[rod, node - 1] + balance.twist_source[rod, node])
        slope = (roll_rate_after(rod, node, rods, shape) - roll_rate_after(rod, node - 1, rods, shape)) / rods.spacing
        output.twist_rate[rod, node] = slope + source
        output.bending_rate[rod, node] = bending_rate(rod, node, rods, shape.bending[rod, node], balance)


@wp.func
def find_energies(rod: int, rods: Swimmers, shape: Shape, balance: Balance, output: Output):
    """Energy, dissipation and power; ``dE/dt = power − dissipation`` holds to round-off for ``find_rates``."""
    half = real(0.5)
    energy, dissipation, power = real(0.0), real(0.0), real(0.0)
    last = shape.twist.shape[1] - 1
    for node in range(last + 1):
        k = shape.bending[rod, node]
        tau = shape.twist[rod, node]
        u = balance.transverse_velocity[rod, node]
        weight = real(1.0)
        if node == 0 or node == last:
            weight = half
        density = half * (rods.bending_stiffness[rod] * wp.dot(k, k) + rods.twist_stiffness[rod] * tau * tau)
        output.energy_density[rod, node] = density
        energy += density
        dissipation += weight * rods.drag_ratio[rod] * wp.dot(u, u)
        power += weight * wp.dot(balance.load.transverse_force[rod, node], u)
    for node in range(last):
        u0 = balance.axial_velocity[rod, node]
        roll_rate = roll_rate_after(rod, node, rods, shape)
        f = half * (shape.activity[rod, node] + shape.activity[rod, node + 1])
        dissipation += u0 * u0 + rods.rotational_drag[rod] * roll_rate * roll_rate
        power += (f + balance.load.axial_force[rod, node]) * u0 + rods.moment[rod] * f * roll_rate
    output.energy[rod] = rods.spacing * energy
    output.dissipation[rod] = rods.spacing * dissipation
    output.power[rod] = rods.spacing * power


@wp.kernel
def find_output(rods: Swimmers, shape: Shape, balance: Balance, output: Output):
    """Solve the balance of the present shape under ``balance.load``, then find ``output``; ``dim = rods``."""
    rod = wp.tid()
    solve_balance(rod, rods, shape, balance)
    find_rates(rod, rods, shape, balance, output)
    find_energies(rod, rods, shape, balance, output)


@wp.kernel
def set_bishop_strain(shape: Shape, midpoint: Midpoint, strain: Vectors2D, rotation: Matrices2D, position: Vectors2D):
    """Strains of the Bishop frame, and the middle frame from which frames are integrated; ``dim = (rods, nodes)``."""
    rod, node = wp.tid()
    k = shape.bending[rod, node]
    strain[rod, node] = wp.vec3d(real(0.0), k[0], k[1])
    if node == shape.twist.shape[1] // 2:
        rotation[rod, node] = midpoint.rotation[rod]
        position[rod, node] = midpoint.position[rod]


@wp.func
def angle_from_midpoint(rod: int, node: int, ds: real, twist: Scalars2D):
    """``∫ τ ds`` from the middle node to ``node``, by the trapezoid rule."""
    middle = twist.shape[1] // 2
    total = real(0.5) * (twist[rod, middle] + twist[rod, node])
    for between in range(wp.min(node, middle) + 1, wp.max(node, middle)):
        total += twist[rod, between]
    if node == middle:
        return real(0.0)
    return total * wp.where(node < middle, -ds, ds)


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
    angle = midpoint.angle[rod] + angle_from_midpoint(rod, node, rods.spacing, shape.twist)
    c = wp.cos(angle)
    s = wp.sin(angle)
    k = shape.bending[rod, node]
    strain[rod, node] = wp.vec3d(shape.twist[rod, node], c * k[0] + s * k[1], c * k[1] - s * k[0])
    zero, one = real(0.0), real(1.0)
    R = rotation[rod, node] * wp.mat33d(one, zero, zero, zero, c, -s, zero, s, c)
    orientation[rod, node] = quaternion(R)

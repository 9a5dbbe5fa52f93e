"""What enters free rods through their ends: the power of loads on free ends, and of what moves held ones."""

import warp as wp

from warp_rods.kernels.free.rod import bending_moment, roll_rate_after, roll_rate_at_end, twisting_moment
from warp_rods.kernels.free.state import CLAMPED, FREE, Balance, End, Shape, Swimmers
from warp_rods.kernels.lanes import Lanes, add, dot, mul, pair, sub, times_i, wedge  # noqa: F401 (operators)
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.func
def shear_after(tile: int, node: int, rods: Swimmers, shape: Shape, balance: Balance):
    """``Λ⊥ = i (m⊥' + µ⊥) + m0 k`` at the half node after ``node``."""
    here = bending_moment(tile, node, rods, shape.bending, balance)
    there = bending_moment(tile, node + 1, rods, shape.bending, balance)
    m0 = twisting_moment(tile, node, rods, shape.twist) + twisting_moment(tile, node + 1, rods, shape.twist)
    slope = (real(1.0) / rods.spacing) * (there - here) + balance.load.transverse_couple[tile, node]
    return times_i(slope) + (real(0.25) * m0) * (shape.bending[tile, node] + shape.bending[tile, node + 1])


@wp.func
def end_power(tile: int, rods: Swimmers, shape: Shape, balance: Balance):
    """Σ F·u + C·ω of both ends, with the forces and couples that hold or load them."""
    last = shape.twist.shape[1] - 1
    at_last = power_at(tile, rods.last, last, last - 1, real(1.0), rods, shape, balance)
    return at_last + power_at(tile, rods.first, 0, 0, real(-1.0), rods, shape, balance)


@wp.func
def power_at(
    tile: int, end: End, node: int, half_node: int, side: real, rods: Swimmers, shape: Shape, balance: Balance
):
    """The power of one end; side: 1 at the last one, −1 at the first."""
    w, F = end.angular_velocity[tile], end.force[tile]
    omega, roll_rate = pair(w[1], w[2]), real(1.0) * w[0]
    if end.kind != CLAMPED:
        omega = balance.angular_velocity[tile, half_node]
        roll_rate = roll_rate_at_end(tile, half_node, side, rods, shape, balance)
    turning = dot(bending_moment(tile, node, rods, shape.bending, balance), omega)
    turning += twisting_moment(tile, node, rods, shape.twist) * roll_rate
    half_cell = Lanes()
    if end.kind == CLAMPED and rods.bent == 1:  # the clamp turns the material of the half cell, too
        slip = roll_rate_after(tile, half_node, rods, shape, balance) - w[0]
        drawn = wedge(shape.bending[tile, node], bending_moment(tile, node, rods, shape.bending, balance))
        half_cell = (real(0.5) * rods.spacing) * (drawn * slip)
    along = balance.tension[tile, node] * balance.axial_velocity[tile, half_node]
    u = balance.transverse_velocity[tile, node]
    pull = balance.tension[tile, node] * wedge(shape.bending[tile, node], u)  # u0' = −Im(k̄ u⊥) up to the end
    across = side * dot(pair(F[1], F[2]), u) - (side * real(0.5) * rods.spacing) * pull
    if end.kind != FREE:
        across = dot(shear_after(tile, half_node, rods, shape, balance), u)
        drag = rods.drag_across[tile, node] * u - balance.load.transverse_force[tile, node]
        across += (side * real(0.5) * rods.spacing) * dot(drag, u)
    return side * (turning + along + across) + half_cell

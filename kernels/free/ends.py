"""Ends of free rods: what holds them, and what loads them (docs/model.md §2.11).

Conditions are on velocities: a held end has a given ``u``, a clamped one a given ``ω``, too. As its mobility is then
zero, terms that hold it do not enter the linear systems. The tension of a held end is what lets ``u0`` take its value
in the half cell there, and a clamped end has strains of its own, in a cell of half the length, so that the energy law
holds to round-off. Loads on ends that are not held give ``λ``, ``m⊥`` and ``m0`` there.
"""

import warp as wp

from warp_rods.kernels.free.state import FREE, Balance, Shape, Swimmers
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Block,
    Lanes,
    add,
    div,
    mul,
    pair,
    sub,
    wedge,
)
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.func
def hold_mobilities(tile: int, rods: Swimmers, balance: Balance):
    """No force moves a held end across."""
    if rods.first.kind != FREE:
        balance.transverse_mobility[tile, 0] = Block()
    if rods.last.kind != FREE:
        balance.transverse_mobility[tile, balance.tension.shape[1] - 1] = Block()


@wp.func
def hold_across(tile: int, rods: Swimmers, balance: Balance):
    """The velocity across of held ends, and the forces on others, which act on a cell of half the length."""
    last = balance.tension.shape[1] - 1
    per_cell = real(2.0) / rods.spacing
    first_u, first_F = rods.first.velocity[tile], per_cell * rods.first.force[tile]
    last_u, last_F = rods.last.velocity[tile], per_cell * rods.last.force[tile]
    balance.transverse_source[tile, 0] += balance.transverse_mobility[tile, 0] * pair(first_F[1], first_F[2])
    balance.transverse_source[tile, last] += balance.transverse_mobility[tile, last] * pair(last_F[1], last_F[2])
    if rods.first.kind != FREE:
        balance.transverse_source[tile, 0] = pair(first_u[1], first_u[2])
    if rods.last.kind != FREE:
        balance.transverse_source[tile, last] = pair(last_u[1], last_u[2])


@wp.func
def set_end_tensions(tile: int, rods: Swimmers, shape: Shape, balance: Balance):
    """End rows of the tension: the force along of free ends, or ``(u0 − u0 of the end)/(Δs/2) + Im(k̄ u⊥) = 0``."""
    last = shape.twist.shape[1] - 1
    per_length, half = real(1.0) / rods.spacing, real(0.5)
    zero, one = Lanes(), Lanes(real(1.0))
    balance.upper[tile, 0] = zero
    balance.diagonal[tile, 0] = one
    balance.rhs[tile, 0] = real(-1.0) * rods.first.force[tile][0]
    if rods.first.kind != FREE:
        u = rods.first.velocity[tile]
        ease = per_length * per_length * balance.axial_mobility[tile, 0]
        balance.diagonal[tile, 0] = ease
        balance.upper[tile, 0] = -ease
        turning = half * wedge(shape.bending[tile, 0], pair(u[1], u[2]))
        balance.rhs[tile, 0] = per_length * (balance.axial_source[tile, 0] - u[0]) + turning
    balance.lower[tile, last] = zero
    balance.diagonal[tile, last] = one
    balance.rhs[tile, last] = rods.last.force[tile][0]
    if rods.last.kind != FREE:
        u = rods.last.velocity[tile]
        ease = per_length * per_length * balance.axial_mobility[tile, last - 1]
        balance.diagonal[tile, last] = ease
        balance.lower[tile, last] = -ease
        turning = half * wedge(shape.bending[tile, last], pair(u[1], u[2]))
        balance.rhs[tile, last] = per_length * (u[0] - balance.axial_source[tile, last - 1]) + turning


@wp.func
def first_bending(tile: int, rods: Swimmers, balance: Balance):
    """k of the first end if it is not clamped: there the moment is minus the couple on it."""
    C = rods.first.couple[tile]
    return balance.rest[tile, 0] - pair(C[1], C[2]) / rods.bending_stiffness[tile, 0]


@wp.func
def last_bending(tile: int, rods: Swimmers, balance: Balance):
    """k of the last end if it is not clamped: there the moment is the couple on it."""
    last = balance.tension.shape[1] - 1
    C = rods.last.couple[tile]
    return balance.rest[tile, last] + pair(C[1], C[2]) / rods.bending_stiffness[tile, last]


@wp.func
def first_twist(tile: int, rods: Swimmers):
    """τ of the first end if it is not clamped."""
    return rods.natural_twist[tile, 0] - rods.first.couple[tile][0] / rods.twist_stiffness[tile, 0]


@wp.func
def last_twist(tile: int, rods: Swimmers):
    """τ of the last end if it is not clamped."""
    last = rods.natural_twist.shape[1] - 1
    return rods.natural_twist[tile, last] + rods.last.couple[tile][0] / rods.twist_stiffness[tile, last]

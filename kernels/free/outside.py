"""A flow, and forces and couples per length from outside, on active rods in their Bishop frame (docs/model.md §2.12).

Drag acts on the velocity against the fluid, so that a flow u∞ is a force ζ u∞ and a couple ζr ½∇×u∞ about the tangent.
Free rods are described in axes that are carried with u∞ of the tracked node, without turning (``motion.py``).
"""

import warp as wp

from warp_rods.kernels.free.state import FREE, Load, Swimmers
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Lanes,
    Lanes2D,
    Pairs,
    Vector,
    add,
    div,
    mul,
    pair,
    sub,
    transposed_times,
)
from warp_rods.kernels.lanes import load as of_tile
from warp_rods.kernels.layout import Matrices2D, real
from warp_rods.kernels.outside import Outside

wp.set_module_options({"enable_backward": False})


@wp.func
def carrying(tile: int, rods: Swimmers, outside: Outside):
    """u∞ at the tracked node, with which free rods are carried; zero for rods that are held."""
    carried = Vector()
    if rods.first.kind == FREE and rods.last.kind == FREE:
        carried = of_tile(outside.velocity, tile, rods.tracked)
    return carried


@wp.kernel
def add_flow(rods: Swimmers, rotation: Matrices2D, outside: Outside, load: Load):
    """Add the drag of a flow, a force ζ u∞ and a couple ζr ½∇×u∞ about the tangent; ``dim = tiles``.

    u∞ is relative to that at the tracked node, so that a uniform flow is exactly zero.
    """
    tile = wp.tid()
    half = real(0.5)
    carried = carrying(tile, rods, outside)
    before, spin_before = Lanes(), Lanes()
    for node in range(rotation.shape[1]):
        R = of_tile(rotation, tile, node)
        u = transposed_times(R, of_tile(outside.velocity, tile, node) - carried)
        spin = transposed_times(R, of_tile(outside.spin, tile, node))[0]
        across = pair(u[1], u[2])
        load.transverse_stream[tile, node] = across
        load.transverse_force[tile, node] += rods.drag_across[tile, node] * across
        if node > 0:
            along, roll = half * (before + u[0]), half * (spin_before + spin)
            load.axial_stream[tile, node - 1] = along
            load.stream_roll[tile, node - 1] = roll
            load.axial_force[tile, node - 1] += rods.drag_along[tile, node - 1] * along
            load.axial_couple[tile, node - 1] += roll / rods.rotational_mobility[tile, node - 1]
        before = u[0]
        spin_before = spin


@wp.kernel
def add_outside(rotation: Matrices2D, outside: Outside, load: Load):
    """Add force and couple per length in space; ``dim = tiles``."""
    tile = wp.tid()
    half = real(0.5)
    F_before, C_before = Vector(), Vector()
    for node in range(rotation.shape[1]):
        R = of_tile(rotation, tile, node)
        F = transposed_times(R, of_tile(outside.force, tile, node))
        load.transverse_force[tile, node] += pair(F[1], F[2])
        if node > 0:
            load.axial_force[tile, node - 1] += half * (F_before[0] + F[0])
        F_before = F
        if outside.turning == 1:
            C = transposed_times(R, of_tile(outside.couple, tile, node))
            if node > 0:
                across = pair(C_before[1] + C[1], C_before[2] + C[2])
                load.axial_couple[tile, node - 1] += half * (C_before[0] + C[0])
                load.transverse_couple[tile, node - 1] += half * across
            C_before = C


@wp.kernel
def set_couple(couple: Lanes2D, across: Pairs, outside: Outside, load: Load):
    """Begin with the rods' own couples about and across the tangent; ``dim = tiles``."""
    tile = wp.tid()
    for node in range(couple.shape[1]):
        load.axial_couple[tile, node] = real(1.0) * couple[tile, node]
        if outside.turning == 1:
            load.transverse_couple[tile, node] = real(1.0) * across[tile, node]

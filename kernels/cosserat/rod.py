"""Strains, forces and drag of extensible and shearable rods (docs/model.md §10.2)."""

import warp as wp

from warp_rods.kernels.cosserat.blocks import times
from warp_rods.kernels.cosserat.state import Frames, Rods
from warp_rods.kernels.lanes import Lanes, Screw, Square, div, dot, load, mul, rows, transposed_times  # noqa: F401 (operators)
from warp_rods.kernels.layout import real
from warp_rods.kernels.screws import (
    angular,
    change_of_angle,
    change_of_place,
    inverse_coefficients,
    linear,
    minus,
    scaled,
    screw,
    screw_between,
)

wp.set_module_options({"enable_backward": False})


@wp.func
def screw_after(tile: int, node: int, frames: Frames) -> Screw:
    """X from a node to the next."""
    return screw_between(
        frames.rotation[tile, node],
        frames.position[tile, node],
        frames.rotation[tile, node + 1],
        frames.position[tile, node + 1],
    )


@wp.func
def stress_of(tile: int, node: int, rods: Rods, X: Screw) -> Screw:
    """K (X/Δs − ξ0)."""
    strain = scaled(Lanes(real(1.0) / rods.spacing), X)
    return times(rods.stiffness[tile], minus(strain, rods.natural[tile, node]))


@wp.func
def changes_of(X: Screw):
    """A and C of X."""
    theta, mu = angular(X), linear(X)
    gamma = inverse_coefficients(dot(theta, theta))
    return change_of_angle(theta, gamma), change_of_place(theta, mu, gamma)


@wp.func_native(
    rows("Screw", "ab", "R[0] = B[0]; R[1] = (V)(0.0); R[2] = (V)(0.0); R[3] = (V)(1.0); R[4] = A[0]; R[5] = A[0];")
)
def diagonal_drag(a: Lanes, b: Lanes) -> Screw:
    """(ηr, 0, 0, 1, η, η)."""


@wp.func_native(rows("Screw", "a", "for (int i = 0; i < 6; ++i) R[i] = (V)(1e30); R[1] = A[0]; R[2] = A[0];"))
def drag_at_once(a: Lanes) -> Screw:
    """a ζ of a step that is so short that nothing with drag moves, with the drag ``a`` for ω across."""


@wp.func_native(
    rows("Lanes", "a", "R[0] = A[0]; for (int i = 1; i < 6; ++i) R[0] = R[0] < A[7 * i] ? A[7 * i] : R[0];")
)
def stiffest(a: Square) -> Lanes:
    """The largest stiffness on the diagonal."""


@wp.func
def drag_of(tile: int, rods: Rods) -> Screw:
    """ζ of (ω, u)."""
    return diagonal_drag(rods.drag_ratio[tile], rods.rotational_drag[tile])


@wp.func_native(rows("Screw", "ab", "for (int i = 0; i < 6; ++i) R[i] = A[i] * B[i];"))
def by_component(a: Screw, b: Screw) -> Screw:
    """The products of the components."""


@wp.func
def load_at(tile: int, node: int, rods: Rods, frames: Frames) -> Screw:
    """(couple, force) per length in the frame of a node."""
    R = frames.rotation[tile, node]
    return screw(transposed_times(R, load(rods.couple, tile, node)), transposed_times(R, load(rods.force, tile, node)))


@wp.func
def length_at(node: int, last: int, rods: Rods) -> Lanes:
    """The length that a node stands for: Δs, and half of it at the ends."""
    if node == 0 or node == last:
        return Lanes(real(0.5) * rods.spacing)
    return Lanes(rods.spacing)

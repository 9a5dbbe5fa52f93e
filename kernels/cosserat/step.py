"""One time step of extensible and shearable rods about the extrapolated frames g* (docs/model.md §10.3).

    [a w ζ + Bᵀ K B/Δs + G(P*)] δ = w (f − ζ c) − Bᵀ K (ξ(g*) − ξ0),     g = g* exp δ

One thread does the whole step of a tile: it assembles the blocks of a node and of the segment after it, and eliminates
them at once.
"""

import warp as wp

from warp_rods.kernels.cosserat.blocks import (
    SLOTS,
    add_drag,
    add_segment,
    clear,
    eliminate_row,
    hold,
    substituted,
    times,
    unless_held,
)
from warp_rods.kernels.cosserat.rod import (
    by_component,
    changes_of,
    drag_of,
    length_at,
    load_at,
    screw_after,
    stress_of,
)
from warp_rods.kernels.cosserat.state import Frames, Past, Rods, Trial, Work
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Lanes,
    Matrix,
    Screw,
    add,
    div,
    load,
    mul,
    sub,
    transposed_times,
)
from warp_rods.kernels.layout import real
from warp_rods.kernels.multistep import Weights
from warp_rods.kernels.screws import (
    bracket,
    carried,
    carried_on,
    changed,
    changed_before,
    minus,
    moved_frame,
    orthonormal,
    plus,
    scaled,
)

wp.set_module_options({"enable_backward": False})

MARGIN = wp.constant(real(2.4))
"""Stiffness of contact for which a step is stable, over that of a node against neighbours at rest (§6.4)."""


@wp.func
def predict_frames(tile: int, e: Weights, now: Frames, past: Past, star: Frames, trial: Trial):
    """g* = g exp(−e₁ ξ), and the extrapolated stress."""
    share = real(-1.0) * e[1]
    for node in range(now.rotation.shape[1]):
        y = scaled(share, past.screw[tile, node])
        R, r = moved_frame(now.rotation[tile, node], now.position[tile, node], y)
        star.rotation[tile, node] = R
        star.position[tile, node] = r
        trial.screw[tile, node] = y
        P = now.stress[tile, node]
        star.stress[tile, node] = plus(P, scaled(share, minus(P, past.stress_before[tile, node])))


@wp.func
def find_segment(tile: int, node: int, rods: Rods, star: Frames, work: Work):
    """A, C and the stress of the segment after a node of g*."""
    X = screw_after(tile, node, star)
    A, C = changes_of(X)
    work.angle[tile, node] = A
    work.place[tile, node] = C
    work.stress[tile, node] = stress_of(tile, node, rods, X)


@wp.func
def contact_block(tile: int, node: int, rods: Rods, star: Frames, foretold: Lanes, length: Lanes) -> Matrix:
    """The stiffness of contact that holds a node back, in its frame."""
    R = star.rotation[tile, node]
    factor = MARGIN * foretold / (real(1.0) + foretold)
    return (length * factor) * transposed_times(R, load(rods.contact_stiffness, tile, node) * R)


@wp.func
def force_at(tile: int, node: int, rods: Rods, star: Frames, past: Past, length: Lanes, d1: Lanes) -> Screw:
    """w (f − ζ c), with c = Σ d_j x_j = −d₁ ξ."""
    external = scaled(length, load_at(tile, node, rods, star))
    return plus(external, scaled(length * d1, by_component(drag_of(tile, rods), past.screw[tile, node])))


@wp.func
def eliminate(tile: int, rods: Rods, star: Frames, past: Past, drag: Screw, d1: Lanes, foretold: Lanes, work: Work):
    """Blocks of each node, eliminated from the first to the last; ``drag`` is a ζ."""
    last = star.rotation.shape[1] - 1
    per_spacing = real(1.0) / rods.spacing
    b = work.blocks
    clear(b.diagonal, tile, 0)
    before = Screw()
    for node in range(last + 1):
        slot = node % SLOTS
        length = length_at(node, last, rods)
        rhs = minus(force_at(tile, node, rods, star, past, length, d1), before)
        contact = Matrix()
        if rods.touched == 1:
            contact = contact_block(tile, node, rods, star, foretold, length)
        add_drag(b.diagonal, tile, slot, scaled(length, drag), contact)
        if node < last:
            find_segment(tile, node, rods, star, work)
            A, C, P = work.angle[tile, node], work.place[tile, node], work.stress[tile, node]
            rhs = plus(rhs, carried(A, C, P))
            before = carried_on(A, C, P)
            next = (node + 1) % SLOTS
            add_segment(
                rods.stiffness, work.angle, work.place, star.stress, b.lower, b.diagonal, b.upper, per_spacing,
                tile, node, slot, next,
            )  # fmt: skip
        if node == last:
            clear(b.upper, tile, slot)
        if node == 0 or node == last:
            end = node // last
            hold(b.lower, b.diagonal, b.upper, tile, slot, rods.held[tile, end])
            rhs = unless_held(rhs, rods.held[tile, end])
        eliminate_row(b.lower, b.diagonal, b.upper, b.rows, tile, node, slot, rhs)


@wp.func
def substitute(tile: int, rods: Rods, star: Frames, trial: Trial, work: Work):
    """From δ of the last node back to the first: frames, stress and screws at the end of the step."""
    last = star.rotation.shape[1] - 1
    per_spacing = Lanes(real(1.0) / rods.spacing)
    after = Screw()
    for back in range(last + 1):
        node = last - back
        delta = substituted(work.blocks.rows[tile, node], after)
        if node < last:
            A, C = work.angle[tile, node], work.place[tile, node]
            change = minus(changed(A, C, after), changed_before(A, C, delta))
            added = times(rods.stiffness[tile], scaled(per_spacing, change))
            star.stress[tile, node] = plus(work.stress[tile, node], added)
        R, r = moved_frame(star.rotation[tile, node], star.position[tile, node], delta)
        star.rotation[tile, node] = orthonormal(R)
        star.position[tile, node] = r
        y = trial.screw[tile, node]
        trial.screw[tile, node] = plus(plus(y, delta), scaled(Lanes(real(0.5)), bracket(y, delta)))
        after = plus(delta, Screw())

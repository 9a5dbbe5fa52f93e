"""The arrays of an ensemble of active rods, grouped as the kernels take them: of tiles of rods, or of single rods."""

import warp as wp

from warp_rods.kernels.lanes import Block, Blocks, Lanes1D, Lanes2D, Pairs, Vector, Vectors
from warp_rods.kernels.layout import (
    Integers1D,
    Matrices1D,
    Matrices2D,
    Scalars1D,
    Scalars2D,
    Vectors1D,
    Vectors2D,
    real,
)

FREE, HINGED, CLAMPED = wp.constant(0), wp.constant(1), wp.constant(2)
"""Kinds of ends: nothing holds it; it is held at a place; its frame is held, too."""


@wp.struct
class End:
    """What holds or loads an end of rods, in their Bishop frames there [tile]."""

    kind: int
    velocity: wp.array(dtype=Vector)  # u of a held end
    angular_velocity: wp.array(dtype=Vector)  # ω of a clamped end; its first component is ω0 of the material
    force: wp.array(dtype=Vector)  # on a free end
    couple: wp.array(dtype=Vector)  # on an end that is not clamped


@wp.struct
class Swimmers:
    """Parameters of an ensemble, dimensionless as in docs/model.md §1.2, and the status of its rods [rod].

    Those along the rod are fields [tile, node]; a number for each rod is stored once (``layout.py``).
    """

    bending_stiffness: Lanes2D  # b = β⊥
    twist_stiffness: Lanes2D  # c = β∥
    natural_bending: Pairs  # k0 of the material frame
    natural_twist: Lanes2D  # τ0
    drag_along: Lanes2D  # ζ∥, half nodes
    drag_across: Lanes2D  # ζ⊥
    rotational_mobility: Lanes2D  # 1/ζr, half nodes
    moment: Lanes1D  # M
    relaxation: Lanes1D  # τf
    diffusion: Lanes1D  # D
    law: int  # law of the flagella: a number of ``flagella.py``
    law_parameters: wp.array(dtype=Block)  # four parameters of that law
    status: Integers1D  # OK, or why the rod was frozen
    spacing: real  # Δs
    first: End
    last: End
    tracked: int  # the node whose frame is integrated in time
    bent: int  # 1: natural bending may not vanish
    wound: int  # 1: natural twist may not vanish
    symmetric: int  # 1: impose the π-rotation symmetry (C.50)
    forced: int  # 1: external forces or contact act on the rods
    touched: int  # 1: contact may
    flowing: int  # 1: a background flow does


@wp.struct
class Shape:
    """The fields that are advanced in time [tile, node]: k of the Bishop frame, τ, f."""

    bending: Pairs
    twist: Lanes2D
    activity: Lanes2D


@wp.struct
class Past:
    """Shapes of the levels before the present one, newest first."""

    first: Shape
    second: Shape
    third: Shape
    fourth: Shape


@wp.struct
class Load:
    """What acts on a rod from outside [tile, node], in its Bishop frame; drag is what contact adds to its own."""

    axial_force: Lanes2D  # half nodes
    transverse_force: Pairs
    axial_drag: Lanes2D  # half nodes
    transverse_drag: Blocks  # symmetric
    axial_couple: Lanes2D  # µ0, half nodes
    transverse_couple: Pairs  # µ⊥, half nodes
    axial_stream: Lanes2D  # u∞, which the forces contain: along at half nodes
    transverse_stream: Pairs  # across
    stream_roll: Lanes2D  # ½∇×u∞ about the tangent, half nodes


@wp.struct
class Balance:
    """Tension and velocities that balance forces and moments [tile, node], and workspace of the linear systems."""

    load: Load  # given
    rest: Pairs  # k0 exp(iϑ), the natural bending in the Bishop frame
    axial_mobility: Lanes2D  # 1 over the drag along, half nodes
    transverse_mobility: Blocks  # inverse of the drag across
    moment_slope: Pairs  # m⊥' + µ⊥, half nodes
    axial_source: Lanes2D  # u0 without the tension, half nodes
    transverse_source: Pairs  # u⊥ without the tension
    tension: Lanes2D  # λ
    axial_velocity: Lanes2D  # u0, half nodes
    transverse_velocity: Pairs  # u⊥
    angular_velocity: Pairs  # ω⊥, half nodes
    twist_source: Lanes2D  # Im(k̄ ω⊥), half nodes
    bishop_roll_rate: Lanes2D  # ω0 of the Bishop frame, 0 at the middle node
    lower2: Lanes2D
    lower: Lanes2D
    diagonal: Lanes2D
    upper: Lanes2D
    upper2: Lanes2D
    rhs: Lanes2D
    rhs_pairs: Pairs
    rhs_equal: Pairs
    work: Lanes2D
    work_pairs: Pairs
    work_pairs2: Pairs
    complex_lower2: Pairs
    complex_lower: Pairs
    complex_diagonal: Pairs
    complex_upper: Pairs
    complex_upper2: Pairs
    block_lower2: Blocks
    block_lower: Blocks
    block_diagonal: Blocks
    block_upper: Blocks
    block_upper2: Blocks
    work_block: Blocks
    work_block2: Blocks


NOT_CARRIED, CARRIED_ALIKE, CARRIED_APART = wp.constant(0), wp.constant(1), wp.constant(2)
"""How a flow carries the places of rods: not at all; all alike, as it is uniform; each as it flows there."""


@wp.struct
class Carrier:
    """How far the flow has carried rods: the frames of ``Midpoint`` are in axes carried along, without turning."""

    kind: int
    uniform: wp.vec3d  # velocity of a uniform flow; the arrays are those of others
    displacement: Vectors1D  # [rod]
    displacement_before: Vectors1D  # one step ago
    velocity: Vectors2D  # u∞ at the tracked node, at each level [rod, level]
    stream: Vectors2D  # u∞ at the end of the step that is tried [rod, node]


@wp.struct
class Midpoint:
    """The Bishop frame of the tracked node, the angle θ of the material frame in it, and their rates [rod]."""

    rotation: Matrices1D
    position: Vectors1D
    angle: Scalars1D  # θ
    rotation_before: Matrices1D  # the same one step ago
    position_before: Vectors1D
    angle_before: Scalars1D
    angular_velocity: Vectors2D  # ω of the Bishop frame at each level [rod, level]
    velocity: Vectors2D  # u
    roll_rate: Scalars2D  # ω0 of the material
    carrier: Carrier


@wp.struct
class Contact:
    """Stiffness of contact at the extrapolated places r*, and the velocities with which steps treat it."""

    present: int  # 1: something writes the stiffness
    stiffness: Matrices2D  # K, in space [rod, node]
    velocity: Vectors  # v of the last step [tile, node]: v0 at the half node, v⊥ at the node
    lag: Vectors  # r − r* of the last step
    velocity_tried: Vectors  # those of the step that is tried
    lag_tried: Vectors
    foretold: Vectors  # the velocity of r** in the step that is tried


@wp.struct
class Trial:
    """A step that is tried [rod]: its formula, its result, and the rates of the tracked node at its end."""

    end: Scalars1D
    limit: Scalars1D  # no step of a rod goes beyond this time
    angle: Scalars1D  # θ at the end, extrapolated
    order: Integers1D
    status: Integers1D
    error: Scalars1D
    angular_velocity: Vectors1D
    velocity: Vectors1D
    roll_rate: Scalars1D

"""The arrays of an ensemble of active rods, grouped as the kernels take them."""

import warp as wp

from warp_rods.kernels.layout import (
    Blocks2D,
    Integers1D,
    Matrices1D,
    Matrices2D,
    Pairs2D,
    Scalars1D,
    Scalars2D,
    Vectors1D,
    Vectors2D,
    real,
)


@wp.struct
class Swimmers:
    """Parameters of an ensemble [rod], dimensionless as in docs/model.md §1.2, and the status of its rods."""

    bending_stiffness: Scalars1D  # β⊥
    twist_stiffness: Scalars1D  # β∥
    moment: Scalars1D  # M
    drag_ratio: Scalars1D  # η
    rotational_drag: Scalars1D  # ηr
    relaxation: Scalars1D  # τf
    diffusion: Scalars1D  # D
    law: Integers1D  # law of the flagella: a number of ``flagella.py``
    law_parameters: wp.array(dtype=wp.vec4d)  # parameters of that law
    status: Integers1D  # OK, or why the rod was frozen
    spacing: real  # Δs
    symmetric: int  # 1: impose the π-rotation symmetry (C.50)
    forced: int  # 1: external forces or contact act on the rods


@wp.struct
class Shape:
    """The fields that are advanced in time [rod, node]: k of the Bishop frame, τ, f."""

    bending: Pairs2D
    twist: Scalars2D
    activity: Scalars2D


@wp.struct
class Past:
    """Shapes of the levels before the present one, newest first."""

    first: Shape
    second: Shape
    third: Shape
    fourth: Shape


@wp.struct
class Load:
    """What acts on a rod from outside [rod, node], in its Bishop frame; drag is what contact adds to its own."""

    axial_force: Scalars2D  # half nodes
    transverse_force: Pairs2D
    axial_drag: Scalars2D  # half nodes
    transverse_drag: Blocks2D  # symmetric


@wp.struct
class Balance:
    """Tension and velocities that balance forces and moments [rod, node], and workspace of the linear systems."""

    load: Load  # given
    axial_mobility: Scalars2D  # 1 over the drag along, half nodes
    transverse_mobility: Blocks2D  # inverse of the drag across
    axial_source: Scalars2D  # u0 without the tension, half nodes
    transverse_source: Pairs2D  # u⊥ without the tension
    tension: Scalars2D  # λ
    axial_velocity: Scalars2D  # u0, half nodes
    transverse_velocity: Pairs2D  # u⊥
    angular_velocity: Pairs2D  # ω⊥, half nodes
    twist_source: Scalars2D  # Im(k̄ ω⊥), half nodes
    bishop_roll_rate: Scalars2D  # ω0 of the Bishop frame, 0 at the middle node
    lower2: Scalars2D
    lower: Scalars2D
    diagonal: Scalars2D
    upper: Scalars2D
    upper2: Scalars2D
    rhs: Scalars2D
    rhs_pairs: Pairs2D
    work: Scalars2D
    work_pairs: Pairs2D
    block_lower2: Blocks2D
    block_lower: Blocks2D
    block_diagonal: Blocks2D
    block_upper: Blocks2D
    block_upper2: Blocks2D
    work_block: Blocks2D
    work_block2: Blocks2D


@wp.struct
class Midpoint:
    """The Bishop frame of the middle node, the angle θ of the material frame in it, and their rates [rod]."""

    rotation: Matrices1D
    position: Vectors1D
    angle: Scalars1D  # θ
    rotation_before: Matrices1D  # the same one step ago
    position_before: Vectors1D
    angle_before: Scalars1D
    angular_velocity: Vectors2D  # ω of the Bishop frame at each level [rod, level]
    velocity: Vectors2D  # u
    roll_rate: Scalars2D  # ω0 of the material


@wp.struct
class Contact:
    """Stiffness of contact at the extrapolated places r* [rod, node], and the velocities with which steps treat it."""

    present: int  # 1: something writes the stiffness
    stiffness: Matrices2D  # K, in space
    velocity: Vectors2D  # v of the last step: v0 at the half node, v⊥ at the node
    lag: Vectors2D  # r − r* of the last step
    velocity_tried: Vectors2D  # those of the step that is tried
    lag_tried: Vectors2D
    foretold: Vectors2D  # the velocity of r** in the step that is tried


@wp.struct
class Trial:
    """A step that is tried [rod]: its formula, its result, and the rates of the middle node at its end."""

    end: Scalars1D
    order: Integers1D
    rate: Scalars1D  # a
    status: Integers1D
    error: Scalars1D
    angular_velocity: Vectors1D
    velocity: Vectors1D
    roll_rate: Scalars1D

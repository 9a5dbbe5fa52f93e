"""The arrays of an ensemble of active rods, as their kernels take them."""

import warp as wp

from warp_rods.kernels.layout import real

per_rod = wp.array(dtype=wp.float64)
numbers = wp.array2d(dtype=wp.float64)
pairs = wp.array2d(dtype=wp.vec2d)
vectors = wp.array2d(dtype=wp.vec3d)


@wp.struct
class Swimmers:
    """Parameters of an ensemble, [rod], dimensionless as in model.md §1."""

    bending_stiffness: per_rod  # β⊥
    twist_stiffness: per_rod  # β∥
    moment: per_rod  # M
    drag_ratio: per_rod  # η
    rotational_drag: per_rod  # ηr
    relaxation: per_rod  # τf
    diffusion: per_rod  # D
    law: wp.array(dtype=wp.int32)  # of the flagella: its number in ``flagella.reaction``
    law_numbers: wp.array(dtype=wp.vec4d)  # the law's own parameters
    status: wp.array(dtype=wp.int32)  # SOUND, or why it is frozen at its last sound state
    spacing: real  # Δs
    symmetric: int  # 1: keep the π-rotation symmetry (C.50) exactly


@wp.struct
class Shape:
    """What the shape equations evolve, [rod, node]: k_B, τ, f."""

    bending: pairs
    twist: numbers
    activity: numbers


@wp.struct
class Flow:
    """What force and moment balance give for a shape, [rod, node], and room for the solves."""

    force: vectors  # f_ext in the Bishop frame, given
    axial_source: numbers  # u0 without tension, half nodes
    transverse_source: pairs  # u⊥ without tension
    tension: numbers  # λ
    axial: numbers  # u0, half nodes
    transverse: pairs  # u⊥
    spin: pairs  # ω⊥, half nodes
    twist_source: numbers  # Im(k̄ ω⊥), half nodes
    bishop_spin: numbers  # ω0 of the Bishop frame, 0 at the midpoint
    lower2: numbers
    lower: numbers
    diagonal: numbers
    upper: numbers
    upper2: numbers
    right: numbers
    right_pair: pairs
    work: numbers
    work_pair: pairs


@wp.struct
class Midpoint:
    """The Bishop frame of the middle node, the material's angle in it, and their last rates, [rod]."""

    rotation: wp.array(dtype=wp.mat33d)
    position: wp.array(dtype=wp.vec3d)
    angle: wp.array(dtype=wp.float64)
    spin: wp.array(dtype=wp.vec3d)
    velocity: wp.array(dtype=wp.vec3d)
    roll: wp.array(dtype=wp.float64)


@wp.struct
class AppliedForce:
    """External force per length in the Bishop frame [rod, node]."""

    now: wp.array2d(dtype=wp.vec3d)
    before: wp.array2d(dtype=wp.vec3d)  # one step ago

"""The arrays of an ensemble of surface-bound filaments as the kernels take them: of tiles, or of single rods."""

import warp as wp

from warp_rods.kernels.lanes import Block, Lanes1D, Lanes2D, Pairs, Vector, Vectors
from warp_rods.kernels.layout import Integers1D, Matrices2D, Scalars1D, Vectors2D
from warp_rods.kernels.outside import Outside

wp.set_module_options({"enable_backward": False})

Vectors1D = wp.array(dtype=Vector)
Quadruples = wp.array2d(dtype=Block)
"""Four numbers for each rod."""


@wp.struct
class Filaments:
    """Parameters [tile], state [tile, node] and workspace of one ensemble, and what others share, [rod, node]."""

    spacing: Lanes1D  # Δs
    stiffness: Vectors  # B: twist, normal bending, geodesic bending [tile, node]
    intrinsic: Vectors  # σ [tile, node]
    drag: Vectors  # ζ∥, ζ⊥, ζr [tile, node]
    growth_rate: Lanes1D  # dL/dt
    start_clamped: int  # 1: the first node is clamped
    end_clamped: int  # 1: the last node is clamped
    tracked: int  # the node whose frame is advanced in time: a clamped end, otherwise the middle
    membrane_moves: int  # 1: the membrane moves
    in_contact: int  # 1: rods have contact
    exposed: int  # 1: a flow, gravity, forces or couples act
    outside: Outside  # these, in space

    spacing_of_rod: Scalars1D  # Δs [rod]
    status: Integers1D  # OK, or why the rod was frozen [rod]
    active: Integers1D  # 1: the next kernels evaluate the rod [rod]
    position: Vectors2D  # r [rod, node]
    force: Vectors2D  # external force per length, in space [rod, node]
    contact_stiffness: Matrices2D  # K of contact, in space [rod, node]

    geodesic: Lanes2D  # Ω
    curvature: Vectors  # K11, K12, K22 in the pair (q, n×q)
    tangent: Vectors  # q
    across: Vectors  # n×q
    normal: Vectors  # n
    load: Vectors  # external force per length in the frame (q, n×q, n)
    contact_drag: Vectors  # C11, C12, C22: drag by which a step treats contact; 0 but in a step
    normal_velocity: Lanes2D  # V, velocity of the membrane along n
    normal_velocity_slope: Lanes2D  # V_1 = (n×q)·∇V

    couple: Vectors  # external couple per length in the frame, that of a flow included
    stream: Vectors  # u∞ in the frame
    stream_roll: Lanes2D  # ½∇×u∞ about the tangent
    moment: Vectors  # m = B(Ω − σ)
    shear_term: Lanes2D  # K11 m1 + K12 m2 + c2, so that λ2 = −m3' − shear_term
    transverse_force: Lanes2D  # Y2
    u1_left: Lanes2D  # u1 at i + ½ is u1_left λ_i + u1_right λ_(i+1) + u1_constant
    u1_right: Lanes2D
    u1_constant: Lanes2D
    tension: Lanes2D  # λ
    velocity_along: Lanes2D  # u1, half nodes
    velocity_across: Lanes2D  # u2
    geodesic_rate: Lanes2D  # ∂Ω/∂t


@wp.struct
class Systems:
    """Rows of the banded systems [tile, node]; the tridiagonal one uses the three bands in the middle."""

    lower2: Lanes2D
    lower: Lanes2D
    diagonal: Lanes2D
    upper: Lanes2D
    upper2: Lanes2D
    rhs: Lanes2D
    work: Lanes2D
    work_pairs: Pairs
    turn: Lanes2D  # δα at half nodes; first the right-hand side
    weights: Quadruples  # from δα at the half nodes i − 2 to i + 1 to δu2 at node i

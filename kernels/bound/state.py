"""The arrays of an ensemble of surface-bound filaments, grouped as the kernels take them."""

import warp as wp

from warp_rods.kernels.layout import (
    Integers1D,
    Matrices2D,
    Scalars1D,
    Scalars2D,
    Vectors1D,
    Vectors2D,
)

wp.set_module_options({"enable_backward": False})


@wp.struct
class Filaments:
    """Parameters [rod], state and workspace [rod, node] of one ensemble."""

    spacing: Scalars1D  # Δs
    stiffness: Vectors1D  # B: twist, normal bending, geodesic bending
    intrinsic: Vectors1D  # σ
    drag: Vectors1D  # ζ∥, ζ⊥, ζr
    status: Integers1D  # OK, or why the rod was frozen
    active: Integers1D  # 1: the next kernels evaluate the rod
    start_clamped: int  # 1: the first node is clamped
    end_clamped: int  # 1: the last node is clamped
    tracked: int  # the node whose frame is advanced in time: a clamped end, otherwise the middle
    growth_rate: Scalars1D  # dL/dt

    geodesic: Scalars2D  # Ω
    curvature: Vectors2D  # K11, K12, K22 in the pair (q, n×q)
    rotation: Matrices2D  # columns q, n×q, n
    position: Vectors2D  # r
    force: Vectors2D  # external force per length, in space
    contact_drag: Vectors2D  # C11, C12, C22: drag by which a step treats contact; 0 but in a step
    membrane_moves: int  # 1: the membrane moves
    normal_velocity: Scalars2D  # V, velocity of the membrane along n
    normal_velocity_slope: Scalars2D  # V_1 = (n×q)·∇V

    moment: Vectors2D  # m = B(Ω − σ)
    shear_term: Scalars2D  # K11 m1 + K12 m2, so that λ2 = −m3' − shear_term
    transverse_force: Scalars2D  # Y2
    u1_left: Scalars2D  # u1 at i + ½ is u1_left λ_i + u1_right λ_(i+1) + u1_constant
    u1_right: Scalars2D
    u1_constant: Scalars2D
    tension: Scalars2D  # λ
    velocity_along: Scalars2D  # u1, half nodes
    velocity_across: Scalars2D  # u2
    geodesic_rate: Scalars2D  # ∂Ω/∂t

"""The arrays of an ensemble of surface-bound filaments, as its kernels take them."""

import warp as wp

wp.set_module_options({"enable_backward": False})

scalars = wp.array2d(dtype=wp.float64)
vectors = wp.array2d(dtype=wp.vec3d)
per_rod = wp.array(dtype=wp.float64)


@wp.struct
class Filaments:
    """The arrays of one ensemble: parameters per rod, state and workspace per node [rod, node]."""

    spacing: wp.array(dtype=wp.float64)  # Δs
    stiffness: wp.array(dtype=wp.vec3d)  # B: twist, normal bending, geodesic bending
    intrinsic: wp.array(dtype=wp.vec3d)  # σ
    drag: wp.array(dtype=wp.vec3d)  # ζ∥, ζ⊥, ζr
    status: wp.array(dtype=wp.int32)  # 0: well; else frozen
    start_clamped: int  # 1: the first node's position and tangent are held
    end_clamped: int  # 1: the last node's are
    anchor: int  # the node whose frame is tracked: a clamped one, else the middle
    growth_rate: wp.array(dtype=wp.float64)  # dL/dt

    geodesic: scalars  # Ω
    curvature: vectors  # K11, K12, K22 in the pair (q, n×q)
    rotation: wp.array2d(dtype=wp.mat33d)  # columns q, n×q, n
    position: vectors  # r
    force: vectors  # external force per length, in space
    moving: int  # 1: the membrane moves
    normal_velocity: scalars  # V, velocity of the membrane along n; zero where it rests
    normal_velocity_slope: scalars  # V_1 = (n×q)·∇V

    moment: vectors  # m = B(Ω − σ)
    shear: scalars  # K11 m1 + K12 m2
    transverse_force: scalars  # Y2
    to_left: scalars  # u1 at i + 1/2 is to_left λ_i + to_right λ_(i+1) + remainder
    to_right: scalars
    remainder: scalars
    tension: scalars  # λ
    along: scalars  # u1, half nodes
    across: scalars  # u2
    rate: scalars  # ∂Ω/∂t

"""A field given by coefficients on a grid: the tricubic B-spline, C², with its exact gradient and Hessian.

Node i of an axis is at origin + i spacing. Beyond the grid the field is continued by reflection.
"""

import warp as wp

from warp_rods.kernels.layout import real
from warp_rods.kernels.surface.geometry import Parameters

wp.set_module_options({"enable_backward": False})

Weights = wp.types.matrix((3, 4), wp.float64)
"""Rows: value, first and second derivative; columns: the four nodes around a point."""


@wp.func
def cubic(t: real) -> Weights:
    """Weights of the nodes at −1, 0, 1, 2 for a point at 0 ≤ t < 1."""
    s = real(1.0) - t
    third = real(1.0) / real(3.0)
    half = real(0.5)
    return Weights(
        half * third * s * s * s,
        real(2.0) * third - t * t * (real(1.0) - half * t),
        real(2.0) * third - s * s * (real(1.0) - half * s),
        half * third * t * t * t,
        -half * s * s,
        half * t * (real(3.0) * t - real(4.0)),
        half * s * (real(4.0) - real(3.0) * s),
        half * t * t,
        s,
        real(3.0) * t - real(2.0),
        real(3.0) * s - real(2.0),
        t,
    )


@wp.func
def mirrored(i: int, n: int) -> int:
    """The node whose coefficient is used at i, which may lie beyond the ends of an axis of n nodes."""
    period = 2 * (n - 1)
    k = ((i % period) + period) % period
    return wp.min(k, period - k)


@wp.func
def mirrored4(i: int, n: int) -> wp.vec4i:
    return wp.vec4i(mirrored(i - 1, n), mirrored(i, n), mirrored(i + 1, n), mirrored(i + 2, n))


@wp.func
def row(c: wp.array3d(dtype=wp.float64), i: int, j: int, k: wp.vec4i) -> wp.vec4d:
    return wp.vec4d(c[i, j, k[0]], c[i, j, k[1]], c[i, j, k[2]], c[i, j, k[3]])


@wp.func
def sheet(c: wp.array3d(dtype=wp.float64), i: int, j: wp.vec4i, k: wp.vec4i, wy: Weights, wz: Weights) -> wp.mat33d:
    """Derivatives of orders 0, 1, 2 [along y, along z] in the plane of nodes i."""
    z0 = wz * row(c, i, j[0], k)
    z1 = wz * row(c, i, j[1], k)
    z2 = wz * row(c, i, j[2], k)
    z3 = wz * row(c, i, j[3], k)
    return wy * wp.matrix_from_rows(z0, z1, z2, z3)


@wp.func
def spline(x: wp.vec3d, p: Parameters):
    """φ = Σ c_ijk β(x − i) β(y − j) β(z − k); p.v holds the origin and the spacing of the grid."""
    h = wp.vec3d(p.v[3], p.v[4], p.v[5])
    u = wp.cw_div(x - wp.vec3d(p.v[0], p.v[1], p.v[2]), h)
    cell = wp.vec3d(wp.floor(u[0]), wp.floor(u[1]), wp.floor(u[2]))
    wx = cubic(u[0] - cell[0])
    wy = cubic(u[1] - cell[1])
    wz = cubic(u[2] - cell[2])
    i = mirrored4(int(cell[0]), p.grid.shape[0])
    j = mirrored4(int(cell[1]), p.grid.shape[1])
    k = mirrored4(int(cell[2]), p.grid.shape[2])
    s0 = sheet(p.grid, i[0], j, k, wy, wz)
    s1 = sheet(p.grid, i[1], j, k, wy, wz)
    s2 = sheet(p.grid, i[2], j, k, wy, wz)
    s3 = sheet(p.grid, i[3], j, k, wy, wz)
    d0 = wx[0, 0] * s0 + wx[0, 1] * s1 + wx[0, 2] * s2 + wx[0, 3] * s3
    d1 = wx[1, 0] * s0 + wx[1, 1] * s1 + wx[1, 2] * s2 + wx[1, 3] * s3
    d2 = wx[2, 0] * s0 + wx[2, 1] * s1 + wx[2, 2] * s2 + wx[2, 3] * s3
    g = wp.cw_div(wp.vec3d(d1[0, 0], d0[1, 0], d0[0, 1]), h)
    H = wp.matrix_from_rows(
        wp.cw_div(wp.vec3d(d2[0, 0], d1[1, 0], d1[0, 1]), h) / h[0],
        wp.cw_div(wp.vec3d(d1[1, 0], d0[2, 0], d0[1, 1]), h) / h[1],
        wp.cw_div(wp.vec3d(d1[0, 1], d0[1, 1], d0[0, 2]), h) / h[2],
    )
    return d0[0, 0], g, H

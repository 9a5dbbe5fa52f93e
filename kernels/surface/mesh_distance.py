"""Distances to a closed mesh of triangles, its sides (by the winding number), and its thickness along rays."""

import warp as wp

from warp_rods.kernels.layout import Scalars1D, real

wp.set_module_options({"enable_backward": False})


@wp.func
def distance_from(mesh: wp.uint64, x: wp.vec3, face: int, u: float, v: float) -> real:
    """The distance of x from a point of a face, in float64, where single precision would lose most digits."""
    return wp.length(wp.vec3d(x) - wp.vec3d(wp.mesh_eval_position(mesh, face, u, v)))


@wp.kernel
def distance(mesh: wp.uint64, largest: float, points: wp.array(dtype=wp.vec3), found: Scalars1D):
    """The distance of each point to the mesh, searched for up to ``largest``."""
    i = wp.tid()
    nearest = wp.mesh_query_point_no_sign(mesh, points[i], largest)
    found[i] = distance_from(mesh, points[i], nearest.face, nearest.u, nearest.v)


@wp.kernel
def signed_distance(mesh: wp.uint64, largest: float, points: wp.array(dtype=wp.vec3), found: Scalars1D):
    """As ``distance``, negative inside."""
    i = wp.tid()
    nearest = wp.mesh_query_point_sign_winding_number(mesh, points[i], largest)
    found[i] = real(nearest.sign) * distance_from(mesh, points[i], nearest.face, nearest.u, nearest.v)


@wp.kernel
def opposite(
    mesh: wp.uint64,
    largest: float,
    side: float,
    facing: float,
    points: wp.array(dtype=wp.vec3),
    normals: wp.array(dtype=wp.vec3),
    found: Scalars1D,
):
    """The distance from points on the mesh along ±normal (``side``) to the sheet opposite, or ``largest``.

    A sheet is opposite where the cosine between both normals is below −``facing``; edges and tips have none.
    """
    i = wp.tid()
    n = normals[i]
    start = points[i] + n * (side * 1.0e-6 * largest)
    hit = wp.mesh_query_ray(mesh, start, n * side, largest)
    found[i] = real(largest)
    if hit.result and wp.dot(hit.normal, n) < -facing:
        found[i] = real(hit.t)

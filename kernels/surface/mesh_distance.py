"""Signed distance to a closed mesh of triangles: negative inside, by the winding number."""

import warp as wp

wp.set_module_options({"enable_backward": False})


@wp.kernel
def signed_distance(
    mesh: wp.uint64, reach: float, points: wp.array(dtype=wp.vec3), distance: wp.array(dtype=wp.float64)
):
    i = wp.tid()
    x = points[i]
    found = wp.mesh_query_point_sign_winding_number(mesh, x, reach)
    nearest = wp.mesh_eval_position(mesh, found.face, found.u, found.v)
    # In float64: the difference of two near points is where single precision loses most.
    away = wp.vec3d(x) - wp.vec3d(nearest)
    distance[i] = wp.float64(found.sign) * wp.length(away)

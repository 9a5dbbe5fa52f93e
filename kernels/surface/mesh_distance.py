"""Signed distance to a closed mesh of triangles: negative inside, by the winding number."""

import warp as wp

from warp_rods.kernels.layout import Scalars1D

wp.set_module_options({"enable_backward": False})


@wp.kernel
def signed_distance(mesh: wp.uint64, largest: float, points: wp.array(dtype=wp.vec3), distance: Scalars1D):
    """The distance of each point to the mesh, searched for up to ``largest``."""
    i = wp.tid()
    x = points[i]
    found = wp.mesh_query_point_sign_winding_number(mesh, x, largest)
    nearest = wp.mesh_eval_position(mesh, found.face, found.u, found.v)
    # The difference of two close points is taken in float64, where single precision would lose most digits.
    separation = wp.vec3d(x) - wp.vec3d(nearest)
    distance[i] = wp.float64(found.sign) * wp.length(separation)

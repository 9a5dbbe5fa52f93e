"""Lists of neighbours: for every node of a scene the others that may come within reach before lists are made anew.

Lists are made of all pairs within the reach and a skin; they hold until a node has moved by half the skin. On a
periodic axis the cells of the hash grid divide the period, so that its own wrapping is that of the box.
"""

import warp as wp

from warp_rods.kernels.contact.box import nearest_image
from warp_rods.kernels.layout import real
from warp_rods.kernels.stencils import trapezoid_weight

wp.set_module_options({"enable_backward": False})

STEP = wp.constant(0)
DRIFT = wp.constant(1)
"""Places in ``moved``: the square of the largest displacement of a node in one step, and since lists were made."""


@wp.struct
class Cloud:
    """Every node of every ensemble in one list [point]."""

    position: wp.array(dtype=wp.vec3d)
    reference: wp.array(dtype=wp.vec3d)  # where it was when the lists were made
    cell: wp.array(dtype=wp.vec3d)  # and in units of the grid's cells
    weight: wp.array(dtype=wp.float64)  # trapezoid weight: the length a node stands for
    arc: wp.array(dtype=wp.float64)  # arc length from the start of its rod
    apart: wp.array(dtype=wp.float64)  # pairs of one rod closer than this along it are left out
    drag: wp.array(dtype=wp.float64)  # ζ⊥ of its rod
    rod: wp.array(dtype=wp.int32)  # number of its rod over all ensembles
    moved: wp.array(dtype=wp.float64)
    period: wp.vec3d
    cells_per_length: wp.vec3d


@wp.struct
class Lists:
    """Neighbours of every node, the lesser numbers first."""

    near: wp.array2d(dtype=wp.int32)  # [point, place]
    count: wp.array(dtype=wp.int32)  # how many there are [point]: more than places where lists are too short


@wp.kernel
def pack(
    position: wp.array2d(dtype=wp.vec3d),
    spacing: wp.array(dtype=wp.float64),
    first: int,
    core: real,
    cloud: Cloud,
):
    """One ensemble's nodes into the list from ``first`` on, and how far they have come."""
    rod, i = wp.tid()
    nodes = position.shape[1]
    h = spacing[rod]
    k = first + rod * nodes + i
    x = position[rod, i]
    farther(cloud.moved, STEP, x - cloud.position[k])
    farther(cloud.moved, DRIFT, x - cloud.reference[k])
    cloud.position[k] = x
    cloud.weight[k] = trapezoid_weight(i, nodes, h)
    cloud.arc[k] = h * real(i)
    # A little off the bound, so that round-off does not decide which pairs it leaves out.
    cloud.apart[k] = wp.max(real(2.0) * core, real(4.0) * h) - real(1e-6) * h


@wp.func
def farther(moved: wp.array(dtype=wp.float64), place: int, displacement: wp.vec3d):
    """Keep the larger displacement; a maximum comes out the same in any order."""
    square = wp.dot(displacement, displacement)
    if square > moved[place]:
        wp.atomic_max(moved, place, square)


@wp.kernel
def settle(cloud: Cloud):
    """Let the lists be made of the present positions."""
    k = wp.tid()
    x = cloud.position[k]
    cloud.reference[k] = x
    cloud.cell[k] = wp.cw_mul(x, cloud.cells_per_length)


@wp.func
def may_interact(cloud: Cloud, i: int, j: int, reach: real) -> bool:
    """Within reach, and not close neighbours along one rod."""
    d = nearest_image(cloud.position[i] - cloud.position[j], cloud.period)
    if wp.dot(d, d) >= reach * reach:
        return False
    return cloud.rod[i] != cloud.rod[j] or wp.abs(cloud.arc[i] - cloud.arc[j]) >= cloud.apart[i]


@wp.kernel
def list_neighbours(grid: wp.uint64, cloud: Cloud, reach: real, lists: Lists):
    """The neighbours of every node by insertion, so that their numbers increase."""
    i = wp.hash_grid_point_id(grid, wp.tid())
    places = lists.near.shape[1]
    count = wp.int32(0)
    for j in wp.hash_grid_query(grid, cloud.cell[i], real(1.0)):
        if may_interact(cloud, i, j, reach):
            if count < places:
                k = count
                while k > 0 and lists.near[i, wp.max(k - 1, 0)] > j:
                    lists.near[i, k] = lists.near[i, k - 1]
                    k -= 1
                lists.near[i, k] = j
            count += 1
    lists.count[i] = count

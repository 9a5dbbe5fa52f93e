"""Neighbour lists: for each node of a scene the other nodes within the cut-off and a skin (docs/model.md §6.2).

Lists are valid until a node has moved by half the skin. On a periodic axis the cells of the hash grid divide the
period, so that the wrapping of the grid is that of the box.
"""

import warp as wp

from warp_rods.kernels.contact.box import nearest_image
from warp_rods.kernels.layout import Integers1D, Integers2D, Scalars1D, Vectors1D, Vectors2D, real
from warp_rods.kernels.status import OK
from warp_rods.kernels.stencils import trapezoid_weight

wp.set_module_options({"enable_backward": False})

IN_A_STEP = wp.constant(0)
"""Index in ``largest_moves``: the square of the largest displacement of a node since the last step."""
SINCE_LISTED = wp.constant(1)
"""Index in ``largest_moves``: the square of the largest displacement since the lists were built."""


@wp.struct
class Points:
    """All nodes of all ensembles in one list [point]."""

    position: Vectors1D
    last_position: Vectors1D  # position in the last step
    listed_position: Vectors1D  # position when the lists were built
    cell: Vectors1D  # listed position in units of the cells of the grid
    weight: Scalars1D  # weight in the trapezoid rule, 0 on a rod that is frozen: the others go on without it
    arc_length: Scalars1D  # from the start of the rod
    excluded: Scalars1D  # pairs of one rod that are closer than this along it do not interact
    rod: Integers1D  # number of the rod, counted over all ensembles
    largest_moves: Scalars1D
    period: wp.vec3d
    cells_per_length: wp.vec3d


@wp.struct
class Lists:
    """The neighbours of every point, in increasing order."""

    neighbour: Integers2D  # [point, place in its list]
    count: Integers1D  # number of neighbours [point]; exceeds the number of places where the lists are too short


@wp.kernel
def collect_points(position: Vectors2D, spacing: Scalars1D, status: Integers1D, first: int, core: real, points: Points):
    """Copy the nodes of one ensemble to the points from ``first`` on, and record how far they have moved."""
    rod, i = wp.tid()
    nodes = position.shape[1]
    h = spacing[rod]
    k = first + rod * nodes + i
    x = position[rod, i]
    points.position[k] = x
    points.weight[k] = real(0.0)
    if status[rod] == OK:
        points.weight[k] = trapezoid_weight(i, nodes, h)
        record_move(points.largest_moves, IN_A_STEP, x - points.last_position[k])
        record_move(points.largest_moves, SINCE_LISTED, x - points.listed_position[k])
    points.arc_length[k] = h * real(i)
    # Slightly below the bound, so that round-off does not decide about pairs at the bound.
    points.excluded[k] = wp.max(real(2.0) * core, real(4.0) * h) - real(1e-6) * h


@wp.func
def record_move(largest_moves: Scalars1D, index: int, displacement: wp.vec3d):
    """Keep the larger displacement; the maximum does not depend on the order of the threads."""
    square = wp.dot(displacement, displacement)
    if square > largest_moves[index]:
        wp.atomic_max(largest_moves, index, square)


@wp.kernel
def set_listed_positions(points: Points):
    """Record the present positions as those for which the lists are built."""
    k = wp.tid()
    x = points.position[k]
    points.listed_position[k] = x
    points.cell[k] = wp.cw_mul(x, points.cells_per_length)


@wp.func
def may_interact(points: Points, i: int, j: int, distance: real) -> bool:
    """Whether two points are within a distance, and not excluded as close neighbours along one rod."""
    d = nearest_image(points.position[i] - points.position[j], points.period)
    if wp.dot(d, d) >= distance * distance:
        return False
    along = wp.abs(points.arc_length[i] - points.arc_length[j])
    return points.rod[i] != points.rod[j] or along >= points.excluded[i]


@wp.kernel
def list_neighbours(grid: wp.uint64, points: Points, distance: real, lists: Lists):
    """List the neighbours within a distance of every point, by insertion sort."""
    i = wp.hash_grid_point_id(grid, wp.tid())
    places = lists.neighbour.shape[1]
    count = wp.int32(0)
    for j in wp.hash_grid_query(grid, points.cell[i], real(1.0)):
        if may_interact(points, i, j, distance):
            if count < places:
                k = count
                while k > 0 and lists.neighbour[i, wp.max(k - 1, 0)] > j:
                    lists.neighbour[i, k] = lists.neighbour[i, k - 1]
                    k -= 1
                lists.neighbour[i, k] = j
            count += 1
    lists.count[i] = count

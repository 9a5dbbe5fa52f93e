"""Neighbour lists: for adjacent nodes of a rod the other nodes within the cut-off and a skin (docs/model.md §6.2).

Lists are valid until a node has moved by half the skin. On a periodic axis the cells of the hash grid divide the
period, so that the wrapping of the grid is that of the box.
"""

import warp as wp

from warp_rods.kernels.contact.box import nearest_image
from warp_rods.kernels.layout import Integers1D, Integers2D, Scalars1D, Vectors1D, Vectors2D, real
from warp_rods.kernels.status import OK
from warp_rods.kernels.stencils import trapezoid_weight

wp.set_module_options({"enable_backward": False})

BLOCK = 4
"""Nodes that share a list: they fill the lanes of vector instructions."""
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
    """The neighbours of every block of ``BLOCK`` adjacent nodes of a rod, in increasing order."""

    first: Integers1D  # first point [block]
    size: Integers1D  # number of points, at the end of a rod less than ``BLOCK``
    block: Integers1D  # [point]
    neighbour: Integers2D  # of any point of a block [block, place in its list]
    count: Integers1D  # number of neighbours [block]; exceeds the number of places where the lists are too short


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


@wp.kernel
def forget_moves(points: Points):
    """Set the largest displacements to zero; ``dim = 2``."""
    points.largest_moves[wp.tid()] = real(0.0)


@wp.kernel
def keep_positions(points: Points):
    """Record the present positions as those of the last step."""
    k = wp.tid()
    points.last_position[k] = points.position[k]


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
def are_close_along(points: Points, i: int, j: int) -> bool:
    """Whether a point is excluded as a close neighbour of another along one rod."""
    along = wp.abs(points.arc_length[i] - points.arc_length[j])
    return points.rod[i] == points.rod[j] and along < points.excluded[i]


@wp.func
def may_interact(points: Points, i: int, j: int, distance: real) -> bool:
    """Whether two points are within a distance, and not excluded as close neighbours along one rod."""
    d = nearest_image(points.position[i] - points.position[j], points.period)
    return wp.dot(d, d) < distance * distance and not are_close_along(points, i, j)


@wp.func
def centre_of(points: Points, first: int, size: int):
    """The mean of the places of a block, and the largest distance of one from it."""
    centre = wp.vec3d()
    for n in range(size):
        centre += points.position[first + n] / real(size)
    radius = real(0.0)
    for n in range(size):
        radius = wp.max(radius, wp.length(points.position[first + n] - centre))
    return centre, radius


@wp.func
def any_may_interact(points: Points, first: int, size: int, j: int, distance: real) -> bool:
    """Whether any point of a block may interact with another point."""
    n = wp.int32(0)
    while n < size and not may_interact(points, first + n, j, distance):
        n += 1
    return n < size


@wp.kernel
def list_neighbours(grid: wp.uint64, points: Points, distance: real, cell: real, lists: Lists):
    """List the neighbours within a distance of every block, by insertion sort; no ``cell`` is narrower than this."""
    block = wp.tid()
    first, size = lists.first[block], lists.size[block]
    places = lists.neighbour.shape[1]
    centre, radius = centre_of(points, first, size)
    reach = distance + radius
    count = wp.int32(0)
    for j in wp.hash_grid_query(grid, wp.cw_mul(centre, points.cells_per_length), reach / cell):
        d = nearest_image(centre - points.position[j], points.period)
        if wp.dot(d, d) < reach * reach and any_may_interact(points, first, size, j, distance):
            if count < places:
                k = count
                while k > 0 and lists.neighbour[block, wp.max(k - 1, 0)] > j:
                    lists.neighbour[block, k] = lists.neighbour[block, k - 1]
                    k -= 1
                lists.neighbour[block, k] = j
            count += 1
    lists.count[block] = count

"""Centre lines as chains of straight segments in the cells of a grid, for placing rods apart (docs/model.md §6.5).

Rods are placed one after the other, so each kernel is a single thread on the host. The segments whose middles are in a
cell form a linked list, newest first. Rods enter and leave at a cost that does not depend on how many there are. The
cells repeat along each axis: those of one list may be far apart.
"""

import warp as wp

from warp_rods.kernels.contact.box import nearest_image
from warp_rods.kernels.layout import Integers1D, Vectors1D, real

wp.set_module_options({"enable_backward": False})

NONE = wp.constant(-1)
AROUND = wp.types.vector(27, wp.int32)
"""A list for each cell about one."""
CROSSED = wp.constant(real(1e-9))
"""Segments closer than this fraction of their length intersect: their separation has no direction."""
PARALLEL = wp.constant(real(1e-14))
"""The square of the sine of their angle below which segments count as parallel."""
TINY = wp.constant(real(2.3e-308))


@wp.struct
class Segments:
    """Segments of all rods, those of one after those of another, and the lists of cells."""

    node: Vectors1D  # all nodes [point]
    begin: Integers1D  # first node [segment]
    end: Integers1D  # second node; the first one again for a rod of one node
    rod: Integers1D  # [segment]
    first: Integers1D  # first segment of each rod, and the number of all of them [rod + 1]
    newest: Integers1D  # first segment in the list of a cell [cell]
    older: Integers1D  # the next one in the list [segment]
    cell: Integers1D  # [segment]
    period: wp.vec3d
    cells: wp.vec3i  # number of cells along each axis, after which they repeat
    cells_per_length: wp.vec3d
    clearance: real  # segments that are closer touch
    longest: real  # no segment is longer


@wp.func
def middle(segments: Segments, s: int) -> wp.vec3d:
    """The middle of a segment."""
    return real(0.5) * (segments.node[segments.begin[s]] + segments.node[segments.end[s]])


@wp.func
def is_finite(segments: Segments, s: int) -> bool:
    """Whether a segment has a place; others touch nothing."""
    return wp.isfinite(segments.node[segments.begin[s]]) and wp.isfinite(segments.node[segments.end[s]])


@wp.func
def cell_along(segments: Segments, x: wp.vec3d, axis: int) -> int:
    """The number along an axis of the cell of a point, from 0 on."""
    cell, n = wp.floor(x[axis] * segments.cells_per_length[axis]), real(segments.cells[axis])
    return int(cell - n * wp.floor(cell / n))


@wp.func
def number_of(segments: Segments, x: int, y: int, z: int) -> int:
    """The number of the cell with these numbers along the axes."""
    return (x * segments.cells[1] + y) * segments.cells[2] + z


@wp.func
def cells_beside(segments: Segments, x: wp.vec3d, axis: int) -> wp.vec3i:
    """Numbers along an axis of the cell of a point and those beside it; only as many as ``cells`` differ."""
    n, cell = segments.cells[axis], cell_along(segments, x, axis)
    return wp.vec3i(cell, (cell + 1) % n, (cell + n - 1) % n)


@wp.func
def lists_around(segments: Segments, x: wp.vec3d):
    """The first segments of the lists of the cells about a point, itself included, and how many lists there are."""
    i, j, k = cells_beside(segments, x, 0), cells_beside(segments, x, 1), cells_beside(segments, x, 2)
    n = segments.cells
    found, count = AROUND(), wp.int32(0)
    for a in range(wp.min(n[0], 3)):
        for b in range(wp.min(n[1], 3)):
            for c in range(wp.min(n[2], 3)):
                newest = segments.newest[number_of(segments, i[a], j[b], k[c])]
                if newest != NONE:
                    found[count] = newest
                    count += 1
    return found, count


@wp.func
def insert(segments: Segments, s: int):
    """Put a segment into the list of its cell."""
    if is_finite(segments, s):
        x = middle(segments, s)
        cell = number_of(segments, cell_along(segments, x, 0), cell_along(segments, x, 1), cell_along(segments, x, 2))
        segments.cell[s] = cell
        segments.older[s] = segments.newest[cell]
        segments.newest[cell] = s


@wp.func
def remove(segments: Segments, s: int):
    """Take a segment out of its list; its nodes need not be where they were."""
    cell = segments.cell[s]
    t = int(segments.newest[cell])
    if t == s:
        segments.newest[cell] = segments.older[s]
    while t != NONE and t != s:
        following = int(segments.older[t])
        if following == s:
            segments.older[t] = segments.older[s]
        t = following


@wp.func
def insert_rod(segments: Segments, rod: int):
    """Put the segments of a rod into the lists."""
    for s in range(segments.first[rod], segments.first[rod + 1]):
        insert(segments, s)


@wp.func
def remove_rod(segments: Segments, rod: int):
    """Take the segments of a rod out of the lists; the newest comes first."""
    last = segments.first[rod + 1] - 1
    for k in range(segments.first[rod + 1] - segments.first[rod]):
        remove(segments, last - k)


@wp.func
def nearest_places(p: wp.vec3d, a: wp.vec3d, q: wp.vec3d, b: wp.vec3d):
    """Where segments p + x a and q + y b are closest: x and y in [0, 1].

    Ericson, Real-Time Collision Detection (2005), §5.1.9. Parallel segments are closest at many places; one is given.
    """
    w = p - q
    aa, bb, ab, aw, bw = wp.dot(a, a), wp.dot(b, b), wp.dot(a, b), wp.dot(a, w), wp.dot(b, w)
    size = aa * bb - ab * ab
    x = real(0.0)
    if size > PARALLEL * aa * bb:
        x = wp.clamp((ab * bw - aw * bb) / size, real(0.0), real(1.0))
    y = wp.clamp((ab * x + bw) / wp.max(bb, TINY), real(0.0), real(1.0))
    return wp.clamp((ab * y - aw) / wp.max(aa, TINY), real(0.0), real(1.0)), y


@wp.func
def nearest_points(segments: Segments, s: int, t: int):
    """The separation of the nearest points of two segments whose middles are nearest images, from t to s.

    Also their places along s and t.
    """
    p, q = segments.node[segments.begin[s]], segments.node[segments.begin[t]]
    a, b = segments.node[segments.end[s]] - p, segments.node[segments.end[t]] - q
    apart = middle(segments, s) - middle(segments, t)
    image = p + nearest_image(apart, segments.period) - apart
    x, y = nearest_places(image, a, q, b)
    return image + x * a - q - y * b, x, y


@wp.func
def may_touch(segments: Segments, s: int, t: int) -> bool:
    """Whether segments belong to different rods and their middles are near enough."""
    if segments.rod[t] == segments.rod[s]:
        return False
    apart = nearest_image(middle(segments, s) - middle(segments, t), segments.period)
    reach = segments.clearance + segments.longest
    return wp.dot(apart, apart) <= reach * reach


@wp.func
def touch(segments: Segments, s: int, t: int) -> bool:
    """Whether segments belong to different rods and are close."""
    if not may_touch(segments, s, t):
        return False
    gap, _x, _y = nearest_points(segments, s, t)
    return wp.length(gap) < segments.clearance


@wp.func
def touches_any(segments: Segments, s: int) -> bool:
    """Whether a segment touches any of another rod."""
    found = wp.bool(False)
    if is_finite(segments, s):
        lists, count = lists_around(segments, middle(segments, s))
        for k in range(count):
            t = int(lists[k])
            while t != NONE and not found:
                found = touch(segments, s, t)
                t = int(segments.older[t])
    return found


@wp.func
def rod_touches_any(segments: Segments, rod: int) -> bool:
    """Whether a rod touches any other."""
    s, stop = int(segments.first[rod]), segments.first[rod + 1]
    found = wp.bool(False)
    while s < stop and not found:
        found = touches_any(segments, s)
        s += 1
    return found


@wp.kernel
def insert_rods(segments: Segments, first: int, count: int):
    """Put rods into the lists; ``dim = 1``."""
    for rod in range(first, first + count):
        insert_rod(segments, rod)


@wp.kernel
def remove_rods(segments: Segments, first: int, fits: Integers1D):
    """Take the rods from ``first`` on that have been put into the lists out of them, newest first; ``dim = 1``."""
    last = fits.shape[0] - 1
    for k in range(fits.shape[0]):
        if fits[last - k] == 1:
            remove_rod(segments, first + last - k)


@wp.kernel
def insert_rods_that_fit(segments: Segments, first: int, fits: Integers1D):
    """Put those rods from ``first`` on into the lists that touch none there, one after the other; ``dim = 1``."""
    for k in range(fits.shape[0]):
        rod = first + k
        fits[k] = 0
        if not rod_touches_any(segments, rod):
            insert_rod(segments, rod)
            fits[k] = 1


@wp.func
def touch_anew(segments: Segments, s: int, t: int, last_touched: Integers1D) -> bool:
    """Whether segments touch of which the rods have not been counted."""
    if last_touched[segments.rod[t]] == segments.rod[s]:
        return False
    return touch(segments, s, t)


@wp.func
def mark_touching(segments: Segments, s: int, last_touched: Integers1D, count: Integers1D):
    """Count the rods that a segment touches and that were not counted for its rod."""
    rod = segments.rod[s]
    if is_finite(segments, s):
        lists, listed = lists_around(segments, middle(segments, s))
        for k in range(listed):
            t = int(lists[k])
            while t != NONE:
                if touch_anew(segments, s, t, last_touched):
                    last_touched[segments.rod[t]] = rod
                    count[0] = count[0] + 1
                t = int(segments.older[t])


@wp.kernel
def count_touching(segments: Segments, last_touched: Integers1D, most: int, count: Integers1D):
    """Count pairs of rods that touch, up to ``most``, putting them into the lists; ``dim = 1``.

    last_touched [rod]: the last rod that touched each, so that a pair counts once.
    """
    rod, rods = wp.int32(0), segments.first.shape[0] - 1
    while rod < rods and count[0] < most:
        for s in range(segments.first[rod], segments.first[rod + 1]):
            mark_touching(segments, s, last_touched, count)
        insert_rod(segments, rod)
        rod += 1

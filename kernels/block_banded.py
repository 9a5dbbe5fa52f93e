"""Pentadiagonal systems of 2 × 2 blocks, one for each rod, by elimination without pivoting; see ``banded.py``."""

import warp as wp

from warp_rods.kernels.layout import Blocks2D, Pairs2D, real

wp.set_module_options({"enable_backward": False})


@wp.func
def inverse(a: wp.mat22d):
    """a⁻¹."""
    scale = real(1.0) / (a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0])
    return wp.mat22d(scale * a[1, 1], -scale * a[0, 1], -scale * a[1, 0], scale * a[0, 0])


@wp.func
def solve_block_pentadiagonal_rod(
    rod: int,
    lower2: Blocks2D,
    lower: Blocks2D,
    diagonal: Blocks2D,
    upper: Blocks2D,
    upper2: Blocks2D,
    rhs: Pairs2D,
    work: Blocks2D,
    work2: Blocks2D,
    solution: Pairs2D,
):
    """Solve the system of one rod in one thread; at least 2 nodes.

    Row i becomes x[i] + c x[i+1] + e x[i+2] = y; c is stored in ``work``, e in ``work2``. Suffix 1 marks the row i − 1,
    suffix 2 the row i − 2. ``solution`` may be ``rhs``; the coefficients are not changed.
    """
    nodes = diagonal.shape[1]
    c2, e2, y2 = wp.mat22d(), wp.mat22d(), wp.vec2d()
    c1, e1, y1 = wp.mat22d(), wp.mat22d(), wp.vec2d()
    for i in range(nodes):
        b = lower2[rod, i]
        a = lower[rod, i]
        if i < 2:
            b = wp.mat22d()
        if i < 1:
            a = wp.mat22d()
        a -= b * c2
        scale = inverse(diagonal[rod, i] - b * e2 - a * c1)
        y = scale * (rhs[rod, i] - b * y2 - a * y1)
        c = scale * (upper[rod, i] - a * e1)
        e = scale * upper2[rod, i]
        c2, e2, y2 = c1, e1, y1
        c1, e1, y1 = c, e, y
        work[rod, i] = c
        work2[rod, i] = e
        solution[rod, i] = y
    y2 = solution[rod, nodes - 1]
    y1 = solution[rod, nodes - 2] - work[rod, nodes - 2] * y2
    solution[rod, nodes - 2] = y1
    for i in range(nodes - 3, -1, -1):
        y = solution[rod, i] - work[rod, i] * y1 - work2[rod, i] * y2
        y2 = y1
        y1 = y
        solution[rod, i] = y

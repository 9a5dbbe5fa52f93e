"""Pentadiagonal systems of complex numbers or 2 × 2 blocks, one for each rod, by elimination; see ``banded.py``."""

import warp as wp

from warp_rods.kernels.lanes import Pair, Pairs, add, inverse, none_like, sub, times  # noqa: F401 (operators)
from warp_rods.kernels.layout import Values2D

wp.set_module_options({"enable_backward": False})


@wp.func
def solve_block_pentadiagonal_rod(
    tile: int,
    lower2: Values2D,
    lower: Values2D,
    diagonal: Values2D,
    upper: Values2D,
    upper2: Values2D,
    rhs: Pairs,
    work: Values2D,
    work2: Values2D,
    solution: Pairs,
):
    """Solve the systems of a tile in one thread; at least 2 nodes. Coefficients are all Pairs, or all Blocks.

    Row i becomes x[i] + c x[i+1] + e x[i+2] = y; c is stored in ``work``, e in ``work2``. Suffix 1 marks the row i − 1,
    suffix 2 the row i − 2. ``solution`` may be ``rhs``; the coefficients are not changed.
    """
    nodes = diagonal.shape[1]
    # Each is a value of its own: in Warp a loop that sets one of two names of the same value sets both.
    c2, e2, y2 = none_like(diagonal[tile, 0]), none_like(diagonal[tile, 0]), Pair()
    c1, e1, y1 = none_like(diagonal[tile, 0]), none_like(diagonal[tile, 0]), Pair()
    for i in range(nodes):
        b = lower2[tile, i]
        a = lower[tile, i]
        if i < 2:
            b = none_like(b)
        if i < 1:
            a = none_like(a)
        a -= times(b, c2)
        scale = inverse(diagonal[tile, i] - times(b, e2) - times(a, c1))
        y = times(scale, rhs[tile, i] - times(b, y2) - times(a, y1))
        c = times(scale, upper[tile, i] - times(a, e1))
        e = times(scale, upper2[tile, i])
        c2, e2, y2 = c1, e1, y1
        c1, e1, y1 = c, e, y
        work[tile, i] = c
        work2[tile, i] = e
        solution[tile, i] = y
    y2 = solution[tile, nodes - 1]
    y1 = solution[tile, nodes - 2] - times(work[tile, nodes - 2], y2)
    solution[tile, nodes - 2] = y1
    for i in range(nodes - 3, -1, -1):
        y = solution[tile, i] - times(work[tile, i], y1) - times(work2[tile, i], y2)
        y2 = y1
        y1 = y
        solution[tile, i] = y

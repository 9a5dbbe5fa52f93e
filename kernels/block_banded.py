"""Pentadiagonal systems of 2 × 2 blocks, one for each rod, by elimination without pivoting; see ``banded.py``."""

import warp as wp

from warp_rods.kernels.lanes import Block, Blocks, Pair, Pairs, add, inverse, mul, sub  # noqa: F401 (operators)

wp.set_module_options({"enable_backward": False})


@wp.func
def solve_block_pentadiagonal_rod(
    tile: int,
    lower2: Blocks,
    lower: Blocks,
    diagonal: Blocks,
    upper: Blocks,
    upper2: Blocks,
    rhs: Pairs,
    work: Blocks,
    work2: Blocks,
    solution: Pairs,
):
    """Solve the systems of a tile in one thread; at least 2 nodes.

    Row i becomes x[i] + c x[i+1] + e x[i+2] = y; c is stored in ``work``, e in ``work2``. Suffix 1 marks the row i − 1,
    suffix 2 the row i − 2. ``solution`` may be ``rhs``; the coefficients are not changed.
    """
    nodes = diagonal.shape[1]
    c2, e2, y2 = Block(), Block(), Pair()
    c1, e1, y1 = Block(), Block(), Pair()
    for i in range(nodes):
        b = lower2[tile, i]
        a = lower[tile, i]
        if i < 2:
            b = Block()
        if i < 1:
            a = Block()
        a -= b * c2
        scale = inverse(diagonal[tile, i] - b * e2 - a * c1)
        y = scale * (rhs[tile, i] - b * y2 - a * y1)
        c = scale * (upper[tile, i] - a * e1)
        e = scale * upper2[tile, i]
        c2, e2, y2 = c1, e1, y1
        c1, e1, y1 = c, e, y
        work[tile, i] = c
        work2[tile, i] = e
        solution[tile, i] = y
    y2 = solution[tile, nodes - 1]
    y1 = solution[tile, nodes - 2] - work[tile, nodes - 2] * y2
    solution[tile, nodes - 2] = y1
    for i in range(nodes - 3, -1, -1):
        y = solution[tile, i] - work[tile, i] * y1 - work2[tile, i] * y2
        y2 = y1
        y1 = y
        solution[tile, i] = y

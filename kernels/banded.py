"""Tridiagonal and pentadiagonal systems, one for each rod, solved by elimination without pivoting.

Row ``i`` of rod ``b`` reads, with every coefficient at ``[b, i]``::

    lower2 x[i-2] + lower x[i-1] + diagonal x[i] + upper x[i+1] + upper2 x[i+2] = rhs

A tridiagonal system has no ``lower2`` and ``upper2``. Coefficients that would multiply an ``x`` beyond the ends of the
rod are not read. Right-hand sides and solutions are scalars or pairs (``wp.vec2d``), so that one real matrix serves
both bending components of a rod in space. The same functions solve the systems of a tile of rods side by side, with
coefficients ``Lanes`` and right-hand sides ``Lanes`` or ``Pair`` at ``[tile, i]`` (``lanes.py``).

Without pivoting the solution is as accurate as LAPACK's where the matrix is diagonally dominant or symmetric positive
definite, or becomes so when its rows are scaled; ``1 + Δt ∂⁴`` and ``1 − Δt ∂²`` are. For other matrices round-off
may grow, and this is not checked. A pivot of zero raises no error: the solution of that rod becomes infinite or NaN,
which the ensemble's check of the rod detects. Solutions of other rods are not affected.
"""

import warp as wp

from warp_rods.kernels.lanes import Lanes2D, Pairs, add, div, mul, pair, sub  # noqa: F401 (operators)
from warp_rods.kernels.layout import Pairs2D, Scalars2D, Values2D, real

wp.set_module_options({"enable_backward": False})


@wp.func
def solve_tridiagonal_rod(
    rod: int,
    lower: Values2D,
    diagonal: Values2D,
    upper: Values2D,
    rhs: Values2D,
    work: Values2D,
    solution: Values2D,
):
    """Solve the system of one rod in one thread (Thomas algorithm); at least 1 node.

    All arrays are [rod, node]. ``solution`` may be ``rhs``. ``work`` may be ``upper``, which is then overwritten;
    otherwise the coefficients are not changed.
    """
    nodes = diagonal.shape[1]
    # Row i becomes x[i] + c x[i+1] = y; c is stored in work, y in solution.
    scale = real(1.0) / diagonal[rod, 0]
    c = upper[rod, 0] * scale
    y = rhs[rod, 0] * scale
    work[rod, 0] = c
    solution[rod, 0] = y
    for i in range(1, nodes):
        a = lower[rod, i]
        scale = real(1.0) / (diagonal[rod, i] - a * c)
        c = upper[rod, i] * scale
        y = (rhs[rod, i] - a * y) * scale
        work[rod, i] = c
        solution[rod, i] = y
    for i in range(nodes - 2, -1, -1):
        y = solution[rod, i] - work[rod, i] * y
        solution[rod, i] = y


@wp.func
def eliminate_pentadiagonal(
    rod: int,
    lower2: Values2D,
    lower: Values2D,
    diagonal: Values2D,
    upper: Values2D,
    upper2: Values2D,
    rhs: Values2D,
    work: Values2D,
    solution: Values2D,
):
    """Turn row i into x[i] + c x[i+1] + e x[i+2] = y; (c, e) is stored in ``work``, y in ``solution``.

    Suffix 1 marks the row i − 1, suffix 2 the row i − 2.
    """
    scale = real(1.0) / diagonal[rod, 0]
    c2 = upper[rod, 0] * scale
    e2 = upper2[rod, 0] * scale
    y2 = rhs[rod, 0] * scale
    work[rod, 0] = pair(c2, e2)
    solution[rod, 0] = y2

    a = lower[rod, 1]
    scale = real(1.0) / (diagonal[rod, 1] - a * c2)
    c1 = (upper[rod, 1] - a * e2) * scale
    e1 = upper2[rod, 1] * scale
    y1 = (rhs[rod, 1] - a * y2) * scale
    work[rod, 1] = pair(c1, e1)
    solution[rod, 1] = y1

    for i in range(2, diagonal.shape[1]):
        b = lower2[rod, i]
        a = lower[rod, i] - b * c2
        scale = real(1.0) / (diagonal[rod, i] - b * e2 - a * c1)
        y = (rhs[rod, i] - b * y2 - a * y1) * scale
        c2 = c1
        c1 = (upper[rod, i] - a * e1) * scale
        e2 = e1
        e1 = upper2[rod, i] * scale
        y2 = y1
        y1 = y
        work[rod, i] = pair(c1, e1)
        solution[rod, i] = y


@wp.func
def solve_pentadiagonal_rod(
    rod: int,
    lower2: Values2D,
    lower: Values2D,
    diagonal: Values2D,
    upper: Values2D,
    upper2: Values2D,
    rhs: Values2D,
    work: Values2D,
    solution: Values2D,
):
    """Solve the system of one rod in one thread; at least 2 nodes.

    All arrays are [rod, node]. ``solution`` may be ``rhs``; the coefficients are not changed.
    """
    eliminate_pentadiagonal(rod, lower2, lower, diagonal, upper, upper2, rhs, work, solution)
    nodes = diagonal.shape[1]
    y2 = solution[rod, nodes - 1]
    y1 = solution[rod, nodes - 2] - work[rod, nodes - 2][0] * y2
    solution[rod, nodes - 2] = y1
    for i in range(nodes - 3, -1, -1):
        ce = work[rod, i]
        y = solution[rod, i] - ce[0] * y1 - ce[1] * y2
        y2 = y1
        y1 = y
        solution[rod, i] = y


@wp.kernel
def solve_tridiagonal(
    lower: Values2D, diagonal: Values2D, upper: Values2D, rhs: Values2D, work: Values2D, solution: Values2D
):
    """Solve the system of every rod, or tile; ``dim`` is their number. See ``solve_tridiagonal_rod``."""
    solve_tridiagonal_rod(wp.tid(), lower, diagonal, upper, rhs, work, solution)


@wp.kernel
def solve_pentadiagonal(
    lower2: Values2D,
    lower: Values2D,
    diagonal: Values2D,
    upper: Values2D,
    upper2: Values2D,
    rhs: Values2D,
    work: Values2D,
    solution: Values2D,
):
    """Solve the system of every rod, or tile; ``dim`` is their number. See ``solve_pentadiagonal_rod``."""
    solve_pentadiagonal_rod(wp.tid(), lower2, lower, diagonal, upper, upper2, rhs, work, solution)


# All types are declared here, so that loading the module compiles them and no launch compiles anything.
for _numbers, _pairs in ((Scalars2D, Pairs2D), (Lanes2D, Pairs)):
    for _values in (_numbers, _pairs):
        wp.overload(solve_tridiagonal, [*[_numbers] * 3, _values, _numbers, _values])
        wp.overload(solve_pentadiagonal, [*[_numbers] * 5, _values, _pairs, _values])

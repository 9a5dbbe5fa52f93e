"""Tridiagonal and pentadiagonal systems, one a rod, solved by elimination without pivoting.

Row ``i`` of rod ``b`` reads, with every coefficient at ``[b, i]``::

    lower2 x[i-2] + lower x[i-1] + diagonal x[i] + upper x[i+1] + upper2 x[i+2] = right

(the tridiagonal one lacks ``lower2`` and ``upper2``). Coefficients that would multiply an ``x`` off the rod
are ignored, whatever they hold. Right-hand sides and solutions are numbers or pairs (``wp.vec2d``), so that
one real matrix serves both bending components of a rod in space.

Without pivoting the answer is as good as LAPACK's where the matrix is diagonally dominant or symmetric
positive definite, or becomes so when its rows are scaled; ``1 + Δt ∂⁴`` and ``1 − Δt ∂²`` are. Elsewhere
growing round-off is possible and is not looked for. A pivot that vanishes raises nothing: the rod's solution
turns infinite or NaN, which the health check of its ensemble sees; other rods' solutions are untouched.
"""

from typing import Any

import warp as wp

from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})

numbers = wp.array2d(dtype=real)
pairs = wp.array2d(dtype=wp.vec2d)
either = wp.array2d(dtype=Any)


@wp.func
def solve_tridiagonal_rod(
    rod: int,
    lower: numbers,
    diagonal: numbers,
    upper: numbers,
    right: either,
    work: numbers,
    solution: either,
):
    """Solve the system of one rod (Thomas) from one thread; nodes >= 1.

    All arrays are [rod, node]. ``solution`` may be ``right``, and ``work`` may be ``upper``, which it then
    destroys; coefficients are otherwise left as they are.
    """
    nodes = diagonal.shape[1]
    # Row i becomes x[i] + c x[i+1] = y: c goes to work, y to solution.
    scale = real(1.0) / diagonal[rod, 0]
    c = upper[rod, 0] * scale
    y = right[rod, 0] * scale
    work[rod, 0] = c
    solution[rod, 0] = y
    for i in range(1, nodes):
        a = lower[rod, i]
        scale = real(1.0) / (diagonal[rod, i] - a * c)
        c = upper[rod, i] * scale
        y = (right[rod, i] - a * y) * scale
        work[rod, i] = c
        solution[rod, i] = y
    for i in range(nodes - 2, -1, -1):
        y = solution[rod, i] - work[rod, i] * y
        solution[rod, i] = y


@wp.func
def solve_pentadiagonal_rod(
    rod: int,
    lower2: numbers,
    lower: numbers,
    diagonal: numbers,
    upper: numbers,
    upper2: numbers,
    right: either,
    work: pairs,
    solution: either,
):
    """Solve the system of one rod from one thread; nodes >= 2.

    All arrays are [rod, node]. ``solution`` may be ``right``; coefficients are left as they are.
    """
    nodes = diagonal.shape[1]
    # Row i becomes x[i] + c x[i+1] + e x[i+2] = y: (c, e) goes to work, y to solution.
    # Suffixes: 1 is the row before, 2 the one before that.
    scale = real(1.0) / diagonal[rod, 0]
    c2 = upper[rod, 0] * scale
    e2 = upper2[rod, 0] * scale
    y2 = right[rod, 0] * scale
    work[rod, 0] = wp.vec2d(c2, e2)
    solution[rod, 0] = y2

    a = lower[rod, 1]
    scale = real(1.0) / (diagonal[rod, 1] - a * c2)
    c1 = (upper[rod, 1] - a * e2) * scale
    e1 = upper2[rod, 1] * scale
    y1 = (right[rod, 1] - a * y2) * scale
    work[rod, 1] = wp.vec2d(c1, e1)
    solution[rod, 1] = y1

    for i in range(2, nodes):
        b = lower2[rod, i]
        a = lower[rod, i] - b * c2
        scale = real(1.0) / (diagonal[rod, i] - b * e2 - a * c1)
        y = (right[rod, i] - b * y2 - a * y1) * scale
        c2 = c1
        c1 = (upper[rod, i] - a * e1) * scale
        e2 = e1
        e1 = upper2[rod, i] * scale
        y2 = y1
        y1 = y
        work[rod, i] = wp.vec2d(c1, e1)
        solution[rod, i] = y

    y2 = y1
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
    lower: numbers,
    diagonal: numbers,
    upper: numbers,
    right: either,
    work: numbers,
    solution: either,
):
    """Solve every rod's tridiagonal system; launch with ``dim = rods``. See ``solve_tridiagonal_rod``."""
    solve_tridiagonal_rod(wp.tid(), lower, diagonal, upper, right, work, solution)


@wp.kernel
def solve_pentadiagonal(
    lower2: numbers,
    lower: numbers,
    diagonal: numbers,
    upper: numbers,
    upper2: numbers,
    right: either,
    work: pairs,
    solution: either,
):
    """Solve every rod's pentadiagonal system; launch with ``dim = rods``. See ``solve_pentadiagonal_rod``."""
    solve_pentadiagonal_rod(wp.tid(), lower2, lower, diagonal, upper, upper2, right, work, solution)


# Declared here so that loading the module once compiles both: no launch compiles anything.
for _right in (numbers, pairs):
    wp.overload(solve_tridiagonal, {"right": _right, "solution": _right})
    wp.overload(solve_pentadiagonal, {"right": _right, "solution": _right})

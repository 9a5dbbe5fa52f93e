"""Pentadiagonal systems of complex numbers, one for each rod, by elimination without pivoting; see ``banded.py``."""

import warp as wp

from warp_rods.kernels.layout import Pairs2D, Quadruples2D, real

wp.set_module_options({"enable_backward": False})


@wp.func
def times(a: wp.vec2d, b: wp.vec2d):
    """The product of complex numbers that are stored as pairs."""
    return wp.vec2d(a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0])


@wp.func
def inverse(a: wp.vec2d):
    """1/a."""
    scale = real(1.0) / wp.dot(a, a)
    return wp.vec2d(scale * a[0], -scale * a[1])


@wp.func
def solve_complex_pentadiagonal_rod(
    rod: int,
    lower2: Pairs2D,
    lower: Pairs2D,
    diagonal: Pairs2D,
    upper: Pairs2D,
    upper2: Pairs2D,
    rhs: Pairs2D,
    work: Quadruples2D,
    solution: Pairs2D,
):
    """Solve the system of one rod in one thread; at least 2 nodes.

    Row i becomes x[i] + c x[i+1] + e x[i+2] = y; (c, e) is stored in ``work``, y in ``solution``. Suffix 1 marks the
    row i − 1, suffix 2 the row i − 2. ``solution`` may be ``rhs``; the coefficients are not changed.
    """
    nodes = diagonal.shape[1]
    c2, e2, y2 = wp.vec2d(), wp.vec2d(), wp.vec2d()
    c1, e1, y1 = wp.vec2d(), wp.vec2d(), wp.vec2d()
    for i in range(nodes):
        b = lower2[rod, i]
        a = lower[rod, i]
        if i < 2:
            b = wp.vec2d()
        if i < 1:
            a = wp.vec2d()
        a -= times(b, c2)
        scale = inverse(diagonal[rod, i] - times(b, e2) - times(a, c1))
        y = times(rhs[rod, i] - times(b, y2) - times(a, y1), scale)
        c = times(upper[rod, i] - times(a, e1), scale)
        e = times(upper2[rod, i], scale)
        c2, e2, y2 = c1, e1, y1
        c1, e1, y1 = c, e, y
        work[rod, i] = wp.vec4d(c[0], c[1], e[0], e[1])
        solution[rod, i] = y
    y2 = solution[rod, nodes - 1]
    ce = work[rod, nodes - 2]
    y1 = solution[rod, nodes - 2] - times(wp.vec2d(ce[0], ce[1]), y2)
    solution[rod, nodes - 2] = y1
    for i in range(nodes - 3, -1, -1):
        ce = work[rod, i]
        y = solution[rod, i] - times(wp.vec2d(ce[0], ce[1]), y1) - times(wp.vec2d(ce[2], ce[3]), y2)
        y2 = y1
        y1 = y
        solution[rod, i] = y

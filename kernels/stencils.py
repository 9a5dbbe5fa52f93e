"""Derivatives and integrals along a rod, second order in the node spacing, ends included.

Every function takes an array ``f`` [rod, node] of scalars or vectors, the number of a rod, and where needed the number
of a node and the spacing ``h`` of the nodes. Differences are formed before they are weighted, so that the derivative of
a constant is exactly zero.
"""

from typing import Any

import warp as wp

from warp_rods.kernels.lanes import add, div, mul, sub  # noqa: F401 (operators)
from warp_rods.kernels.layout import Values2D, real

wp.set_module_options({"enable_backward": False})


@wp.func
def derivative(f: Values2D, rod: int, i: int, h: Any):
    """``f'`` at node ``i``: central at inner nodes, three points at the ends; at least 3 nodes."""
    last = f.shape[1] - 1
    # The three-point formula at an end, with nodes counted inwards: 2 h f' = 4 (f1 − f0) − (f2 − f0).
    inwards = 1
    if i == last:
        inwards = -1
    if i == 0 or i == last:
        near = f[rod, i + inwards] - f[rod, i]
        far = f[rod, i + 2 * inwards] - f[rod, i]
        return (real(4.0) * near - far) / (real(2 * inwards) * h)
    return (f[rod, i + 1] - f[rod, i - 1]) / (real(2.0) * h)


@wp.func
def second_difference(f: Values2D, rod: int, i: int):
    """``f[i-1] − 2 f[i] + f[i+1]`` at an inner node."""
    return (f[rod, i + 1] - f[rod, i]) - (f[rod, i] - f[rod, i - 1])


@wp.func
def second_derivative(f: Values2D, rod: int, i: int, h: Any):
    """``f''`` at node ``i``: central at inner nodes, four points at the ends; at least 4 nodes."""
    last = f.shape[1] - 1
    # At an end: linear extrapolation of the second differences at the next two nodes.
    inwards = 1
    if i == last:
        inwards = -1
    if i == 0 or i == last:
        near = second_difference(f, rod, i + inwards)
        far = second_difference(f, rod, i + 2 * inwards)
        return (real(2.0) * near - far) / (h * h)
    return second_difference(f, rod, i) / (h * h)


@wp.func
def second_derivative_at_start(f: Values2D, rod: int, slope: Any, h: Any):
    """``f''`` at the first node where ``f'`` is known to be ``slope``, by a mirror node beyond the end.

    The formula is of first order; a scheme that uses it as a boundary condition is still of second order.
    """
    return real(2.0) * (f[rod, 1] - f[rod, 0] - h * slope) / (h * h)


@wp.func
def second_derivative_at_end(f: Values2D, rod: int, slope: Any, h: Any):
    """``f''`` at the last node where ``f'`` is known to be ``slope``; see ``second_derivative_at_start``."""
    last = f.shape[1] - 1
    return real(2.0) * (f[rod, last - 1] - f[rod, last] + h * slope) / (h * h)


@wp.func
def half_difference(f: Values2D, rod: int, i: int, h: Any):
    """``f'`` at the half node between nodes ``i`` and ``i + 1``."""
    return (f[rod, i + 1] - f[rod, i]) / h


@wp.func
def half_average(f: Values2D, rod: int, i: int):
    """``f`` at the half node between nodes ``i`` and ``i + 1``."""
    return real(0.5) * (f[rod, i] + f[rod, i + 1])


@wp.func
def trapezoid_weight(i: int, nodes: int, h: Any):
    """The weight of node ``i`` in the trapezoid rule: ``h``, and ``h/2`` at the ends."""
    if i == 0 or i == nodes - 1:
        return real(0.5) * h
    return h


@wp.func
def integral(f: Values2D, rod: int, h: Any):
    """``∫ f ds`` over the rod by the trapezoid rule, summed from the first node to the last."""
    last = f.shape[1] - 1
    total = real(0.5) * (f[rod, 0] + f[rod, last])
    for i in range(1, last):
        total += f[rod, i]
    return h * total

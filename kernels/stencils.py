"""Derivatives and integrals along a rod, second order in the node spacing, ends included.

Every function takes an array ``f`` [rod, node] of numbers or vectors, a rod, and where needed a node and the
spacing ``h`` of the nodes. Differences are taken before they are weighted, so that the derivative of a
constant is exactly zero.
"""

from typing import Any

import warp as wp

from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})

field = wp.array2d(dtype=Any)


@wp.func
def derivative(f: field, rod: int, i: int, h: real):
    """``f'`` at node ``i``: central inside, three points at the ends; nodes >= 3."""
    last = f.shape[1] - 1
    # The three-point formula at an end, walked inwards: 2 h f' = 4 (f1 − f0) − (f2 − f0).
    inwards = 1
    if i == last:
        inwards = -1
    if i == 0 or i == last:
        near = f[rod, i + inwards] - f[rod, i]
        far = f[rod, i + 2 * inwards] - f[rod, i]
        return (real(4.0) * near - far) / (real(2 * inwards) * h)
    return (f[rod, i + 1] - f[rod, i - 1]) / (real(2.0) * h)


@wp.func
def second_difference(f: field, rod: int, i: int):
    """``f[i-1] − 2 f[i] + f[i+1]`` at an inner node."""
    return (f[rod, i + 1] - f[rod, i]) - (f[rod, i] - f[rod, i - 1])


@wp.func
def second_derivative(f: field, rod: int, i: int, h: real):
    """``f''`` at node ``i``: central inside, four points at the ends; nodes >= 4."""
    last = f.shape[1] - 1
    # At an end, the second differences of the first two inner nodes are extrapolated to it.
    inwards = 1
    if i == last:
        inwards = -1
    if i == 0 or i == last:
        near = second_difference(f, rod, i + inwards)
        far = second_difference(f, rod, i + 2 * inwards)
        return (real(2.0) * near - far) / (h * h)
    return second_difference(f, rod, i) / (h * h)


@wp.func
def second_derivative_at_start(f: field, rod: int, slope: Any, h: real):
    """``f''`` at the first node where ``f'`` is known to be ``slope``: a mirror node beyond the end.

    Its own error is of first order; a scheme that uses it as a boundary condition keeps second order.
    """
    return real(2.0) * (f[rod, 1] - f[rod, 0] - h * slope) / (h * h)


@wp.func
def second_derivative_at_end(f: field, rod: int, slope: Any, h: real):
    """``f''`` at the last node where ``f'`` is known to be ``slope``; as ``second_derivative_at_start``."""
    last = f.shape[1] - 1
    return real(2.0) * (f[rod, last - 1] - f[rod, last] + h * slope) / (h * h)


@wp.func
def half_difference(f: field, rod: int, i: int, h: real):
    """``f'`` at the half node between nodes ``i`` and ``i + 1``."""
    return (f[rod, i + 1] - f[rod, i]) / h


@wp.func
def half_average(f: field, rod: int, i: int):
    """``f`` at the half node between nodes ``i`` and ``i + 1``."""
    return real(0.5) * (f[rod, i] + f[rod, i + 1])


@wp.func
def trapezoid_weight(i: int, nodes: int, h: real):
    """The length that node ``i`` stands for: ``h``, and half of it at the ends."""
    if i == 0 or i == nodes - 1:
        return real(0.5) * h
    return h


@wp.func
def integral(f: field, rod: int, h: real):
    """``∫ f ds`` over the rod by the trapezoid rule; the nodes are summed from start to end."""
    last = f.shape[1] - 1
    total = real(0.5) * (f[rod, 0] + f[rod, last])
    for i in range(1, last):
        total += f[rod, i]
    return h * total

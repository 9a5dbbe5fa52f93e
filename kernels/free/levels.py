"""Sums over the levels of a tile of rods, from which values, slopes and errors of a step follow."""

from typing import Any

import warp as wp

from warp_rods.kernels.free.state import Past, Shape
from warp_rods.kernels.lanes import add, any_of, mul, sub  # noqa: F401 (operators)
from warp_rods.kernels.multistep import Weights

wp.set_module_options({"enable_backward": False})


@wp.func
def levels_in(w: Weights) -> int:
    """How many levels have a weight for any rod; those after them need not be read."""
    levels = 1
    for j in range(1, 5):
        if any_of(w[j]):
            levels = j + 1
    return levels


@wp.func
def sum_differences(
    tile: int, node: int, w: Weights, levels: int, now: Any, first: Any, second: Any, third: Any, fourth: Any
):
    """Σ w_j (x_j − x_0) of one field, which is exactly zero for a field that does not change."""
    x = now[tile, node]
    total = w[1] * (first[tile, node] - x)
    if levels > 2:
        total += w[2] * (second[tile, node] - x)
    if levels > 3:
        total += w[3] * (third[tile, node] - x)
    if levels > 4:
        total += w[4] * (fourth[tile, node] - x)
    return total


@wp.func
def differences(tile: int, node: int, w: Weights, levels: int, now: Shape, past: Past):
    """Σ w_j (x_j − x_0) of k, τ and f, newest first."""
    k = sum_differences(
        tile,
        node,
        w,
        levels,
        now.bending,
        past.first.bending,
        past.second.bending,
        past.third.bending,
        past.fourth.bending,
    )
    tau = sum_differences(
        tile, node, w, levels, now.twist, past.first.twist, past.second.twist, past.third.twist, past.fourth.twist
    )
    f = sum_differences(
        tile,
        node,
        w,
        levels,
        now.activity,
        past.first.activity,
        past.second.activity,
        past.third.activity,
        past.fourth.activity,
    )
    return k, tau, f

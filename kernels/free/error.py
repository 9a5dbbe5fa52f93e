"""The distance of a new shape from an extrapolation, from which the error of a step is estimated."""

import warp as wp

from warp_rods.kernels.free.levels import differences, levels_in
from warp_rods.kernels.free.state import Past, Shape
from warp_rods.kernels.lanes import Lanes, add, div, dot, larger, mul, sqrt, sub  # noqa: F401 (operators)
from warp_rods.kernels.layout import real
from warp_rods.kernels.multistep import Weights

wp.set_module_options({"enable_backward": False})


@wp.func
def error_of(tile: int, w: Weights, now: Shape, past: Past, star: Shape):
    """Root mean square of x − Σ w_j x_j over the nodes: of the strains over 1 + their own, or of f if larger."""
    strain, distance, activity = Lanes(), Lanes(), Lanes()
    nodes = now.twist.shape[1]
    levels = levels_in(w)
    for node in range(nodes):
        k = star.bending[tile, node]
        tau = star.twist[tile, node]
        sum_k, sum_tau, sum_f = differences(tile, node, w, levels, now, past)
        dk = (k - now.bending[tile, node]) - sum_k
        dtau = (tau - now.twist[tile, node]) - sum_tau
        df = (star.activity[tile, node] - now.activity[tile, node]) - sum_f
        strain += dot(k, k) + tau * tau
        distance += dot(dk, dk) + dtau * dtau
        activity += df * df
    count = real(nodes)
    relative = sqrt(distance / count) / (real(1.0) + sqrt(strain / count))
    return larger(relative, sqrt(activity / count))

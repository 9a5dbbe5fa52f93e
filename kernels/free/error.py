"""The distance of a new shape from an extrapolation, from which the error of a step is estimated."""

import warp as wp

from warp_rods.kernels.free.state import Past, Shape
from warp_rods.kernels.layout import real
from warp_rods.kernels.multistep import Levels, combine

wp.set_module_options({"enable_backward": False})


@wp.func
def error_of(rod: int, w: Levels, now: Shape, past: Past, star: Shape):
    """Root mean square of x − Σ w_j x_j over the nodes: of the strains over 1 + their own, or of f if larger."""
    strain, distance, activity = real(0.0), real(0.0), real(0.0)
    nodes = now.twist.shape[1]
    for node in range(nodes):
        k = star.bending[rod, node]
        tau = star.twist[rod, node]
        dk = k - combine(
            w,
            now.bending[rod, node],
            past.first.bending[rod, node],
            past.second.bending[rod, node],
            past.third.bending[rod, node],
            past.fourth.bending[rod, node],
        )
        dtau = tau - combine(
            w,
            now.twist[rod, node],
            past.first.twist[rod, node],
            past.second.twist[rod, node],
            past.third.twist[rod, node],
            past.fourth.twist[rod, node],
        )
        df = star.activity[rod, node] - combine(
            w,
            now.activity[rod, node],
            past.first.activity[rod, node],
            past.second.activity[rod, node],
            past.third.activity[rod, node],
            past.fourth.activity[rod, node],
        )
        strain += wp.dot(k, k) + tau * tau
        distance += wp.dot(dk, dk) + dtau * dtau
        activity += df * df
    count = real(nodes)
    relative = wp.sqrt(distance / count) / (real(1.0) + wp.sqrt(strain / count))
    return wp.max(relative, wp.sqrt(activity / count))

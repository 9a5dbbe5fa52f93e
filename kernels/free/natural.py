"""The natural bending of active rods in their Bishop frame (docs/model.md §2.11)."""

import warp as wp

from warp_rods.kernels.free.state import Balance, Shape, Swimmers
from warp_rods.kernels.lanes import WIDTH, Lanes, add, mul, rods_in, sub, times  # noqa: F401 (operators)
from warp_rods.kernels.layout import Scalars1D, real
from warp_rods.kernels.surface.trigonometry import turn

wp.set_module_options({"enable_backward": False})


@wp.func
def find_rest(tile: int, rods: Swimmers, shape: Shape, angle: Scalars1D, balance: Balance):
    """``k0 exp(iϑ)``: the material frame is turned by ``ϑ``, ``angle`` + ∫τ from the tracked node."""
    at_tracked = Lanes()
    for lane in range(rods_in(tile, angle.shape[0])):
        at_tracked[lane] = angle[tile * WIDTH + lane]
    nodes = shape.twist.shape[1]
    half = real(0.5) * rods.spacing
    theta = real(1.0) * at_tracked  # a value of its own: the loop changes it
    balance.rest[tile, rods.tracked] = times(rods.natural_bending[tile, rods.tracked], turn(theta))
    for node in range(rods.tracked + 1, nodes):
        theta += half * (shape.twist[tile, node - 1] + shape.twist[tile, node])
        balance.rest[tile, node] = times(rods.natural_bending[tile, node], turn(theta))
    back = Lanes()
    for count in range(rods.tracked):
        node = rods.tracked - 1 - count
        back += half * (shape.twist[tile, node] + shape.twist[tile, node + 1])
        balance.rest[tile, node] = times(rods.natural_bending[tile, node], turn(at_tracked - back))

"""A flow, and forces and couples per length from outside, on surface-bound filaments (docs/model.md §3.11).

Drag acts on the velocity against the fluid, so that a flow u∞ is a force ζ u∞ and a couple ζr ½∇×u∞ about the tangent.
With a couple (c0, c1, c2) per length in the frame (q, n×q, n) virtual work gives::

    Y1 += K12 c0 − K11 c1 + Ω c2,   Y2 += K22 c0 − K12 c1 − c2',   λ2 −= c2,   λ3 += c1,   χ += c0
"""

import warp as wp

from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.lanes import (  # noqa: F401 (operators)
    Lanes,
    Vector,
    Vectors,
    add,
    by_component,
    dot,
    load,
    mul,
    sub,
    vector,
)
from warp_rods.kernels.layout import Vectors2D, real
from warp_rods.kernels.stencils import half_average

wp.set_module_options({"enable_backward": False})


@wp.func
def in_frame(f: Filaments, values: Vectors2D, tile: int, i: int) -> Vector:
    """A vector in space [rod, node] in the frame of node i."""
    v = load(values, tile, i)
    return vector(dot(f.tangent[tile, i], v), dot(f.across[tile, i], v), dot(f.normal[tile, i], v))


@wp.func
def add_outside(f: Filaments, tile: int):
    """Add forces to the load of the nodes, and find couples and flow in their frames."""
    for i in range(f.geodesic.shape[1]):
        zeta = f.drag[tile, i]
        drag = vector(zeta[0], zeta[1], zeta[1])
        F, C, w, roll = f.load[tile, i], Vector(), Vector(), Lanes()
        if f.outside.flowing == 1:
            w = in_frame(f, f.outside.velocity, tile, i)
            roll = in_frame(f, f.outside.spin, tile, i)[0]
            F += by_component(drag, w)
            C = vector(zeta[2] * roll, Lanes(), Lanes())
        if f.outside.pushing == 1:
            F += in_frame(f, f.outside.force, tile, i)
        if f.outside.turning == 1:
            C += in_frame(f, f.outside.couple, tile, i)
        f.load[tile, i] = F
        f.couple[tile, i] = C
        f.stream[tile, i] = w
        f.stream_roll[tile, i] = roll


@wp.func
def couple_at(f: Filaments, tile: int, i: int) -> Vector:
    """(c0, c1, c2) at a node."""
    if f.exposed == 0:
        return Vector()
    return f.couple[tile, i]


@wp.func
def couple_along(f: Filaments, tile: int, i: int) -> Lanes:
    """K12 c0 − K11 c1 + Ω c2 at i + ½, the part of a couple in Y1."""
    if f.exposed == 0:
        return Lanes()
    K, c = half_average(f.curvature, tile, i), half_average(f.couple, tile, i)
    return K[1] * c[0] - K[0] * c[1] + half_average(f.geodesic, tile, i) * c[2]


@wp.func
def couple_across(f: Filaments, tile: int, i: int) -> Lanes:
    """K22 c0 − K12 c1 at a node, the part of a couple in Y2 besides −c2', which is in the shear term."""
    if f.exposed == 0:
        return Lanes()
    K, c = f.curvature[tile, i], f.couple[tile, i]
    return K[2] * c[0] - K[1] * c[1]


@wp.func
def surplus_density(f: Filaments, tile: int, i: int, u: Vector, roll_rate: Lanes) -> Lanes:
    """ζ|u − w|² − ζ|u|² in a flow w, roll included, which is in the dissipation and in the power."""
    if f.exposed == 0:
        return Lanes()
    zeta, w, roll = f.drag[tile, i], f.stream[tile, i], f.stream_roll[tile, i]
    drag = by_component(vector(zeta[0], zeta[1], zeta[1]), w)
    return dot(drag, w - real(2.0) * u) + zeta[2] * roll * (roll - real(2.0) * roll_rate)

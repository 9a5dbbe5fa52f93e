"""The device arrays of an ensemble of surface-bound filaments, in the structs that its kernels take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.bound.step import Growth, History
from warp_rods.kernels.layout import one_zero, per_node, per_rod
from warp_rods.rods.views import of_struct

VECTORS = ("curvature", "position", "force", "moment")
SCALARS = (
    *("geodesic", "shear", "transverse_force", "to_left", "to_right", "remainder"),
    *("tension", "along", "across", "rate"),
)
PER_ROD = ("energy", "dissipation", "growth_power", "membrane_power", "force_power", "gauss")


@dataclass
class Arrays:
    """Arrays of ``rods`` × ``nodes``: parameters and state, history, growth, room for the solves, what is measured."""

    f: Any  # Filaments
    past: Any  # History
    growth: Any  # Growth
    bands: list[wp.array]
    right: wp.array
    work: wp.array
    work_pair: wp.array
    shear3: wp.array
    out: dict[str, wp.array]


def allocate(
    parameters: Mapping[str, np.ndarray], nodes: int, clamped: tuple[bool, bool], knots: Any, moving: bool, device
) -> Arrays:
    """Arrays for filaments with these ``parameters`` {length: [rod], stiffness, intrinsic, drag: [rod, 3]}.

    ``knots`` (time, length), each [rod, knot]: length against time. ``moving``: whether the membrane does. All else
    is zero.
    """
    count = len(parameters["length"])
    shape = (count, nodes)
    f, past, growth = Filaments(), History(), Growth()
    f.spacing = wp.array(parameters["length"] / (nodes - 1), dtype=wp.float64, device=device)
    for name in ("stiffness", "intrinsic", "drag"):
        setattr(f, name, wp.array(parameters[name], dtype=wp.vec3d, device=device))
    f.start_clamped, f.end_clamped = map(int, clamped)
    f.anchor = anchor(nodes, clamped)
    f.growth_rate = per_rod(count, wp.float64, device)
    f.status = per_rod(count, wp.int32, device)
    f.rotation = per_node(*shape, wp.mat33d, device)
    for name in VECTORS:
        setattr(f, name, per_node(*shape, wp.vec3d, device))
    for name in SCALARS:
        setattr(f, name, per_node(*shape, wp.float64, device))
    f.moving = int(moving)
    for name in ("normal_velocity", "normal_velocity_slope"):
        setattr(f, name, (per_node if moving else one_zero)(*shape, wp.float64, device))
    past.spin, past.velocity = per_rod(count, wp.vec3d, device), per_rod(count, wp.vec3d, device)
    past.failed_at = per_rod(count, wp.float64, device)
    for name in ("geodesic", "rate", "increment"):
        setattr(past, name, per_node(*shape, wp.float64, device))
    growth.time, growth.length = (wp.array(k, dtype=wp.float64, device=device) for k in knots)
    return Arrays(
        f=f,
        past=past,
        growth=growth,
        bands=[per_node(*shape, wp.float64, device) for _ in range(5)],
        right=per_node(*shape, wp.float64, device),
        work=per_node(*shape, wp.float64, device),
        work_pair=per_node(*shape, wp.vec2d, device),
        shear3=per_node(*shape, wp.float64, device),
        out={
            **{name: per_rod(count, wp.float64, device) for name in PER_ROD},
            "residuals": per_rod(count, wp.vec3d, device),
            "energy_density": per_node(*shape, wp.float64, device),
            "load": per_node(*shape, wp.vec3d, device),
            "load_moment": per_node(*shape, wp.float64, device),
            "orientation": per_node(*shape, wp.quatd, device),
        },
    )


def part(arrays: Arrays, rods: slice) -> Arrays:
    """The arrays of some of the rods, as views."""
    a = arrays
    return Arrays(
        f=of_struct(Filaments, a.f, rods),
        past=of_struct(History, a.past, rods),
        growth=of_struct(Growth, a.growth, rods),
        bands=[band[rods] for band in a.bands],
        right=a.right[rods],
        work=a.work[rods],
        work_pair=a.work_pair[rods],
        shear3=a.shear3[rods],
        out={name: array[rods] for name, array in a.out.items()},
    )


def anchor(nodes: int, clamped: tuple[bool, bool]) -> int:
    """The node whose frame the others follow: a clamped end, else the middle."""
    if clamped[0]:
        return 0
    return nodes - 1 if clamped[1] else nodes // 2

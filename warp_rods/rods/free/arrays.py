"""The device arrays of an ensemble of free rods, in the structs that its kernels take."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import warp as wp

from warp_rods.kernels.free.output import Measures
from warp_rods.kernels.free.state import Flow, Load, Midpoint, Shape, Swimmers
from warp_rods.kernels.layout import one_zero, per_node, per_rod, scratch

PAIRS = ("bending", "pull", "transverse", "spin", "right_pair", "work_pair", "bending_rate")
PARAMETERS = ("bend", "twist", "moment", "drag_ratio", "rotational_drag", "relaxation", "diffusion")
WORKSPACE = (
    "push", "pull", "tension", "axial", "transverse", "spin", "wound", "bishop_spin", "lower2", "lower",
    "diagonal", "upper", "upper2", "right", "right_pair", "work", "work_pair",
)  # fmt: skip


@dataclass
class Arrays:
    """Arrays of ``rods`` × ``nodes``: state, its last change, and what is derived for output."""

    rods: Any
    now: Any
    change: Any
    midpoint: Any
    clock: wp.array
    failed_at: wp.array
    load: Any
    star: Any
    scratch: Any
    flow: Any
    measures: Any
    position: wp.array
    rotation: wp.array
    bishop_strain: wp.array
    strain: wp.array
    orientation: wp.array
    spacing: wp.array
    force: wp.array | None = None


def allocate(parameters: dict[str, np.ndarray], nodes: int, law: int, symmetric: bool, device: Any) -> Arrays:
    """Arrays for rods with these ``parameters`` {name: [rod]}: all zero but the parameters."""
    count = len(parameters["bend"])
    shape = (count, nodes)
    rods = Swimmers()
    for name in PARAMETERS:
        setattr(rods, name, wp.array(parameters[name], dtype=wp.float64, device=device))
    rods.law = wp.full(count, law, dtype=wp.int32, device=device)
    rods.status = per_rod(count, wp.int32, device)
    rods.spacing = 1.0 / (nodes - 1)
    rods.symmetric = int(symmetric)
    load = Load()
    load.now = load.before = one_zero(*shape, wp.vec3d, device)
    return Arrays(
        rods=rods,
        now=_shape(per_node, *shape, device),
        change=_shape(per_node, *shape, device),
        midpoint=_midpoint(count, device),
        clock=per_rod(3, device=device),
        failed_at=per_rod(count, device=device),
        load=load,
        star=_shape(scratch, *shape, device),
        scratch=_flow(scratch, *shape, scratch(*shape, wp.vec3d, device), device),
        flow=_flow(per_node, *shape, load.now, device),
        measures=_measures(*shape, device),
        position=per_node(*shape, wp.vec3d, device),
        rotation=per_node(*shape, wp.mat33d, device),
        bishop_strain=per_node(*shape, wp.vec3d, device),
        strain=per_node(*shape, wp.vec3d, device),
        orientation=per_node(*shape, wp.quatd, device),
        spacing=wp.full(count, 1.0 / (nodes - 1), dtype=wp.float64, device=device),
    )


def part(arrays: Arrays, rods: slice) -> Arrays:
    """The arrays of some of the rods, as views; with room of their own for what no rod keeps."""
    count, nodes = arrays.position[rods].shape
    device = arrays.position.device
    shared = {"clock": arrays.clock, "star": _shape(scratch, count, nodes, device)}
    shared["scratch"] = _flow(scratch, count, nodes, scratch(count, nodes, wp.vec3d, device), device)
    views = {f.name: _view(getattr(arrays, f.name), rods) for f in fields(Arrays) if f.name not in shared}
    return Arrays(**shared, **views)


def _view(value: Any, rods: slice) -> Any:
    """Some rods of an array, or of the arrays of a struct; what has no rods stays."""
    if isinstance(value, wp.array):
        return value[rods]
    if not hasattr(value, "_cls"):
        return value
    struct = value._cls()
    for name in value._cls.vars:
        setattr(struct, name, _view(getattr(value, name), rods))
    return struct


def _shape(make: Any, rods: int, nodes: int, device: Any) -> Any:
    shape = Shape()
    for name in ("bending", "twist", "activity"):
        setattr(shape, name, make(rods, nodes, _dtype(name), device))
    return shape


def _flow(make: Any, rods: int, nodes: int, force: wp.array, device: Any) -> Any:
    flow = Flow()
    flow.force = force
    for name in WORKSPACE:
        setattr(flow, name, make(rods, nodes, _dtype(name), device))
    return flow


def _measures(rods: int, nodes: int, device: Any) -> Any:
    measures = Measures()
    for name in ("bending_rate", "twist_rate", "activity_rate", "energy_density"):
        setattr(measures, name, per_node(rods, nodes, _dtype(name), device))
    for name in ("energy", "dissipation", "power"):
        setattr(measures, name, per_rod(rods, device=device))
    return measures


def _midpoint(rods: int, device: Any) -> Any:
    midpoint = Midpoint()
    midpoint.rotation = per_rod(rods, wp.mat33d, device)
    for name in ("position", "spin", "velocity"):
        setattr(midpoint, name, per_rod(rods, wp.vec3d, device))
    for name in ("angle", "roll"):
        setattr(midpoint, name, per_rod(rods, device=device))
    return midpoint


def _dtype(name: str) -> Any:
    return wp.vec2d if name in PAIRS else wp.float64

"""The device arrays of an ensemble of free rods, in the structs that its kernels take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warp_rods.kernels.free.output import Measures
from warp_rods.kernels.free.state import AppliedForce, Flow, Midpoint, Shape, Swimmers
from warp_rods.kernels.layout import one_zero, per_node, per_rod, scratch
from warp_rods.rods.views import of_array, of_struct

PARAMETERS = {
    "bend": "bending_stiffness",
    "twist": "twist_stiffness",
    "moment": "moment",
    "drag_ratio": "drag_ratio",
    "rotational_drag": "rotational_drag",
    "relaxation": "relaxation",
    "diffusion": "diffusion",
}
"""Parameters of a rod by their names in a scene → those in the kernels."""
PAIRS = ("bending", "transverse_source", "transverse", "spin", "right_pair", "work_pair", "bending_rate")
WORKSPACE = (
    *("axial_source", "transverse_source", "tension", "axial", "transverse", "spin", "twist_source", "bishop_spin"),
    *("lower2", "lower", "diagonal", "upper", "upper2", "right", "right_pair", "work", "work_pair"),
)


@dataclass
class Arrays:
    """Arrays of ``rods`` × ``nodes``: parameters, state, its last change, and what is derived for output."""

    rods: Any  # Swimmers
    now: Any  # Shape
    change: Any  # Shape: the last step's
    midpoint: Any  # Midpoint
    failed_at: wp.array
    applied: Any  # AppliedForce
    star: Any  # Shape: extrapolated, scratch
    scratch: Any  # Flow of a step
    flow: Any  # Flow that is measured
    measures: Any  # Measures
    position: wp.array
    rotation: wp.array
    bishop_strain: wp.array
    strain: wp.array
    orientation: wp.array
    spacing: wp.array
    force: wp.array | None = None  # in space; None until it is asked for


def allocate(
    parameters: Mapping[str, np.ndarray], nodes: int, law: int, law_numbers: np.ndarray, symmetric: bool, device: Any
) -> Arrays:
    """Arrays for rods with these ``parameters`` {name: [rod]} and ``law_numbers`` [rod, 4]; all others are zero."""
    count = len(parameters["bend"])
    shape = (count, nodes)
    rods = Swimmers()
    for name, field in PARAMETERS.items():
        setattr(rods, field, wp.array(parameters[name], dtype=wp.float64, device=device))
    rods.law = wp.full(count, law, dtype=wp.int32, device=device)
    rods.law_numbers = wp.array(law_numbers, dtype=wp.vec4d, device=device)
    rods.status = per_rod(count, wp.int32, device)
    rods.spacing = 1.0 / (nodes - 1)
    rods.symmetric = int(symmetric)
    applied = AppliedForce()
    applied.now = applied.before = one_zero(*shape, wp.vec3d, device)
    return Arrays(
        rods=rods,
        now=_shape(per_node, *shape, device),
        change=_shape(per_node, *shape, device),
        midpoint=_midpoint(count, device),
        failed_at=per_rod(count, device=device),
        applied=applied,
        star=_shape(scratch, *shape, device),
        scratch=_flow(scratch, *shape, scratch(*shape, wp.vec3d, device), device),
        flow=_flow(per_node, *shape, applied.now, device),
        measures=_measures(*shape, device),
        position=per_node(*shape, wp.vec3d, device),
        rotation=per_node(*shape, wp.mat33d, device),
        bishop_strain=per_node(*shape, wp.vec3d, device),
        strain=per_node(*shape, wp.vec3d, device),
        orientation=per_node(*shape, wp.quatd, device),
        spacing=wp.full(count, 1.0 / (nodes - 1), dtype=wp.float64, device=device),
    )


def make_room_for_forces(arrays: Arrays) -> None:
    """Arrays for external forces, all zero, in place of the one zero that stands for none."""
    shape = (*arrays.position.shape, wp.vec3d, arrays.position.device)
    arrays.force = per_node(*shape)
    arrays.applied.now, arrays.applied.before = per_node(*shape), per_node(*shape)
    arrays.flow.force = arrays.applied.now


def part(arrays: Arrays, rods: slice) -> Arrays:
    """The arrays of some of the rods, as views; with room of their own for what no rod keeps."""
    a = arrays
    count, nodes = a.position[rods].shape
    device = a.position.device
    return Arrays(
        rods=of_struct(Swimmers, a.rods, rods),
        now=of_struct(Shape, a.now, rods),
        change=of_struct(Shape, a.change, rods),
        midpoint=of_struct(Midpoint, a.midpoint, rods),
        failed_at=a.failed_at[rods],
        applied=of_struct(AppliedForce, a.applied, rods),
        star=_shape(scratch, count, nodes, device),
        scratch=_flow(scratch, count, nodes, scratch(count, nodes, wp.vec3d, device), device),
        flow=of_struct(Flow, a.flow, rods),
        measures=of_struct(Measures, a.measures, rods),
        position=a.position[rods],
        rotation=a.rotation[rods],
        bishop_strain=a.bishop_strain[rods],
        strain=a.strain[rods],
        orientation=a.orientation[rods],
        spacing=a.spacing[rods],
        force=of_array(a.force, rods),
    )


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

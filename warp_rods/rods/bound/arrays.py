"""The device arrays of an ensemble of surface-bound filaments, in the structs that its kernels take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warp_rods.kernels.bound.growth import Growth
from warp_rods.kernels.bound.levels import History, Plan
from warp_rods.kernels.bound.state import Filaments
from warp_rods.kernels.layout import constant_zero, per_node, per_rod
from warp_rods.kernels.magnus import RATES
from warp_rods.kernels.multistep import LEVELS, Levels, Pace
from warp_rods.rods.pace import allocate_pace
from warp_rods.rods.slices import slice_struct

GEODESIC = ("now", "first", "second", "third", "fourth")
"""Ω of the levels, newest first."""
CONTACT_HISTORY = ("contact_velocity", "contact_lag")
"""What a step keeps of contact for the next."""
VECTORS = ("curvature", "position", "force", "moment")
SCALARS = (
    *("geodesic", "shear_term", "transverse_force", "u1_left", "u1_right", "u1_constant"),
    *("tension", "velocity_along", "velocity_across", "geodesic_rate"),
)
ENDS = 2
PER_ROD = ("energy", "dissipation", "growth_power", "membrane_power", "force_power", "gauss")


@dataclass
class Arrays:
    """Arrays of ``rods`` × ``nodes``: parameters and state, history, growth, linear systems, and output."""

    f: Any  # Filaments
    past: Any  # History
    pace: Any  # Pace: times of the levels, and the next step
    plan: Any  # Plan: the present step
    growth: Any  # Growth
    bands: list[wp.array]  # lower2, lower, diagonal, upper, upper2; the tridiagonal system uses the first three
    rhs: wp.array
    work: wp.array
    work_pairs: wp.array
    weights: wp.array  # from turns to velocities
    normal_shear: wp.array
    output: dict[str, wp.array]
    contact_stiffness: wp.array | None = None  # K [rod, node], where there is contact


def allocate(
    parameters: Mapping[str, np.ndarray],
    nodes: int,
    clamped: tuple[bool, bool],
    tracked: int,
    knots: Any,
    membrane_moves: bool,
    device,
) -> Arrays:
    """Arrays for filaments with these ``parameters`` {length: [rod], stiffness, intrinsic, drag: [rod, 3]}.

    tracked: the node whose frame is advanced in time. knots: (time, length), each [rod, knot], length against time.
    membrane_moves: whether the membrane moves. All
    other arrays are zero.
    """
    count = len(parameters["length"])
    shape = (count, nodes)
    growth = Growth()
    growth.time, growth.length = (wp.array(k, dtype=wp.float64, device=device) for k in knots)
    return Arrays(
        f=_filaments(parameters, nodes, clamped, tracked, membrane_moves, device),
        past=_history(*shape, device),
        pace=allocate_pace(count, device),
        plan=_plan(*shape, device),
        growth=growth,
        bands=[per_node(*shape, wp.float64, device) for _ in range(5)],
        rhs=per_node(*shape, wp.float64, device),
        work=per_node(*shape, wp.float64, device),
        work_pairs=per_node(*shape, wp.vec2d, device),
        weights=per_node(*shape, wp.vec4d, device),
        normal_shear=per_node(*shape, wp.float64, device),
        output={
            **{name: per_rod(count, wp.float64, device) for name in PER_ROD},
            "residuals": per_rod(count, wp.vec3d, device),
            "energy_density": per_node(*shape, wp.float64, device),
            "load": per_node(*shape, wp.vec3d, device),
            "load_moment": per_node(*shape, wp.float64, device),
            "stretch_force": per_node(*shape, wp.float64, device),
            "end_load": per_node(count, ENDS, wp.vec3d, device),
            "end_moment": per_node(count, ENDS, wp.vec3d, device),
            "orientation": per_node(*shape, wp.quatd, device),
        },
    )


def _filaments(
    parameters: Mapping[str, np.ndarray],
    nodes: int,
    clamped: tuple[bool, bool],
    tracked: int,
    membrane_moves: bool,
    device: Any,
) -> Any:
    count = len(parameters["length"])
    shape = (count, nodes)
    f = Filaments()
    f.spacing = wp.array(parameters["length"] / (nodes - 1), dtype=wp.float64, device=device)
    for name in ("stiffness", "intrinsic", "drag"):
        setattr(f, name, wp.array(parameters[name], dtype=wp.vec3d, device=device))
    f.start_clamped, f.end_clamped = map(int, clamped)
    f.tracked = tracked
    f.growth_rate = per_rod(count, wp.float64, device)
    f.status = per_rod(count, wp.int32, device)
    f.active = wp.full(count, 1, dtype=wp.int32, device=device)
    f.rotation = per_node(*shape, wp.mat33d, device)
    for name in VECTORS:
        setattr(f, name, per_node(*shape, wp.vec3d, device))
    for name in SCALARS:
        setattr(f, name, per_node(*shape, wp.float64, device))
    f.contact_drag = constant_zero(*shape, wp.vec3d, device)
    f.membrane_moves = int(membrane_moves)
    for name in ("normal_velocity", "normal_velocity_slope"):
        setattr(f, name, (per_node if membrane_moves else constant_zero)(*shape, wp.float64, device))
    return f


def _history(rods: int, nodes: int, device: Any) -> Any:
    past = History()
    for name in GEODESIC:
        setattr(past, name, per_node(rods, nodes, wp.float64, device))
    past.turn = wp.zeros((rods, LEVELS), dtype=wp.float64, device=device)
    for name in ("rotation", "rotation_before"):
        setattr(past, name, per_rod(rods, wp.mat33d, device))
    for name in ("position", "position_before"):
        setattr(past, name, per_rod(rods, wp.vec3d, device))
    for name in ("angular_velocity", "velocity"):
        setattr(past, name, wp.zeros((rods, RATES), dtype=wp.vec3d, device=device))
    past.failed_at = per_rod(rods, wp.float64, device)
    for name in (*CONTACT_HISTORY, "contact_foretold"):
        setattr(past, name, constant_zero(rods, nodes, wp.vec2d, device))
    return past


def allocate_contact(arrays: Arrays) -> None:
    """Arrays by which a step treats contact as drag."""
    f, past = arrays.f, arrays.past
    rods, nodes = f.geodesic.shape
    arrays.contact_stiffness = per_node(rods, nodes, wp.mat33d, f.geodesic.device)
    f.contact_drag = per_node(rods, nodes, wp.vec3d, f.geodesic.device)
    for name in (*CONTACT_HISTORY, "contact_foretold"):
        setattr(past, name, per_node(rods, nodes, wp.vec2d, f.geodesic.device))


def _plan(rods: int, nodes: int, device: Any) -> Any:
    plan = Plan()
    for name in ("end", "rate", "turn_slope"):
        setattr(plan, name, per_rod(rods, wp.float64, device))
    for name in ("value", "slope"):
        setattr(plan, name, per_rod(rods, Levels, device))
    for name in ("geodesic_slope", "turn"):
        setattr(plan, name, per_node(rods, nodes, wp.float64, device))
    plan.unfit = wp.zeros((rods, 2), dtype=wp.int32, device=device)
    plan.status, plan.together = (per_rod(rods, wp.int32, device) for _ in range(2))
    for name in ("angle", "error", "lower", "higher"):
        setattr(plan, name, per_rod(rods, wp.float64, device))
    for name in ("velocity", "angular_velocity"):
        setattr(plan, name, per_rod(rods, wp.vec3d, device))
    return plan


def slice_arrays(arrays: Arrays, rods: slice) -> Arrays:
    """The arrays of some of the rods, as views."""
    a = arrays
    return Arrays(
        f=slice_struct(Filaments, a.f, rods),
        past=slice_struct(History, a.past, rods),
        pace=slice_struct(Pace, a.pace, rods),
        plan=slice_struct(Plan, a.plan, rods),
        growth=slice_struct(Growth, a.growth, rods),
        bands=[band[rods] for band in a.bands],
        rhs=a.rhs[rods],
        work=a.work[rods],
        work_pairs=a.work_pairs[rods],
        weights=a.weights[rods],
        normal_shear=a.normal_shear[rods],
        output={name: array[rods] for name, array in a.output.items()},
        contact_stiffness=None if a.contact_stiffness is None else a.contact_stiffness[rods],
    )


def tracked_node(nodes: int, clamped: tuple[bool, bool]) -> int:
    """The node whose frame is advanced in time: a clamped end, otherwise the middle."""
    if clamped[0]:
        return 0
    return nodes - 1 if clamped[1] else nodes // 2

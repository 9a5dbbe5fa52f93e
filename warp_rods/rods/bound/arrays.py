"""The device arrays of an ensemble of surface-bound filaments, in the structs that its kernels take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warp_rods.kernels.bound.evaluation import Output
from warp_rods.kernels.bound.growth import Growth
from warp_rods.kernels.bound.levels import History, Plan
from warp_rods.kernels.bound.state import Filaments, Systems
from warp_rods.kernels.lanes import Block, Lanes, Pair, Vector
from warp_rods.kernels.layout import along_rods, constant_zero, per_node, per_rod, workspace
from warp_rods.kernels.magnus import RATES
from warp_rods.kernels.multistep import LEVELS, Pace, Weights
from warp_rods.rods.outside import Outside
from warp_rods.rods.pace import allocate_pace
from warp_rods.rods.slices import slice_struct
from warp_rods.rods.tiles import tiled, tiles_of

GEODESIC = ("now", "first", "second", "third", "fourth")
"""Ω of the levels, newest first."""
SHAPE = {"geodesic": Lanes, "curvature": Vector, "tangent": Vector, "across": Vector, "normal": Vector}
"""Fields that one kernel hands to the next, and their types; the others are workspace."""
WORKSPACE = {
    **{"load": Vector, "moment": Vector, "shear_term": Lanes, "transverse_force": Lanes},
    **{"u1_left": Lanes, "u1_right": Lanes, "u1_constant": Lanes, "tension": Lanes},
    **{"velocity_along": Lanes, "velocity_across": Lanes, "geodesic_rate": Lanes},
}
SYSTEMS = {
    **{name: Lanes for name in ("lower2", "lower", "diagonal", "upper", "upper2", "rhs", "work", "turn")},
    **{"work_pairs": Pair, "weights": Block},
}
CONTACT_HISTORY = ("contact_velocity", "contact_lag")
"""What a step keeps of contact for the next."""
CONTACT = (*CONTACT_HISTORY, "contact_velocity_tried", "contact_lag_tried", "contact_foretold")
ALONG = ("stiffness", "intrinsic", "drag")
"""Parameters with three components that may change along the rods."""
ENDS = 2
OUTPUT_OF_RODS = ("energy", "dissipation", "growth_power", "membrane_power", "force_power", "gauss")
OUTPUT_OF_NODES = {
    **{"energy_density": Lanes, "load": Vector, "load_moment": Lanes, "stretch_force": Lanes},
    **{"normal_shear": Lanes, "tension": Lanes, "geodesic_rate": Lanes},
}


@dataclass
class Arrays:
    """Arrays of ``rods`` × ``nodes``: parameters and state, history, growth, linear systems, and output."""

    f: Any  # Filaments
    past: Any  # History
    pace: Any  # Pace: times of the levels, and the next step
    plan: Any  # Plan: the present step
    growth: Any  # Growth
    systems: Any  # Systems
    output: Any  # Output
    residuals: wp.array

    @property
    def rods(self) -> int:
        """The number of rods."""
        return self.f.status.shape[0]

    @property
    def tiles(self) -> int:
        """The number of tiles."""
        return self.f.geodesic.shape[0]


def allocate(
    parameters: Mapping[str, np.ndarray],
    nodes: int,
    clamped: tuple[bool, bool],
    tracked: int,
    knots: Any,
    membrane_moves: bool,
    device,
) -> Arrays:
    """Arrays for filaments with these ``parameters``: length [rod]; ``ALONG``: [rod, 3] or [rod, node, 3].

    tracked: the node whose frame is advanced in time. knots: (time, length), each [rod, knot], length against time.
    membrane_moves: whether the membrane moves. All
    other arrays are zero.
    """
    count = len(parameters["length"])
    growth = Growth()
    growth.time, growth.length = (wp.array(k, dtype=wp.float64, device=device) for k in knots)
    f = _filaments(parameters, nodes, clamped, tracked, membrane_moves, device)
    return Arrays(
        f=f,
        past=_history(count, nodes, device),
        pace=allocate_pace(count, device),
        plan=_plan(count, device),
        growth=growth,
        systems=_systems(f),
        output=_output(count, nodes, device),
        residuals=per_rod(count, wp.vec3d, device),
    )


def allocate_lines(
    parameters: Mapping[str, np.ndarray], nodes: int, clamped: tuple[bool, bool], tracked: int, device: Any
) -> tuple[Any, Any]:
    """What is needed to lay filaments out, without their history: ``Filaments`` and ``Plan``."""
    return _filaments(parameters, nodes, clamped, tracked, False, device), _plan(len(parameters["length"]), device)


def _filaments(
    parameters: Mapping[str, np.ndarray],
    nodes: int,
    clamped: tuple[bool, bool],
    tracked: int,
    membrane_moves: bool,
    device: Any,
) -> Any:
    count = len(parameters["length"])
    tiles = tiles_of(count)
    f = Filaments()
    spacing = parameters["length"] / (nodes - 1)
    f.spacing = tiled(spacing, Lanes, device)
    f.spacing_of_rod = wp.array(spacing, dtype=wp.float64, device=device)
    for name in ALONG:
        setattr(f, name, along_field(parameters[name], nodes, device))
    f.start_clamped, f.end_clamped = map(int, clamped)
    f.tracked = tracked
    f.growth_rate = per_rod(tiles, Lanes, device)
    f.status = per_rod(count, wp.int32, device)
    f.active = wp.full(count, 1, dtype=wp.int32, device=device)
    f.position, f.force = (per_node(count, nodes, wp.vec3d, device) for _ in range(2))
    f.contact_stiffness = constant_zero(count, nodes, wp.mat33d, device)
    for name, kind in SHAPE.items():
        setattr(f, name, per_node(tiles, nodes, kind, device))
    f.contact_drag = constant_zero(tiles, nodes, Vector, device)
    f.membrane_moves = int(membrane_moves)
    for name in ("normal_velocity", "normal_velocity_slope"):
        setattr(f, name, (per_node if membrane_moves else constant_zero)(tiles, nodes, Lanes, device))
    _give_workspace(f)
    return f


def along_field(values: np.ndarray, nodes: int, device: Any) -> wp.array:
    """A field [tile, node] of ``values`` [rod, 3], which are stored once, or [rod, node, 3]."""
    made = tiled(values, Vector, device)
    return made if values.ndim == 3 else along_rods(made, nodes)


def _give_workspace(f: Any) -> None:
    """Fields that are needed within one kernel only; threads must not share them."""
    shape, device = f.geodesic.shape, f.geodesic.device
    for name, kind in WORKSPACE.items():
        setattr(f, name, workspace(*shape, kind, device))
    if f.in_contact:
        f.contact_drag = workspace(*shape, Vector, device)
    if f.exposed:
        f.couple, f.stream = (workspace(*shape, Vector, device) for _ in range(2))
        f.stream_roll = workspace(*shape, Lanes, device)


def _systems(f: Any) -> Any:
    systems = Systems()
    for name, kind in SYSTEMS.items():
        setattr(systems, name, workspace(*f.geodesic.shape, kind, f.geodesic.device))
    return systems


def _history(rods: int, nodes: int, device: Any) -> Any:
    past = History()
    for name in GEODESIC:
        setattr(past, name, per_node(tiles_of(rods), nodes, Lanes, device))
    past.turn = wp.zeros((rods, LEVELS), dtype=wp.float64, device=device)
    for name in ("rotation", "rotation_before"):
        setattr(past, name, per_rod(rods, wp.mat33d, device))
    for name in ("position", "position_before"):
        setattr(past, name, per_rod(rods, wp.vec3d, device))
    for name in ("angular_velocity", "velocity"):
        setattr(past, name, wp.zeros((rods, RATES), dtype=wp.vec3d, device=device))
    past.failed_at = per_rod(rods, wp.float64, device)
    for name in CONTACT:
        setattr(past, name, constant_zero(tiles_of(rods), nodes, Pair, device))
    return past


def allocate_contact(arrays: Arrays) -> None:
    """Arrays by which a step treats contact as drag."""
    f, past = arrays.f, arrays.past
    (tiles, nodes), device = f.geodesic.shape, f.geodesic.device
    f.in_contact = 1
    f.contact_stiffness = per_node(arrays.rods, nodes, wp.mat33d, device)
    f.contact_drag = workspace(tiles, nodes, Vector, device)
    for name in CONTACT:
        setattr(past, name, per_node(tiles, nodes, Pair, device))


def allocate_outside(arrays: Arrays, outside: Outside) -> None:
    """Arrays for what acts from outside."""
    f = arrays.f
    f.exposed, f.outside = 1, outside.arrays(f.position.shape[1], f.geodesic.device)
    _give_workspace(f)


def _plan(rods: int, device: Any) -> Any:
    plan, tiles = Plan(), tiles_of(rods)
    for name in ("value", "slope"):
        setattr(plan, name, per_rod(tiles, Weights, device))
    for name in ("rate", "turn_slope"):
        setattr(plan, name, per_rod(tiles, Lanes, device))
    for name in ("tangent", "place"):
        setattr(plan, name, per_rod(tiles, Vector, device))
    plan.status, plan.together = (per_rod(rods, wp.int32, device) for _ in range(2))
    for name in ("end", "angle", "error", "lower", "higher", "unfit"):
        setattr(plan, name, per_rod(rods, wp.float64, device))
    for name in ("velocity", "angular_velocity"):
        setattr(plan, name, per_rod(rods, wp.vec3d, device))
    return plan


def _output(rods: int, nodes: int, device: Any) -> Any:
    output = Output()
    for name in OUTPUT_OF_RODS:
        setattr(output, name, per_rod(rods, wp.float64, device))
    for name, kind in OUTPUT_OF_NODES.items():
        setattr(output, name, per_node(tiles_of(rods), nodes, kind, device))
    output.end_load, output.end_moment = (per_node(rods, ENDS, wp.vec3d, device) for _ in range(2))
    output.orientation = per_node(rods, nodes, wp.quatd, device)
    return output


def slice_arrays(arrays: Arrays, rods: slice) -> Arrays:
    """The arrays of some of the rods, as views, with workspace of their own."""
    a = arrays
    f = slice_struct(Filaments, a.f, rods)
    _give_workspace(f)
    return Arrays(
        f=f,
        past=slice_struct(History, a.past, rods),
        pace=slice_struct(Pace, a.pace, rods),
        plan=slice_struct(Plan, a.plan, rods),
        growth=slice_struct(Growth, a.growth, rods),
        systems=_systems(f),
        output=slice_struct(Output, a.output, rods),
        residuals=a.residuals[rods],
    )


def tracked_node(nodes: int, clamped: tuple[bool, bool]) -> int:
    """The node whose frame is advanced in time: a clamped end, otherwise the middle."""
    if clamped[0]:
        return 0
    return nodes - 1 if clamped[1] else nodes // 2

"""The device arrays of an ensemble of free rods, in the structs that its kernels take."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warp_rods.kernels import outside as kernels
from warp_rods.kernels.free.holding import Hold
from warp_rods.kernels.free.output import Output
from warp_rods.kernels.free.state import (
    CARRIED_ALIKE,
    CARRIED_APART,
    Balance,
    Carrier,
    Contact,
    End,
    Load,
    Midpoint,
    Past,
    Shape,
    Swimmers,
    Trial,
)
from warp_rods.kernels.lanes import Block, Lanes, Pair, Vector
from warp_rods.kernels.layout import along_rods, constant_zero, per_node, per_rod, workspace
from warp_rods.kernels.magnus import RATES
from warp_rods.kernels.multistep import Pace
from warp_rods.rods.along import at_half_nodes, product
from warp_rods.rods.free import ends
from warp_rods.rods.free.natural import Natural
from warp_rods.rods.outside import Outside
from warp_rods.rods.pace import allocate_pace
from warp_rods.rods.slices import slice_array, slice_struct
from warp_rods.rods.tiles import tiled, tiles_of

PARAMETERS = {
    "bend": "bending_stiffness",
    "twist": "twist_stiffness",
    "moment": "moment",
    "drag_ratio": "drag_ratio",
    "rotational_drag": "rotational_drag",
    "relaxation": "relaxation",
    "diffusion": "diffusion",
}
"""Names of the parameters of uniform swimmers in a scene → those in the theory."""
OF_RODS = ("moment", "relaxation", "diffusion")
"""Parameters that are one number for each rod."""
SHAPE = ("bending", "twist", "activity")
PAST = ("first", "second", "third", "fourth")
BANDS = ("lower2", "lower", "diagonal", "upper", "upper2")
COMPLEX = tuple(f"complex_{band}" for band in BANDS)
IN_BLOCKS = tuple(f"block_{band}" for band in BANDS)
BALANCE = (
    *("axial_mobility", "transverse_mobility", "moment_slope", "axial_source", "transverse_source", "tension"),
    *("axial_velocity", "transverse_velocity", "angular_velocity", "twist_source", "bishop_roll_rate"),
    *(*BANDS, *COMPLEX, *IN_BLOCKS, "rhs", "rhs_pairs", "rhs_equal"),
    *("work", "work_pairs", "work_pairs2", "work_block", "work_block2"),
)
SHOWN = ("tension", "axial_velocity", "transverse_velocity", "angular_velocity")
"""Fields of ``Balance`` that are read; all others are workspace."""
LOAD = (
    *("axial_force", "transverse_force", "axial_drag", "transverse_drag", "axial_couple", "transverse_couple"),
    *("axial_stream", "transverse_stream", "stream_roll"),
)
OF_FLOW = ("axial_stream", "transverse_stream", "stream_roll", "axial_couple")
OF_COUPLES = ("axial_couple", "transverse_couple")
"""Fields of ``Load`` that a flow, and couples in space, write."""
CARRIER = ("displacement", "displacement_before", "velocity")
"""What steps keep of how a flow carries rods."""
CONTACT = ("velocity", "lag", "velocity_tried", "lag_tried", "foretold")
TRIAL = {
    **dict.fromkeys(("end", "limit", "angle", "error", "roll_rate"), wp.float64),
    **dict.fromkeys(("order", "status"), wp.int32),
    **dict.fromkeys(("angular_velocity", "velocity"), wp.vec3d),
}
PAIRS = {
    *("bending", "transverse_source", "transverse_velocity", "angular_velocity", "bending_rate", "transverse_force"),
    *("rest", "natural_bending", "transverse_couple", "transverse_stream", "moment_slope"),
    *(*COMPLEX, "rhs_pairs", "rhs_equal", "work_pairs", "work_pairs2"),
}
"""Fields with two components across the rod."""
BLOCKS = {"transverse_drag", "transverse_mobility", "work_block", "work_block2", *IN_BLOCKS}
"""Fields of matrices between these components; all others are numbers."""


@dataclass
class Arrays:
    """Arrays of ``rods`` × ``nodes``: parameters, state, workspace of a step, and output."""

    rods: Any  # Swimmers
    now: Any  # Shape: the present one
    past: Any  # Past: the shapes of the steps before
    midpoint: Any  # Midpoint
    pace: Any  # Pace: times of these shapes, and the next step
    shown: Any  # Shape: that of the present time
    shown_midpoint: Any  # Midpoint: the frame of the present time; its rates are not used
    failed_at: wp.array
    contact: Any  # Contact
    trial: Any  # Trial: the step that is tried
    star: Any  # Shape: x*, then the shape at the end of that step
    slope: Any  # Shape: Σ d_j x_j, workspace
    step_balance: Any  # Balance of a step, workspace
    balance: Any  # Balance of the present shape, for output
    output: Any  # Output
    position: wp.array
    rotation: wp.array
    strain: wp.array
    orientation: wp.array
    spacing: wp.array
    force: wp.array | None = None  # external force in space; None until one is used
    hold: Any = None  # Hold: ends held in space; None without them
    outside: Any = None  # Outside: flow, gravity, forces by formula; None without them
    couple: Any = None  # the rods' own couple about the tangent, half nodes [tile, node]; None until it is used
    across: Any = None  # that across it, in the Bishop frame

    @property
    def stiffness(self) -> wp.array | None:
        """K of contact; None until it is used."""
        return self.contact.stiffness if self.contact.present else None


def allocate(
    parameters: Mapping[str, np.ndarray],
    nodes: int,
    law: int,
    law_parameters: np.ndarray,
    symmetric: bool,
    device: Any,
) -> Arrays:
    """Arrays for rods with these ``parameters`` {name: [rod]} and ``law_parameters`` [rod, 4]; all others are zero."""
    count = len(parameters["bend"])
    shape = (count, nodes)
    fields = (tiles_of(count), nodes)
    rods = Swimmers()
    for name in OF_RODS:
        setattr(rods, name, tiled(parameters[name], device=device))
    set_along(rods, parameters, nodes, device)
    rods.natural_bending = constant_zero(*fields, Pair, device)
    rods.natural_twist = constant_zero(*fields, Lanes, device)
    rods.first, rods.last = free_end(fields[0], device), free_end(fields[0], device)
    rods.tracked = nodes // 2
    rods.law = law
    rods.law_parameters = tiled(law_parameters, Block, device)
    rods.status = per_rod(count, wp.int32, device)
    rods.spacing = 1.0 / (nodes - 1)
    rods.symmetric = int(symmetric)
    return Arrays(
        rods=rods,
        now=_shape(per_node, *fields, device),
        past=_past(*fields, device),
        midpoint=_midpoint(count, device),
        pace=allocate_pace(count, device),
        shown=_shape(per_node, *fields, device),
        shown_midpoint=_midpoint(count, device),
        failed_at=per_rod(count, device=device),
        contact=_contact(*shape, device),
        trial=_trial(count, device),
        star=_shape(per_node, *fields, device),
        slope=_shape(workspace, *fields, device),
        step_balance=_balance(*fields, _load(*fields, device), device),
        balance=_balance(*fields, _load(*fields, device), device, shown=SHOWN),
        output=_output(*fields, device),
        position=per_node(*shape, wp.vec3d, device),
        rotation=per_node(*shape, wp.mat33d, device),
        strain=per_node(*shape, wp.vec3d, device),
        orientation=per_node(*shape, wp.quatd, device),
        spacing=wp.full(count, 1.0 / (nodes - 1), dtype=wp.float64, device=device),
    )


def set_along(rods: Any, parameters: Mapping[str, np.ndarray], nodes: int, device: Any) -> None:
    """Set stiffnesses and drags from ``parameters`` {name: [rod] or [rod, node]}."""

    def field(values: np.ndarray) -> wp.array:
        made = tiled(values, device=device)
        return made if values.ndim == 2 else along_rods(made, nodes)

    rods.bending_stiffness, rods.twist_stiffness = field(parameters["bend"]), field(parameters["twist"])
    rods.drag_along = field(at_half_nodes(parameters["drag_along"]))
    rods.drag_across = field(product(parameters["drag_along"], parameters["drag_ratio"]))
    rods.rotational_mobility = field(1.0 / at_half_nodes(parameters["rotational_drag"]))


def free_end(tiles: int, device: Any) -> Any:
    """An end that nothing holds or loads."""
    end = End()
    for name in ("velocity", "angular_velocity", "force", "couple"):
        setattr(end, name, wp.zeros(tiles, dtype=Vector, device=device))
    return end


def allocate_hold(arrays: Arrays) -> None:
    """Arrays of zeros for what holds ends in space; those for external forces must be there."""
    rods, device = arrays.position.shape[0], arrays.position.device
    arrays.hold = Hold()
    for name in Hold.vars:
        dtype = wp.mat33d if name == "rotation" else wp.vec3d
        setattr(arrays.hold, name, wp.zeros((rods, 2), dtype=dtype, device=device))


def set_ends(arrays: Arrays, first: ends.End, last: ends.End) -> None:
    """What holds and loads the ends."""
    for name, end in (("first", first), ("last", last)):
        made = getattr(arrays.rods, name)
        made.kind = ends.KINDS[end.kind]
        none = np.zeros_like(end.thrust)
        made.force.assign(tiled(np.stack([end.thrust, none, none], axis=1), Vector).numpy())
        made.couple.assign(tiled(np.stack([end.torque, none, none], axis=1), Vector).numpy())
        made.angular_velocity.assign(tiled(np.stack([end.turning, none, none], axis=1), Vector).numpy())
        setattr(arrays.rods, name, made)
    arrays.rods.tracked = ends.tracked_node(first, last, arrays.position.shape[1])


def allocate_natural(arrays: Arrays, natural: Natural) -> None:
    """Natural strains of the material frame."""
    (rods, nodes), device = arrays.position.shape, arrays.position.device
    arrays.rods.natural_bending = tiled(natural.bending, Pair, device)
    arrays.rods.natural_twist = tiled(natural.twist, Lanes, device)
    arrays.rods.wound = int(natural.varies or natural.twist.any())
    arrays.rods.bent = int(natural.varies or natural.bending.any())
    if arrays.rods.bent:
        for balance in (arrays.step_balance, arrays.balance):
            balance.rest = workspace(tiles_of(rods), nodes, Pair, device)


def allocate_force(arrays: Arrays) -> None:
    """Arrays of zeros for external forces, in place of the constant zero that a rod without forces reads."""
    (rods, nodes), device = arrays.position.shape, arrays.position.device
    arrays.force = per_node(rods, nodes, wp.vec3d, device)
    arrays.rods.forced = 1
    for balance in (arrays.step_balance, arrays.balance):
        _allocate_load(balance, rods, nodes, device, ("axial_force", "transverse_force"))


def allocate_couple(arrays: Arrays, couple: np.ndarray) -> None:
    """The rods' own couple [rod, node] about the tangent, which steps and readings take from one array."""
    device = arrays.position.device
    arrays.couple = tiled(at_half_nodes(couple), device=device)
    arrays.rods.forced = 1
    for balance in (arrays.step_balance, arrays.balance):
        load = balance.load
        load.axial_couple = arrays.couple
        balance.load = load


def allocate_couple_across(arrays: Arrays) -> wp.array:
    """The rods' own couple across the tangent, the same along a rod [tile]; zeros, which may be written."""
    tiles, nodes = arrays.now.twist.shape
    couple = wp.zeros(tiles, dtype=Pair, device=arrays.position.device)
    arrays.across = along_rods(couple, nodes)
    arrays.rods.forced = 1
    for balance in (arrays.step_balance, arrays.balance):
        load = balance.load
        load.transverse_couple = arrays.across
        balance.load = load
    return couple


def allocate_outside(arrays: Arrays, outside: Outside) -> None:
    """Arrays for what acts from outside; those for external forces must be there."""
    (rods, nodes), device = arrays.position.shape, arrays.position.device
    arrays.outside = outside.arrays(nodes, device)
    arrays.rods.flowing = int(outside.flows)
    if arrays.couple is None:
        arrays.couple = constant_zero(tiles_of(rods), nodes, Lanes, device)
    if arrays.across is None:
        arrays.across = constant_zero(tiles_of(rods), nodes, Pair, device)
    for balance in (arrays.step_balance, arrays.balance):
        _allocate_load(balance, rods, nodes, device, OF_FLOW * outside.flows + OF_COUPLES * outside.turns)
    if outside.flows and not (arrays.rods.first.kind or arrays.rods.last.kind):
        carrier = Carrier()
        carrier.kind, carrier.stream = CARRIED_APART, arrays.outside.velocity
        for name in ("displacement", "displacement_before"):
            setattr(carrier, name, per_rod(rods, wp.vec3d, device))
        carrier.velocity = wp.zeros((rods, RATES), dtype=wp.vec3d, device=device)
        set_carrier(arrays, carrier)


def set_carrier(arrays: Arrays, carrier: Any) -> None:
    """How a flow carries the rods."""
    arrays.midpoint.carrier = carrier


def put_down(arrays: Arrays, time: float) -> None:
    """Let the frames of ``midpoint``, which are those in space at a time, be in the axes that a flow carries."""
    carrier = arrays.midpoint.carrier
    if carrier.kind == CARRIED_ALIKE:
        place = arrays.midpoint.position
        place.assign(place.numpy() - time * np.array(carrier.uniform))
    elif carrier.kind == CARRIED_APART:
        for name in CARRIER:
            getattr(carrier, name).zero_()


def carried_alike(velocity: np.ndarray) -> Any:
    """How a uniform flow carries rods."""
    carrier = Carrier()
    carrier.kind, carrier.uniform = CARRIED_ALIKE, wp.vec3d(*velocity)
    return carrier


def _allocate_load(balance: Any, rods: int, nodes: int, device: Any, names: Collection[str]) -> None:
    """Arrays of zeros for some fields of the load, in place of the constant zero."""
    load = balance.load
    for name in names:
        setattr(load, name, per_node(tiles_of(rods), nodes, _dtype(name), device))
    balance.load = load


def allocate_contact(arrays: Arrays) -> None:
    """Arrays of zeros for contact as drag; those for external forces must be there."""
    (rods, nodes), device = arrays.position.shape, arrays.position.device
    arrays.contact = _contact(rods, nodes, device, present=True)
    arrays.rods.touched = 1
    load = arrays.step_balance.load
    for name in ("axial_drag", "transverse_drag"):
        setattr(load, name, per_node(tiles_of(rods), nodes, _dtype(name), device))
    arrays.step_balance.load = load


def slice_arrays(arrays: Arrays, rods: slice) -> Arrays:
    """The arrays of some of the rods, as views, with workspace of their own."""
    a = arrays
    tiles, nodes = slice_array(a.now.twist, rods).shape
    device = a.position.device
    return Arrays(
        rods=slice_struct(Swimmers, a.rods, rods),
        now=slice_struct(Shape, a.now, rods),
        past=slice_struct(Past, a.past, rods),
        midpoint=slice_struct(Midpoint, a.midpoint, rods),
        pace=slice_struct(Pace, a.pace, rods),
        shown=slice_struct(Shape, a.shown, rods),
        shown_midpoint=slice_struct(Midpoint, a.shown_midpoint, rods),
        failed_at=a.failed_at[rods],
        contact=slice_struct(Contact, a.contact, rods),
        trial=slice_struct(Trial, a.trial, rods),
        star=slice_struct(Shape, a.star, rods),
        slope=_shape(workspace, tiles, nodes, device),
        step_balance=_balance(
            tiles, nodes, slice_struct(Load, a.step_balance.load, rods), device, bent=a.rods.bent == 1
        ),
        balance=slice_struct(Balance, a.balance, rods),
        output=slice_struct(Output, a.output, rods),
        position=a.position[rods],
        rotation=a.rotation[rods],
        strain=a.strain[rods],
        orientation=a.orientation[rods],
        spacing=a.spacing[rods],
        force=slice_array(a.force, rods),
        hold=None if a.hold is None else slice_struct(Hold, a.hold, rods),
        outside=None if a.outside is None else slice_struct(kernels.Outside, a.outside, rods),
        couple=slice_array(a.couple, rods),
        across=slice_array(a.across, rods),
    )


def _shape(make: Any, tiles: int, nodes: int, device: Any) -> Any:
    shape = Shape()
    for name in SHAPE:
        setattr(shape, name, make(tiles, nodes, _dtype(name), device))
    return shape


def _load(tiles: int, nodes: int, device: Any) -> Any:
    load = Load()
    for name in LOAD:
        setattr(load, name, constant_zero(tiles, nodes, _dtype(name), device))
    return load


def _contact(rods: int, nodes: int, device: Any, present: bool = False) -> Any:
    contact = Contact()
    contact.present, make = int(present), per_node if present else constant_zero
    contact.stiffness = make(rods, nodes, wp.mat33d, device)
    for name in CONTACT:
        setattr(contact, name, make(tiles_of(rods), nodes, Vector, device))
    return contact


def _trial(rods: int, device: Any) -> Any:
    trial = Trial()
    for name, dtype in TRIAL.items():
        setattr(trial, name, per_rod(rods, dtype, device))
    trial.limit.fill_(np.inf)
    return trial


def _balance(tiles: int, nodes: int, load: Any, device: Any, shown: Collection[str] = (), bent: bool = False) -> Any:
    balance = Balance()
    balance.load = load
    balance.rest = constant_zero(tiles, nodes, Pair, device)
    if bent:
        balance.rest = workspace(tiles, nodes, Pair, device)
    for name in BALANCE:
        make = per_node if name in shown else workspace
        setattr(balance, name, make(tiles, nodes, _dtype(name), device))
    return balance


def _output(tiles: int, nodes: int, device: Any) -> Any:
    output = Output()
    for name in ("bending_rate", "twist_rate", "activity_rate", "energy_density"):
        setattr(output, name, per_node(tiles, nodes, _dtype(name), device))
    for name in ("energy", "dissipation", "power", "flow_power"):
        setattr(output, name, per_rod(tiles, Lanes, device))
    return output


def _past(tiles: int, nodes: int, device: Any) -> Any:
    past = Past()
    for name in PAST:
        setattr(past, name, _shape(per_node, tiles, nodes, device))
    return past


def _midpoint(rods: int, device: Any) -> Any:
    midpoint = Midpoint()
    for name in ("rotation", "rotation_before"):
        setattr(midpoint, name, per_rod(rods, wp.mat33d, device))
    for name in ("position", "position_before"):
        setattr(midpoint, name, per_rod(rods, wp.vec3d, device))
    for name in ("angle", "angle_before"):
        setattr(midpoint, name, per_rod(rods, device=device))
    for name in ("angular_velocity", "velocity"):
        setattr(midpoint, name, wp.zeros((rods, RATES), dtype=wp.vec3d, device=device))
    midpoint.roll_rate = wp.zeros((rods, RATES), dtype=wp.float64, device=device)
    return midpoint


def _dtype(name: str) -> Any:
    if name in BLOCKS:
        return Block
    return Pair if name in PAIRS else Lanes

"""The device arrays of an ensemble of Cosserat rods, in the structs that its kernels take."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warp_rods.kernels.cosserat.blocks import SLOTS, Blocks
from warp_rods.kernels.cosserat.output import Output
from warp_rods.kernels.cosserat.state import Frames, Past, Rods, Trial, Work
from warp_rods.kernels.lanes import Lanes, Matrix, Row, Screw, Square, Vector
from warp_rods.kernels.layout import constant_zero, per_node, per_rod, workspace
from warp_rods.kernels.multistep import Pace
from warp_rods.rods.pace import allocate_pace
from warp_rods.rods.slices import slice_array, slice_struct
from warp_rods.rods.tiles import tiled, tiles_of

FRAMES = {"rotation": Matrix, "position": Vector, "stress": Screw}
PAST = ("screw", "screw_before", "stress_before")
WORK = {"angle": Matrix, "place": Matrix, "stress": Screw}


@dataclass
class Arrays:
    """Arrays of ``rods`` × ``nodes``: parameters, state, workspace of a step, and output."""

    rods: Any  # Rods
    now: Any  # Frames: the present ones
    past: Any  # Past
    pace: Any  # Pace
    trial: Any  # Trial: the step that is tried
    star: Any  # Frames: extrapolated, then those at the end of that step
    work: Any  # Work
    shown: Any  # Frames: those of the present time
    rates: wp.array  # velocities at the end of the last step
    output: Any  # Output
    failed_at: wp.array
    rotation: wp.array
    position: wp.array
    orientation: wp.array
    spacing: wp.array


def allocate(
    stiffness: np.ndarray,
    natural: np.ndarray,
    drag: tuple[np.ndarray, np.ndarray],
    held: np.ndarray,
    device: Any,
) -> Arrays:
    """Arrays for rods of ``stiffness`` [rod, 6, 6], ``natural`` strain of segments [rod, node − 1, 6], (η, ηr) [rod].

    held [rod, 2, 6]: 1 for what the first and the last node may not do.
    """
    count, nodes = len(stiffness), natural.shape[1] + 1
    shape, fields = (count, nodes), (tiles_of(count), nodes)
    rods = Rods()
    rods.stiffness = tiled(stiffness.reshape(count, 36), Square, device)
    rods.drag_ratio, rods.rotational_drag = (tiled(values, Lanes, device) for values in drag)
    rods.natural = tiled(np.concatenate([natural, natural[:, -1:]], axis=1), Screw, device)
    rods.held = tiled(held, Screw, device)
    rods.force, rods.couple = (per_node(*shape, wp.vec3d, device) for _ in range(2))
    rods.contact_stiffness = constant_zero(*shape, wp.mat33d, device)
    rods.status = per_rod(count, wp.int32, device)
    rods.spacing = 1.0 / (nodes - 1)
    return Arrays(
        rods=rods,
        now=_frames(*fields, device),
        past=_past(*fields, device),
        pace=allocate_pace(count, device),
        trial=_trial(count, nodes, device),
        star=_frames(*fields, device),
        work=_work(*fields, device),
        shown=_frames(*fields, device),
        rates=per_node(*fields, Screw, device),
        output=_output(count, nodes, device),
        failed_at=per_rod(count, device=device),
        rotation=per_node(*shape, wp.mat33d, device),
        position=per_node(*shape, wp.vec3d, device),
        orientation=per_node(*shape, wp.quatd, device),
        spacing=wp.full(count, 1.0 / (nodes - 1), dtype=wp.float64, device=device),
    )


def allocate_contact(arrays: Arrays) -> None:
    """An array of zeros for the stiffness of contact."""
    arrays.rods.contact_stiffness = per_node(*arrays.position.shape, wp.mat33d, arrays.position.device)
    arrays.rods.touched = 1


def slice_arrays(arrays: Arrays, rods: slice) -> Arrays:
    """The arrays of some of the rods, as views, with workspace of their own."""
    a = arrays
    tiles, nodes = slice_array(a.now.rotation, rods).shape
    return Arrays(
        rods=slice_struct(Rods, a.rods, rods),
        now=slice_struct(Frames, a.now, rods),
        past=slice_struct(Past, a.past, rods),
        pace=slice_struct(Pace, a.pace, rods),
        trial=slice_struct(Trial, a.trial, rods),
        star=slice_struct(Frames, a.star, rods),
        work=_work(tiles, nodes, a.position.device),
        shown=slice_struct(Frames, a.shown, rods),
        rates=slice_array(a.rates, rods),
        output=slice_struct(Output, a.output, rods),
        failed_at=a.failed_at[rods],
        rotation=a.rotation[rods],
        position=a.position[rods],
        orientation=a.orientation[rods],
        spacing=a.spacing[rods],
    )


def _frames(tiles: int, nodes: int, device: Any) -> Any:
    frames = Frames()
    for name, dtype in FRAMES.items():
        setattr(frames, name, per_node(tiles, nodes, dtype, device))
    return frames


def _past(tiles: int, nodes: int, device: Any) -> Any:
    past = Past()
    for name in PAST:
        setattr(past, name, per_node(tiles, nodes, Screw, device))
    return past


def _trial(count: int, nodes: int, device: Any) -> Any:
    trial = Trial()
    for name, dtype in (("end", wp.float64), ("error", wp.float64), ("order", wp.int32), ("status", wp.int32)):
        setattr(trial, name, per_rod(count, dtype, device))
    trial.screw = per_node(tiles_of(count), nodes, Screw, device)
    return trial


def _work(tiles: int, nodes: int, device: Any) -> Any:
    work = Work()
    for name, dtype in WORK.items():
        setattr(work, name, workspace(tiles, nodes, dtype, device))
    blocks = Blocks()
    for name in ("lower", "diagonal", "upper"):
        setattr(blocks, name, workspace(tiles, int(SLOTS), Square, device))
    blocks.rows = workspace(tiles, nodes, Row, device)
    work.blocks = blocks
    return work


def _output(count: int, nodes: int, device: Any) -> Any:
    output, tiles = Output(), tiles_of(count)
    for name in ("strain", "stretch", "internal_moment", "internal_force"):
        setattr(output, name, per_node(count, nodes, wp.vec3d, device))
    output.energy_density = per_node(tiles, nodes, Lanes, device)
    for name in ("segments", "force"):
        setattr(output, name, workspace(tiles, nodes, Screw, device))
    for name in ("energy", "dissipation", "power"):
        setattr(output, name, per_rod(tiles, Lanes, device))
    return output

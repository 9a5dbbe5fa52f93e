"""Rods of a run at a frame as the shape of rods at the start."""

from __future__ import annotations

import functools
import hashlib
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods.centrelines.centreline import Line, line_of
from warp_rods.centrelines.on_membrane import FARTHEST
from warp_rods.centrelines.track import Track, TrackError, chosen_frame
from warp_rods.errors import RunFolderError, SceneError
from warp_rods.membranes.surface import Surface
from warp_rods.rods.status import Status
from warp_rods.scene.filaments import FilamentsTable
from warp_rods.scene.scene import Scene
from warp_rods.scene.swimmers import SwimmersTable
from warp_rods.simulation.start_arrays import Arrays, Given, resampled

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["from_run"]

MARKS = {"swimmers": "drag_ratio", "filaments": "stiffness"}
"""A variable that only groups of this kind have."""


def from_run(table: SwimmersTable | FilamentsTable, scene: Scene, surface: Surface | None) -> Given:
    """The rods of a table as a run has them; raises SceneError naming its key, the folder, and what is wrong there."""
    assert table.shape is not None and table.shape.run is not None
    from warp_rods.simulation.reading import open_run

    try:
        group, name = _group(open_run(table.shape.run), table)
        rows = _rows(group, table)
        kind = _free if isinstance(table, SwimmersTable) else _bound
        arrays, notes = kind(group, rows)
    except (TrackError, RunFolderError) as fault:
        text = str(fault) if isinstance(fault, RunFolderError) else f"{table.shape.run} {fault}"
        raise SceneError(f"shape.run: {text}") from None
    if surface is not None and isinstance(table, FilamentsTable):
        notes = [_distance(arrays, surface, table.shape.run), *notes]
    digest = hashlib.sha256()
    for key in sorted(arrays):
        digest.update(np.ascontiguousarray(arrays[key]).tobytes())
    frames = sorted({frame for frame, _ in rows})
    times = ", ".join(f"{float(group['time'][frame]):g}" for frame in frames[:3])
    source = f"{table.shape.run}: {name} at t = {times}{', …' if len(frames) > 3 else ''}"
    told = [f"{table.name}: begins as {source}", *(f"{table.name}: {note}" for note in notes)]

    @functools.cache
    def at(nodes: int) -> tuple[Arrays, list[str]]:
        return resampled(arrays, nodes), told

    return Given(at, ((source, digest.hexdigest()),))


def _group(run: xr.DataTree, table: SwimmersTable | FilamentsTable) -> tuple[xr.Dataset, str]:
    """The ensemble of the run that a table asks for, that has its name, or that is the only one of its kind."""
    assert table.shape is not None
    kind = "swimmers" if isinstance(table, SwimmersTable) else "filaments"
    groups = {name: group.to_dataset() for name, group in run.children.items() if MARKS[kind] in group}
    wanted = table.shape.ensemble
    name = wanted or (table.name if table.name in groups or len(groups) != 1 else next(iter(groups)))
    if name not in groups:
        known = ", ".join(groups) or "none"
        raise TrackError(f"has no {kind} named {name}: give shape.ensemble, one of {known}")
    if not groups[name].sizes.get("frame"):
        raise TrackError("has no complete frame")
    return groups[name], name


def _rows(group: xr.Dataset, table: SwimmersTable | FilamentsTable) -> list[tuple[int, int]]:
    """The frame and the rod of the run for each rod of a table; raises TrackError for those that are not there."""
    shape, count, there = table.shape, table.count, group.sizes["rod"]
    assert shape is not None
    rods = shape.rod
    if rods is None:
        if there not in (1, count):
            raise TrackError(f"has {there} rods, and count = {count}: choose by rod, a number or a list of {count}")
        rods = 0 if there == 1 else tuple(range(count))
    times = group["time"].values.tolist()
    found = []
    for one, rod in enumerate(_each(rods, count)):
        frame, time = (_each(value, count)[one] for value in (shape.frame, shape.time))
        index = chosen_frame(times, -1 if frame is None and time is None else frame, time)
        if rod >= there:
            raise TrackError(f"rod = {rod}: has {there} rods, 0 to {there - 1}")
        found.append((index, rod))
    status = group["status"]
    for index, rod in dict.fromkeys(found):
        if state := int(status[index, rod]):
            raise TrackError(f"lost the rod {rod} before the frame {index}: it {Status(state).words}: choose another")
    return found


def _each(value: Any, count: int) -> list[Any]:
    return list(value) if isinstance(value, tuple) else [value] * count


def _values(group: xr.Dataset, name: str, rows: list[tuple[int, int]]) -> np.ndarray | None:
    """A variable of each row in double precision; None where the run did not save it."""
    if name not in group:
        return None
    frames = {frame: group[name].isel(frame=frame).values for frame in {frame for frame, _ in rows}}
    return np.array([frames[frame][rod] for frame, rod in rows], dtype=np.float64)


def _directors(group: xr.Dataset, rows: list[tuple[int, int]]) -> np.ndarray | None:
    """Material frames [rod, node, 3, 3] from quaternions, which are normalised."""
    found = _values(group, "orientation", rows)
    if found is None:
        return None
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(found.reshape(-1, 4)).as_matrix().reshape(*found.shape[:2], 3, 3)


def _lines(group: xr.Dataset, rows: list[tuple[int, int]]) -> list[Line]:
    """The curves through the nodes, where strains or frames were not saved."""
    position = _values(group, "position", rows)
    assert position is not None
    return [line_of(Track(one), 0.0) for one in position]


def _free(group: xr.Dataset, rows: list[tuple[int, int]]) -> tuple[Arrays, list[str]]:
    strain, frames, activity = _values(group, "strain", rows), _directors(group, rows), _values(group, "activity", rows)
    position = _values(group, "position", rows)
    assert position is not None
    middle, notes = position.shape[1] // 2, []
    if strain is None or frames is None:
        rods = [line.rod(position.shape[1]) for line in _lines(group, rows)]
        if strain is None:
            strain, frames = np.array([rod.strain for rod in rods]), None
            notes.append("strains were not saved: the shape is that of the positions, without twist")
        rotation = np.array([rod.rotation for rod in rods])
    if frames is not None:
        rotation = frames[:, middle]
    if activity is None:
        notes.append("the activity was not saved: it begins with the profile of the scene")
    arrays = {"strain": strain, "position": position[:, middle], "rotation": rotation}
    return arrays | ({} if activity is None else {"activity": activity}), notes


def _bound(group: xr.Dataset, rows: list[tuple[int, int]]) -> tuple[Arrays, list[str]]:
    strain, frames, length = _values(group, "strain", rows), _directors(group, rows), _values(group, "length", rows)
    position = _values(group, "position", rows)
    if strain is None or frames is None or length is None or position is None:
        raise TrackError("lacks strain, orientation or length of the filaments: save all variables (output.variables)")
    arrays = {"line": position, "tangent": frames[..., 0], "geodesic_curvature": strain[..., 2], "length": length}
    return arrays, []


def _distance(arrays: Arrays, surface: Surface, run: str) -> str:
    """How far filaments of a run are from the membrane; raises SceneError where that is absurd."""
    with np.errstate(all="ignore"):
        off = np.linalg.norm(surface.at(0.0).project(arrays["line"]) - arrays["line"], axis=-1)
    share = off / arrays["length"][:, None]
    if not share.max() <= FARTHEST:
        rod = int(np.argmax(np.nan_to_num(share, nan=np.inf).max(axis=1)))
        raise SceneError(
            f"shape.run: {run}: rod {rod} is {off[rod].max():.3g} away from the membrane, more than {FARTHEST:g} of "
            f"its length: the run was on another membrane, or on a moving one at another time"
        )
    return f"up to {off.max():.2g} away from the membrane (rms {np.sqrt(np.mean(off**2)):.2g}), and projected onto it"

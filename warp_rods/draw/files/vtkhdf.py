"""VTKHDF, the HDF5 format of VTK, for ParaView: a file for each ensemble, the membrane and the box, over time.

Rods are lines with the variables of the trajectory as arrays of their points and, where there is one value a rod, of
their cells. What does not move is stored once, and every step refers to it. One file could hold several blocks, but
VTK 9.7 shows the first step of such a file at all times.
https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/vtkhdf_specifications.html
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods.draw.colours import at_frames
from warp_rods.draw.files.hdf5 import new_file
from warp_rods.draw.files.optional import needed
from warp_rods.progress import with_progress

if TYPE_CHECKING:
    from warp_rods.draw.content import Content
    from warp_rods.draw.rods import Rods
    from warp_rods.draw.sheet import Sheet

__all__ = ["size", "write"]

VERSION = (2, 0)
COMPRESSED: dict[str, Any] = {"compression": "gzip", "compression_opts": 3, "shuffle": True}
TOPOLOGIES = ("Vertices", "Lines", "Polygons", "Strips")
"""The four kinds of cells of PolyData, in the order of the format."""
LEFT_OUT = ("position", "orientation")
"""Variables that are no arrays of points: the points themselves, and quaternions."""


def write(content: Content, path: Path) -> None:
    """Write what is shown, with all variables of its rods, into the folder ``path``; single precision."""
    needed("h5py", "--vtkhdf")
    path.mkdir()
    for name, fill in _parts(content).items():
        with new_file(path / f"{name}.vtkhdf", "--vtkhdf") as (file, below):
            fill(PolyData(file.create_group("VTKHDF"), content.times, below.check))


def size(content: Content) -> float:
    """About how many bytes the files have: arrays of single precision, a sixth less by compression."""
    bytes_of_rods = sum(
        content.frames * 4 * rods.count * (rods.nodes * (3 + _width(rods, "node")) + _width(rods, "rod"))
        for rods in content.rods
    )
    sheets = [s for s in (content.membrane, content.container) if s is not None]
    meshes = sum(len(s.mesh(0).points) * (36 * (content.frames if s.moving else 1) + 12) for s in sheets)
    return 5e4 + 0.85 * (bytes_of_rods + meshes)


class PolyData:
    """PolyData over time in a group of a file: cells that stay, points and arrays that are added step by step.

    moving: whether every step has values of its own. check: called for each array that is added; may raise.
    """

    def __init__(self, group: Any, times: np.ndarray, check: Callable[[], None]) -> None:
        self._group, self._steps, self.moving, self._check = group, len(times), True, check
        group.attrs["Version"] = np.array(VERSION, dtype=np.int64)
        group.attrs.create("Type", np.bytes_("PolyData"))  # ASCII of fixed length
        self._at: dict[str, int] = {}
        steps = group.create_group("Steps")
        steps.attrs["NSteps"] = np.int64(len(times))
        steps["Values"] = np.asarray(times, dtype=float)
        steps["PartOffsets"] = np.arange(len(times))
        steps["NumberOfParts"] = np.ones(len(times), dtype=np.int64)
        for name in ("CellOffsets", "ConnectivityIdOffsets"):
            steps[name] = np.zeros((len(times), len(TOPOLOGIES)), dtype=np.int64)

    def cells(self, kind: str, cells: np.ndarray) -> None:
        """Cells [cell, point] of one of the four kinds, for all times."""
        for name in TOPOLOGIES:
            own = cells if name == kind else np.empty((0, 1), dtype=np.int64)
            part = self._group.create_group(name)
            packed = COMPRESSED if len(own) else {}
            part.create_dataset("Connectivity", data=own.ravel().astype(np.int64), **packed)
            part.create_dataset("Offsets", data=np.arange(len(own) + 1) * own.shape[1], **packed)
            part["NumberOfCells"] = np.full(self._steps, len(own))
            part["NumberOfConnectivityIds"] = np.full(self._steps, own.size)

    def add(self, where: str, name: str, values: np.ndarray) -> None:
        """Add the values [step, item, …] of an array at the next steps; one step serves all that follow.

        where: "Points", "PointData" or "CellData"; the name of points is their own.
        """
        self._check()
        path = name if where == "Points" else f"{where}/{name}"
        stacked = values.reshape(-1, *values.shape[2:]).astype(np.float32)
        if path not in self._at:
            self._at[path] = 0
            self._begin(path, where, name, values)
        data = self._group[path]
        data.resize(self._at[path] + len(stacked), axis=0)
        data[self._at[path] :] = stacked
        self._at[path] += len(stacked)

    def _begin(self, path: str, where: str, name: str, values: np.ndarray) -> None:
        """Make an empty array, and say where its values of each step begin."""
        count, rest = values.shape[1], values.shape[2:]
        self._group.create_dataset(
            path, (0, *rest), np.float32, maxshape=(None, *rest), chunks=(count, *rest), **COMPRESSED
        )
        moves = self.moving or self._steps == 1
        begins = np.arange(self._steps) * count if moves else np.zeros(self._steps, dtype=np.int64)
        if where == "Points":
            self._group["NumberOfPoints"] = np.full(self._steps, count)
            self._group["Steps/PointOffsets"] = begins
        else:
            self._group[f"Steps/{where}Offsets/{name}"] = begins


def _parts(content: Content) -> dict[str, Callable[[PolyData], None]]:
    """What fills each file, by its name."""
    found: dict[str, Callable[[PolyData], None]] = {}
    for rods in content.rods:
        found[f"rods_{rods.name}"] = partial(_add_rods, content=content, rods=rods)
    for name, sheet in (("membrane", content.membrane), ("container", content.container)):
        if sheet is not None:
            found[name] = partial(_add_sheet, sheet=sheet, frames=content.frames)
    if content.box is not None:
        found["box"] = partial(_add_box, edges=content.edges)
    return found


def _add_rods(data: PolyData, content: Content, rods: Rods) -> None:
    """Rods where they are drawn, and all their variables."""
    data.cells("Lines", np.arange(rods.count * rods.nodes).reshape(rods.count, rods.nodes))
    for frame in with_progress(range(content.frames), f"VTKHDF: {rods.name}"):
        data.add("Points", "Points", rods.positions(frame).reshape(1, -1, 3))
    names = _variables(rods)
    if rods.coloured and content.selection.colour not in names:
        for frame in range(content.frames):
            data.add("PointData", content.selection.colour, rods.values(frame).reshape(1, -1))
    for name, where in with_progress(list(names.items()), f"VTKHDF: variables of {rods.name}"):
        for part in rods.blocks():
            values = at_frames(rods.data[name], part)
            inner = 3 if where == "node" else 2
            data.add("PointData" if where == "node" else "CellData", name,
                      values.reshape(len(part), -1, *values.shape[inner:]))  # fmt: skip


def _variables(rods: Rods) -> dict[str, str]:
    """Variables with a value, or a vector, at each node or for each rod at each frame; and which of both."""
    found = {}
    for name, variable in rods.data.data_vars.items():
        dims = variable.dims
        if name not in LEFT_OUT and dims[:2] == ("frame", "rod") and len(dims) <= 4:
            node = dims[2:3] == ("node",)
            if len(dims) <= (4 if node else 3):
                found[str(name)] = "node" if node else "rod"
    return found


def _width(rods: Rods, where: str) -> int:
    """Numbers in a frame of each node, or each rod."""
    return sum(
        int(np.prod(rods.data[name].shape[3 if where == "node" else 2 :], dtype=int))
        for name, its in _variables(rods).items()
        if its == where
    )


def _add_sheet(data: PolyData, sheet: Sheet, frames: int) -> None:
    """A membrane or a container, with its curvatures."""
    data.moving = sheet.moving
    data.cells("Polygons", sheet.mesh(0).triangles)
    for frame in with_progress(range(frames if sheet.moving else 1), "VTKHDF: membrane"):
        mesh, found = sheet.mesh(frame), sheet.curvatures(frame)
        data.add("Points", "Points", mesh.points[None])
        data.add("PointData", "Normals", mesh.normals[None])
        data.add("PointData", "gaussian_curvature", found.gaussian[None])
        data.add("PointData", "mean_curvature", found.mean[None])


def _add_box(data: PolyData, edges: np.ndarray) -> None:
    data.moving = False
    data.cells("Lines", np.arange(2 * len(edges)).reshape(-1, 2))
    data.add("Points", "Points", edges.reshape(1, -1, 3))

"""VTKHDF, the HDF5 format of VTK, for ParaView: one block for each ensemble, the membrane and the box, over time.

Rods are lines with the variables of the trajectory as arrays of their points and, where there is one value a rod, of
their cells. What does not move is stored once, and every step refers to it.
https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/vtkhdf_specifications.html
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods.draw.box import edges_of
from warp_rods.draw.files.optional import needed
from warp_rods.draw.files.saved import blocks
from warp_rods.progress import with_progress

if TYPE_CHECKING:
    from warp_rods.draw.content import Content
    from warp_rods.draw.rods import Rods
    from warp_rods.draw.sheet import Sheet

__all__ = ["size", "write"]

VERSION = (2, 1)
TOPOLOGIES = ("Vertices", "Lines", "Polygons", "Strips")
"""The four kinds of cells of PolyData, in the order of the format."""
LEFT_OUT = ("position", "orientation")
"""Variables that are no arrays of points: the points themselves, and quaternions."""


def write(content: Content, path: Path) -> None:
    """Write what is shown, with all variables of its rods, to ``path``; single precision."""
    h5py = needed("h5py", "--vtkhdf")
    with h5py.File(path, "w", track_order=True) as file:
        root = file.create_group("VTKHDF", track_order=True)
        _type(root, "PartitionedDataSetCollection")
        assembly = root.create_group("Assembly", track_order=True)
        writers = _blocks(content)
        for index, (name, write) in enumerate(writers.items()):
            group = root.create_group(name)
            _type(group, "PolyData")
            group.attrs["Index"] = np.int64(index)
            write(Block(group, content.times))
            assembly[name] = h5py.SoftLink(f"/VTKHDF/{name}")


def size(content: Content) -> float:
    """About how many bytes the file has: arrays of single precision, a sixth less by compression."""
    bytes_of_rods = sum(
        content.frames * 4 * rods.count * (rods.nodes * (3 + _width(rods, "node")) + _width(rods, "rod"))
        for rods in content.rods
    )
    sheets = [s for s in (content.membrane, content.container) if s is not None]
    meshes = sum(len(s.mesh(0).points) * 36 * (content.frames if s.moving else 1) for s in sheets)
    return 5e4 + 0.85 * (bytes_of_rods + meshes)


class Block:
    """PolyData over time in a group of the file: cells that stay, points and arrays that are added step by step."""

    def __init__(self, group: Any, times: np.ndarray) -> None:
        self._group, self._steps = group, len(times)
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
            part["Connectivity"] = own.ravel().astype(np.int64)
            part["Offsets"] = np.arange(len(own) + 1) * own.shape[1]
            part["NumberOfCells"] = np.full(self._steps, len(own))
            part["NumberOfConnectivityIds"] = np.full(self._steps, own.size)

    def add(self, where: str, name: str, values: np.ndarray) -> None:
        """Add the values [step, item, …] of an array at the next steps; one step serves all that follow.

        where: "Points", "PointData" or "CellData"; the name of points is their own.
        """
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
            path, (0, *rest), np.float32, maxshape=(None, *rest), chunks=(max(count, 1), *rest), shuffle=True,
            compression="gzip", compression_opts=3,
        )  # fmt: skip
        moves = self.moving or self._steps == 1
        begins = np.arange(self._steps) * count if moves else np.zeros(self._steps, dtype=np.int64)
        if where == "Points":
            self._group["NumberOfPoints"] = np.full(self._steps, count)
            self._group["Steps/PointOffsets"] = begins
        else:
            self._group[f"Steps/{where}Offsets/{name}"] = begins

    moving = True
    """Whether every step has values of its own."""


def _type(group: Any, kind: str) -> None:
    """The attributes that say what a group is; the type is ASCII of fixed length."""
    group.attrs["Version"] = np.array(VERSION, dtype=np.int64)
    group.attrs.create("Type", np.bytes_(kind))


def _blocks(content: Content) -> dict[str, Any]:
    """Functions that write each block, by its name, which has letters, digits and underscores only."""
    found: dict[str, Any] = {}
    for rods in content.rods:
        found[re.sub(r"\W", "_", rods.name)] = lambda block, rods=rods: _write_rods(block, content, rods)
    for name, sheet in (("membrane", content.membrane), ("container", content.container)):
        if sheet is not None:
            found[name] = lambda block, sheet=sheet: _write_sheet(block, sheet, content.frames)
    if content.box is not None:
        found["box"] = lambda block: _write_box(block, content.box)
    return found


def _write_rods(block: Block, content: Content, rods: Rods) -> None:
    """Rods where they are drawn, and all their variables."""
    block.cells("Lines", np.arange(rods.count * rods.nodes).reshape(rods.count, rods.nodes))
    for frame in with_progress(range(content.frames), f"VTKHDF: {rods.name}"):
        block.add("Points", "Points", rods.positions(frame).reshape(1, -1, 3))
    names = _variables(rods)
    if rods.coloured and content.selection.colour not in names:
        for frame in range(content.frames):
            block.add("PointData", content.selection.colour, rods.values(frame).reshape(1, -1))
    for name, where in with_progress(list(names.items()), f"VTKHDF: variables of {rods.name}"):
        for part in blocks(rods, 3):
            values = rods.data[name].isel(frame=list(part)).values
            inner = 3 if where == "node" else 2
            block.add("PointData" if where == "node" else "CellData", name,
                      values.reshape(len(part), -1, *values.shape[inner:]))  # fmt: skip


def _variables(rods: Rods) -> dict[str, str]:
    """Variables with a value, or a vector, at each node or for each rod at each frame; and which of both."""
    found = {}
    for name, data in rods.data.data_vars.items():
        dims = data.dims
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


def _write_sheet(block: Block, sheet: Sheet, frames: int) -> None:
    """A membrane or a container, with its curvatures."""
    block.moving = sheet.moving
    block.cells("Polygons", sheet.mesh(0).triangles)
    for frame in with_progress(range(frames if sheet.moving else 1), "VTKHDF: membrane"):
        mesh, found = sheet.mesh(frame), sheet.curvatures(frame)
        block.add("Points", "Points", mesh.points[None])
        block.add("PointData", "Normals", mesh.normals[None])
        block.add("PointData", "gaussian_curvature", found.gaussian[None])
        block.add("PointData", "mean_curvature", found.mean[None])


def _write_box(block: Block, box: np.ndarray) -> None:
    edges = edges_of(box)
    block.moving = False
    block.cells("Lines", np.arange(2 * len(edges)).reshape(-1, 2))
    block.add("Points", "Points", edges.reshape(1, -1, 3))

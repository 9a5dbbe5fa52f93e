"""The trajectory of a run: a Zarr store with one group for each ensemble, written frame by frame.

The variables of a frame are written first, then its time, then the number of complete frames. However a run ends, the
store can be read up to its last complete frame, by ``open_run`` or by ``xarray.open_datatree``.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr
from xarray.backends import BackendArray
from xarray.core import indexing  # see "How to add a new backend" of xarray; hence the upper bound in pyproject

from warp_rods import arguments
from warp_rods.errors import RunFolderError
from warp_rods.rods.variables import FILAMENT_VARIABLES, SWIMMER_VARIABLES, Variable
from warp_rods.simulation.earlier import labelled
from warp_rods.simulation.store import (
    COMPLETE,
    GROWTH,
    STORE,
    GroupSpec,
    complete_frames,
    create_group,
    dims_of,
    frame_arrays,
    open_store,
    read_array,
)

__all__ = [
    "FILAMENT_VARIABLES",
    "STORE",
    "SWIMMER_VARIABLES",
    "GroupSpec",
    "TrajectoryWriter",
    "Variable",
    "open_run",
]


class _Column:
    """One growing array, with a copy of the chunk that is being filled, so that it is never read back."""

    def __init__(self, array: zarr.Array, frames: int) -> None:
        self.array = array
        self.chunk = np.full((array.chunks[0], *array.shape[1:]), array.fill_value, array.dtype)
        filled = frames % len(self.chunk)
        self.chunk[:filled] = array[frames - filled : frames]

    def put(self, frame: int, values: Any) -> None:
        first = frame - frame % len(self.chunk)
        if frame == first:
            self.chunk[...] = self.array.fill_value
        if frame >= self.array.shape[0]:
            self.resize(frame - frame % GROWTH + GROWTH)
        self.chunk[frame - first] = values
        self.array[first : first + len(self.chunk)] = self.chunk

    def resize(self, frames: int) -> None:
        self.array.resize((frames, *self.array.shape[1:]))


class TrajectoryWriter:
    """Appends frames to a store: ``create`` or ``resume`` it, ``append`` frames, ``close`` it.

    ``frames`` is the number of complete frames.
    """

    def __init__(self, root: zarr.Group, frames: int) -> None:
        self.frames = frames
        self._root = root
        self._complete = read_array(root, COMPLETE)
        self._groups = {
            name: {label: _Column(array, frames) for label, array in frame_arrays(group).items()}
            for name, group in root.groups()
        }

    @classmethod
    def create(
        cls, path: str | Path, groups: Mapping[str, GroupSpec], attributes: Mapping[str, Any]
    ) -> TrajectoryWriter:
        """Create a store at ``path``; its root gets ``attributes`` (title, scene, seed, units, …).

        Raises RunFolderError if ``path`` exists.
        """
        path = Path(path)
        if path.exists():
            raise RunFolderError(f"{path} exists already: remove it, or choose another folder.")
        root = zarr.create_group(path, attributes={"warp_rods_version": version("warp-rods"), **attributes})
        root.create_array(COMPLETE, shape=(), dtype="int64", dimension_names=())
        for name, spec in groups.items():
            create_group(root, name, spec)
        return cls(root, 0)

    @classmethod
    def resume(
        cls, path: str | Path, frames: int | None = None, attributes: Mapping[str, Any] | None = None
    ) -> TrajectoryWriter:
        """Continue a store after its complete frames, or after the first ``frames`` of them; later frames are removed.

        ``attributes`` of the root are updated: the scene may end later than before.

        Raises RunFolderError if there is no store, or it has fewer than ``frames`` complete frames.
        """
        root = open_store(Path(path), "r+")
        complete = complete_frames(root)
        keep = complete if frames is None else frames
        if not 0 <= keep <= complete:
            raise RunFolderError(f"{path} has {complete} complete frames, {keep} are needed to resume the run.")
        root.attrs.update(attributes or {})
        read_array(root, COMPLETE)[...] = keep
        for _, group in root.groups():
            for array in frame_arrays(group).values():
                array.resize((keep, *array.shape[1:]))
        return cls(root, keep)

    def append(self, time: float, frames: Mapping[str, Mapping[str, np.ndarray]]) -> None:
        """Save one frame: ``frames[group][variable]``, every variable of every group, without the frame axis.

        Raises ValueError, and writes nothing, if a group, variable or shape is not the one declared.
        """
        self._check(frames)
        for name, columns in self._groups.items():
            for variable, values in frames[name].items():
                columns[variable].put(self.frames, values)
        for columns in self._groups.values():
            columns["time"].put(self.frames, time)
        self.frames += 1
        self._complete[...] = self.frames

    def describe(self, **attributes: Any) -> None:
        """Set attributes of the root of the store."""
        self._root.attrs.update(attributes)

    @property
    def messages(self) -> list[str]:
        """The messages of the run so far, from the store."""
        return list(self._root.attrs.get("messages", []))  # type: ignore[arg-type]

    def close(self) -> None:
        """Shorten the arrays to the frames appended, all of which are on disk."""
        for columns in self._groups.values():
            for column in columns.values():
                column.resize(self.frames)
        self._groups = {}

    def _check(self, frames: Mapping[str, Mapping[str, np.ndarray]]) -> None:
        _same_names("groups", frames, self._groups)
        for name, columns in self._groups.items():
            _same_names(f"variables of {name}", {"time": None, **frames[name]}, columns)
            for variable, values in frames[name].items():
                declared = columns[variable].array.shape[1:]
                if np.shape(values) != declared:
                    raise ValueError(f"{name}/{variable}: shape {np.shape(values)}, declared {declared}")


def open_run(run_dir: str | Path) -> xr.DataTree:
    """The trajectory of a run, complete frames only, read lazily: one group for each ensemble.

    The run may still be in progress, or have been killed. Raises RunFolderError if there is no run.
    """
    root = open_store(arguments.path("run_dir", run_dir) / STORE, "r")
    frames = complete_frames(root)
    attributes = dict(root.attrs)
    # Each group keeps the scene, which describes its membrane and its box.
    scene = {key: text for key, text in attributes.items() if key == "scene"}
    tree = {name: _dataset(group, frames).assign_attrs(scene) for name, group in sorted(root.groups())}
    return xr.DataTree.from_dict({"/": xr.Dataset(attrs=attributes), **tree})


class _Frames(BackendArray):
    """A Zarr array up to its last complete frame, read lazily by xarray."""

    def __init__(self, array: zarr.Array, shape: tuple[int, ...]) -> None:
        self.array, self.shape, self.dtype = array, shape, array.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> Any:
        first = slice(*key[0].indices(self.shape[0])) if isinstance(key[0], slice) else key[0]
        return self.array.oindex[(first, *key[1:])]


def _dataset(group: zarr.Group, frames: int) -> xr.Dataset:
    """The variables of an ensemble, read lazily; labels of dimensions are read at once, as in xarray."""
    variables = {}
    for name, array in sorted(group.arrays()):
        dims = dims_of(array)
        if dims == (name,):
            variables[name] = xr.Variable(dims, np.asarray(array[...]).tolist())
            continue
        # Arrays of a run that is in progress or was stopped are longer than the number of complete frames.
        shape = (frames, *array.shape[1:]) if dims[:1] == ("frame",) else array.shape
        lazy = indexing.LazilyIndexedArray(_Frames(array, shape))
        variables[name] = xr.Variable(dims, lazy, dict(array.attrs))
    dataset = xr.Dataset(variables).set_coords(["time", "s"])
    return dataset if set(dataset.dims) & set(dataset.indexes) else labelled(dataset)


def _same_names(what: str, given: Mapping[str, Any], declared: Mapping[str, Any]) -> None:
    if given.keys() != declared.keys():
        raise ValueError(f"{what}: given {sorted(given)}, declared {sorted(declared)}")

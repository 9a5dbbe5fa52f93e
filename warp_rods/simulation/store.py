"""The Zarr store of a trajectory: groups of arrays and their layout."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import zarr

from warp_rods.errors import RunFolderError
from warp_rods.rods.variables import ARC, TIME, Variable

STORE = "trajectory.zarr"
COMPLETE = "_complete_frames"
# A chunk is rewritten for each of its frames (atomically, by renaming), so it is kept small.
_CHUNK_BYTES = 8_192
# Number of frames by which arrays grow, a multiple of every chunk; growing an array takes as long as writing a frame.
GROWTH = 64


@dataclass(frozen=True)
class GroupSpec:
    """The group of one ensemble: ``rods`` rods of ``nodes`` nodes, the variables of a frame, and static arrays.

    ``static`` maps a name to its variable (without the dimension ``frame``) and its values.
    """

    rods: int
    nodes: int
    variables: Mapping[str, Variable]
    static: Mapping[str, tuple[Variable, np.ndarray]] = field(default_factory=dict)

    def shape(self, variable: Variable) -> tuple[int, ...]:
        """The shape of one frame of a variable."""
        sizes = {"rod": self.rods, "node": self.nodes}
        sizes |= {dim: len(labels) for dim, labels in variable.labels.items()}
        return tuple(sizes[dim] for dim in variable.dims if dim != "frame")

    def labels(self) -> dict[str, tuple[str, ...]]:
        """The labels of each dimension that has labels."""
        variables = [*self.variables.values(), *(variable for variable, _ in self.static.values())]
        return {dim: labels for variable in variables for dim, labels in variable.labels.items()}


def create_group(root: zarr.Group, name: str, spec: GroupSpec) -> None:
    """Create the group of an ensemble: static arrays with their values, the others without frames."""
    # xarray.open_datatree distinguishes coordinates from data by the CF attribute "coordinates".
    group = root.create_group(name, attributes={"coordinates": "time s"})
    for dim, labels in spec.labels().items():
        coordinate = group.create_array(dim, shape=(len(labels),), dtype="str", compressors=None, dimension_names=[dim])
        coordinate[...] = np.array(labels)
    static = {"s": (ARC, np.linspace(-0.5, 0.5, spec.nodes)), **spec.static}
    for label, (variable, values) in static.items():
        shape = spec.shape(variable)
        _create_array(group, label, variable, shape, shape)[...] = np.broadcast_to(values, shape)
    for label, variable in {**spec.variables, "time": TIME}.items():
        shape = spec.shape(variable)
        frame_bytes = int(np.prod(shape)) * np.dtype(variable.dtype).itemsize
        frames = next(n for n in (64, 32, 16, 8, 4, 2, 1) if n * frame_bytes <= _CHUNK_BYTES or n == 1)
        _create_array(group, label, variable, (0, *shape), (frames, *shape))


def _create_array(
    group: zarr.Group, name: str, variable: Variable, shape: tuple[int, ...], chunks: tuple[int, ...]
) -> zarr.Array:
    return group.create_array(
        name,
        shape=shape,
        chunks=chunks,
        compressors=None,  # positions hardly compress, and compression would take a third of the time
        dtype=variable.dtype,
        fill_value=np.nan if variable.dtype.startswith("float") else 0,
        dimension_names=variable.dims,
        attributes=variable.attributes,
    )


def open_store(path: Path, mode: Any) -> zarr.Group:
    """The root of the store at ``path``; raises RunFolderError if there is none."""
    if not (path / "zarr.json").is_file():
        raise RunFolderError(
            f"There is no run in {path.parent}: {path.name} is missing. "
            "Give the folder that `warp-rods run SCENE --out DIR` wrote."
        )
    try:
        return zarr.open_group(path, mode=mode, use_consolidated=False)
    except Exception as fault:
        raise RunFolderError(f"{path} cannot be read ({fault}): run the scene again.") from fault


def read_array(group: zarr.Group, name: str) -> zarr.Array:
    """The array of this name."""
    array = group[name]
    assert isinstance(array, zarr.Array)
    return array


def complete_frames(root: zarr.Group) -> int:
    """The number of complete frames; raises RunFolderError if the store is not a trajectory of this package."""
    if COMPLETE not in root:
        raise RunFolderError(f"{root.store_path} is not a trajectory of warp-rods: run the scene again.")
    return int(np.asarray(read_array(root, COMPLETE)[...]))


def frame_arrays(group: zarr.Group) -> dict[str, zarr.Array]:
    """The arrays of a group that have a dimension ``frame``, by name."""
    arrays = sorted(group.arrays())
    return {name: array for name, array in arrays if dims_of(array)[:1] == ("frame",)}


def dims_of(array: zarr.Array) -> tuple[str, ...]:
    """The names of the dimensions of an array."""
    names = getattr(array.metadata, "dimension_names", None)  # arrays of Zarr's format 2 have none
    return tuple(name or "" for name in names or ())

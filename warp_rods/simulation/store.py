"""The Zarr store of a trajectory: groups of arrays and their layout."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import zarr
from zarr.codecs import Crc32cCodec

from warp_rods.rods.variables import ARC, TIME, Variable

STORE = "trajectory.zarr"

LARGE_FRAME = 512
"""Bytes of a frame from which on it is a chunk of its own in a shard: reading and decoding a chunk takes about 0.1 ms,
whatever its size."""
_CHUNK_BYTES = 131_072
"""Size of a chunk of several frames; it is written again for each of them."""
_FILE_BYTES = 268_435_456
"""Largest size of a shard of several frames."""
_MOST_IN_A_FILE = 4096
"""Largest number of frames in a file; the index of a shard is read with every frame."""


@dataclass(frozen=True)
class GroupSpec:
    """The group of one ensemble: ``rods`` rods of ``nodes`` nodes, the variables of a frame, and static arrays.

    ``static`` maps a name to its variable (without the dimension ``frame``) and its values. ``frames_per_file``: the
    largest number of frames in a file; None for the default.
    """

    rods: int
    nodes: int
    variables: Mapping[str, Variable]
    static: Mapping[str, tuple[Variable, np.ndarray]] = field(default_factory=dict)
    frames_per_file: int | None = None

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
        array = group.create_array(dim, shape=(len(labels),), dtype="str", dimension_names=[dim], **_COMMON)
        array[...] = np.array(labels)
    static = {"s": (ARC, np.linspace(-0.5, 0.5, spec.nodes)), **spec.static}
    for label, (variable, values) in static.items():
        _create_static(group, label, variable, np.broadcast_to(values, spec.shape(variable)))
    for label, variable in {**spec.variables, "time": TIME}.items():
        _create_growing(group, label, variable, spec.shape(variable), spec.frames_per_file)


_COMMON: Any = {
    # Positions hardly compress, compression would take a third of the time, and sizes of chunks would not be known.
    "compressors": [Crc32cCodec()],
    "chunk_key_encoding": {"name": "default", "separator": "."},  # one folder for each array
}


def _create_static(group: zarr.Group, name: str, variable: Variable, values: np.ndarray) -> None:
    """An array with its values. Where they are all equal they are its fill value, and no file is needed."""
    first = values.flat[0]
    equal = bool((values == first).all())
    array = group.create_array(
        name, shape=values.shape, chunks=values.shape, dtype=variable.dtype, fill_value=first if equal else np.nan,
        dimension_names=variable.dims, attributes=variable.attributes, config={"write_empty_chunks": not equal},
        **_COMMON,
    )  # fmt: skip
    array[...] = values


def _create_growing(group: zarr.Group, name: str, variable: Variable, shape: tuple[int, ...], most: int | None) -> None:
    """An array without frames: large frames each a chunk in a shard, several small ones in one chunk."""
    size, count = _layout(variable, shape, most)
    files = (count, *shape)
    layout: dict[str, Any] = {"chunks": files}
    if size >= LARGE_FRAME:
        layout = {"chunks": (1, *shape), "shards": {"shape": files, "index_location": "start"}}
    group.create_array(
        name,
        shape=(0, *shape),
        **layout,
        dtype=variable.dtype,
        # Readers show the fill value where a file is missing, and a status of 0 would mean that all is well.
        fill_value=np.nan if variable.dtype.startswith("float") else -1,
        dimension_names=variable.dims,
        attributes=variable.attributes,
        **_COMMON,
    )


def _layout(variable: Variable, shape: tuple[int, ...], most: int | None) -> tuple[int, int]:
    """Bytes of a frame, and frames in a file."""
    size = math.prod(shape) * np.dtype(variable.dtype).itemsize
    return size, max(1, min(most or _MOST_IN_A_FILE, (_FILE_BYTES if size >= LARGE_FRAME else _CHUNK_BYTES) // size))


def stored_bytes(spec: GroupSpec, frames: int) -> int:
    """Bytes of the files of the growing arrays of a group with this many frames; see ``chunks.py``."""
    total = 0
    for variable in (*spec.variables.values(), TIME):
        size, count = _layout(variable, spec.shape(variable), spec.frames_per_file)
        files = -(-frames // count)
        if size >= LARGE_FRAME:  # an index for each file, and a checksum for each frame
            total += files * (16 * count + 4) + frames * (size + 4)
        else:
            total += files * (size * count + 4)
    return total


def dims_of(array: zarr.Array) -> tuple[str, ...]:
    """The names of the dimensions of an array."""
    names = getattr(array.metadata, "dimension_names", None)  # arrays of Zarr's format 2 have none
    return tuple(name or "" for name in names or ())

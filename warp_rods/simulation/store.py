"""The Zarr store of a trajectory: groups of arrays and their layout."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.rods.variables import ARC, TIME, Variable
from warp_rods.simulation.files import TRAJECTORY
from warp_rods.simulation.zarr_format import write_array, write_group, write_labels, write_values

STORE = TRAJECTORY

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
    largest number of frames in a file; None for the default. ``units``: those of the files from those of a variable.
    """

    rods: int
    nodes: int
    variables: Mapping[str, Variable]
    static: Mapping[str, tuple[Variable, np.ndarray]] = field(default_factory=dict)
    frames_per_file: int | None = None
    units: Callable[[str], str] = str

    def attributes(self, variable: Variable) -> dict[str, Any]:
        """The attributes of the array of a variable."""
        return replace(variable, units=self.units(variable.units)).attributes

    def shape(self, variable: Variable) -> tuple[int, ...]:
        """The shape of one frame of a variable."""
        sizes = {"rod": self.rods, "node": self.nodes}
        sizes |= {dim: len(labels) for dim, labels in variable.labels.items()}
        return tuple(sizes[dim] for dim in variable.dims if dim != "frame")

    def labels(self) -> dict[str, tuple[str, ...]]:
        """The labels of each dimension that has labels."""
        variables = [*self.variables.values(), *(variable for variable, _ in self.static.values())]
        return {dim: labels for variable in variables for dim, labels in variable.labels.items()}


def create_group(folder: Path, spec: GroupSpec) -> None:
    """Create the group of an ensemble in a new folder: static arrays with their values, the others without frames."""
    # xarray.open_datatree distinguishes coordinates from data by the CF attribute "coordinates".
    write_group(folder, {"coordinates": "time s"})
    for dim, labels in spec.labels().items():
        write_labels(folder / dim, labels)
    static = {"s": (ARC, np.linspace(-0.5, 0.5, spec.nodes)), **spec.static}
    for label, (variable, values) in static.items():
        whole = np.broadcast_to(values, spec.shape(variable)).astype(variable.dtype)
        write_values(folder / label, whole, variable.dims, spec.attributes(variable))
    for label, variable in {**spec.variables, "time": TIME}.items():
        _create_growing(folder / label, variable, spec)


def _create_growing(folder: Path, variable: Variable, spec: GroupSpec) -> None:
    """An array without frames: large frames each a chunk in a shard, several small ones in one chunk."""
    shape = spec.shape(variable)
    size, count = _layout(variable, shape, spec.frames_per_file)
    # Readers show the fill value where a file is missing, and a status of 0 would mean that all is well.
    fill = math.nan if variable.dtype.startswith("float") else -1
    chunk = (1, *shape) if size >= LARGE_FRAME else None
    write_array(
        folder, (0, *shape), variable.dtype, fill, variable.dims, spec.attributes(variable),
        file_shape=(count, *shape), chunk=chunk,
    )  # fmt: skip


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

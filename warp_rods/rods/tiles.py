"""Fields of tiles of rods (``kernels/lanes.py``), and the same values as NumPy arrays [rod, …]."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_rods.kernels.lanes import FIELDS, WIDTH, Lanes
from warp_rods.kernels.multistep import Weights


def tiles_of(rods: int) -> int:
    """The number of tiles of so many rods."""
    return -(-rods // WIDTH)


def is_tiled(array: wp.array) -> bool:
    """Whether the elements of a device array are those of a whole tile."""
    return array.dtype in (*FIELDS, Weights)


def tiled(values: np.ndarray, dtype: Any = Lanes, device: Any = None) -> wp.array:
    """A device array [tile, …] of ``values`` [rod, …]; lanes beyond the last rod repeat it."""
    return wp.array(_in_tiles(values, dtype), dtype=dtype, device=device)


class Tiled:
    """A device array [tile, …] of ``rods`` rods, read and set as a NumPy array [rod, …, component]."""

    def __init__(self, array: wp.array, rods: int):
        self.array, self.rods = array, rods

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the NumPy array."""
        return (self.rods, *self.array.shape[1:], *self.array.dtype._shape_[:-1])  # type: ignore[attr-defined]

    def numpy(self) -> np.ndarray:
        """A copy on the host."""
        values = np.moveaxis(self.array.numpy(), -1, 1)
        return values.reshape(-1, *values.shape[2:])[: self.rods].copy()  # on the CPU they are a view of the array

    def assign(self, values: np.ndarray) -> None:
        """Set all rods."""
        self.array.assign(_in_tiles(np.asarray(values), self.array.dtype))


def _in_tiles(values: np.ndarray, dtype: Any) -> np.ndarray:
    count = len(values)
    rods = np.minimum(np.arange(tiles_of(count) * WIDTH), count - 1)
    parts = values[rods].reshape(-1, WIDTH, *values.shape[1:])
    return np.ascontiguousarray(np.moveaxis(parts, 1, -1), dtype=float)

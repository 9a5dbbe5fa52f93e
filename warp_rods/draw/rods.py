"""The rods of one ensemble as they are drawn: where they are and their values, at each chosen frame."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import xarray as xr

from warp_rods.draw.colours import Colour, at_frames
from warp_rods.rods.status import Status

__all__ = ["Rods"]

_READ_AT_ONCE = 16e6
"""Bytes: many frames are read at once, as a read of Zarr costs milliseconds, but not a whole run."""


class Rods:
    """One ensemble at the chosen frames; a frame is given by its number among these, from 0.

    name, count, nodes; radius of the tubes as drawn; data: the whole trajectory of the ensemble; frames: the numbers of
    the chosen ones in it; coloured: whether it has the quantity of the colours. Frames are read in blocks, so that
    asking for one after the other is cheap.
    """

    def __init__(
        self, name: str, data: xr.Dataset, frames: range, colour: Colour, radius: float, period: np.ndarray
    ) -> None:
        self.name, self.data, self.frames, self.radius = name, data, frames, radius
        self.count, self.nodes = data.sizes["rod"], data.sizes["node"]
        self.coloured = colour.is_in(data)
        self._colour, self._period = colour, period
        self._block = max(1, int(_READ_AT_ONCE / (8 * 4 * self.count * self.nodes)))
        self._read: dict[str, tuple[int, np.ndarray]] = {}  # the block of each variable that was read last

    def positions(self, frame: int) -> np.ndarray:
        """Centre lines [rod, node, 3] as drawn: in the periodic box, and lost rods where they were frozen."""
        return into_box(self.variable("position", frame), self._period)

    def values(self, frame: int) -> np.ndarray:
        """Values of the colour [rod, node]; NaN for rods without one, as lost ones."""
        if not self.coloured:
            return np.full((self.count, self.nodes), np.nan)
        values = self._in_block("", frame, lambda frames: self._colour.values(self.data, frames))
        return self.without_lost(values, frame)

    def lost(self, frame: int) -> np.ndarray:
        """Which rods have failed by this frame, [rod]; what is saved of them since is their last valid state."""
        return self.variable("status", frame) != Status.OK

    def without_lost(self, values: np.ndarray, frame: int) -> np.ndarray:
        """Values [rod, …] at this frame, NaN for lost rods."""
        lost = self.lost(frame).reshape(-1, *[1] * (values.ndim - 1))
        return np.where(lost, np.nan, values)

    def each(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """``positions`` and ``values`` of all chosen frames in turn."""
        for frame in range(len(self.frames)):
            yield self.positions(frame), self.values(frame)

    def variable(self, name: str, frame: int) -> np.ndarray:
        """Another variable of the trajectory at a chosen frame, as saved."""
        return self._in_block(name, frame, lambda frames: at_frames(self.data[name], frames))

    def blocks(self) -> Iterator[range]:
        """The chosen frames, as numbers in the trajectory, in parts of a limited size: a read costs milliseconds."""
        for first in range(0, len(self.frames), self._block):
            yield self.frames[first : first + self._block]

    def _in_block(self, name: str, frame: int, read: Callable[[range], np.ndarray]) -> np.ndarray:
        """One frame of the block that was read last, or of that of this frame, which is then read."""
        first = frame - frame % self._block
        if self._read.get(name, (-1, None))[0] != first:
            self._read[name] = first, read(self.frames[first : first + self._block])
        return self._read[name][1][frame - first]


def into_box(position: np.ndarray, period: np.ndarray) -> np.ndarray:
    """Rods [rod, node, 3], each shifted as a whole so that its middle is in the box; ``period`` [3] is 0 where open."""
    divisor = np.where(period > 0, period, np.inf)
    middle = position[:, position.shape[1] // 2, None]
    return position - np.where(period > 0, period, 0.0) * np.rint(middle / divisor)

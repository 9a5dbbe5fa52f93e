"""Centre lines in a box that may be periodic, and which of them come closer than a clearance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from warp_rods.device import exclusive
from warp_rods.device import start as start_warp
from warp_rods.kernels.contact import segments as kernels

__all__ = ["CentreLines", "OccupiedSpace", "launch"]

FEW_CELLS, CELLS_PER_SEGMENT, FEWER = 4096, 4, 0.9
"""At most so many cells, or so many for each segment."""
WIDER = 1.1
"""Cells have room for segments that are longer by this factor than those seen so far."""


@dataclass(frozen=True)
class OccupiedSpace:
    """Centre lines ``others`` [rod, node, 3] of other rods, in a box of periods [3], 0 along an axis without one."""

    others: Sequence[np.ndarray]
    period: np.ndarray


class CentreLines:
    """Centre lines as chains of straight segments, which are found by the cells of a grid; on the host.

    Two lines that come closer than the ``clearance`` touch. Those of the occupied ``space`` are in the grid from the
    start, and there is room for ``rods`` more of ``nodes`` nodes each. A line of one node is a segment of length zero;
    a segment that is not finite touches nothing.
    """

    def __init__(self, space: OccupiedSpace, clearance: float, rods: int = 0, nodes: int = 1):
        start_warp()
        self._nodes, self._period = nodes, np.asarray(space.period, dtype=float)
        self.present = sum(map(len, space.others))
        """The number of lines in the grid, which are the first ones."""
        each = [np.full(len(lines), lines.shape[1]) for lines in (*space.others, np.empty((rods, nodes)))]
        self.chains = _chains(np.concatenate(each))
        self.chains.clearance, self.chains.period = clearance, wp.vec3d(*self._period)
        self.node = self.chains.node.numpy()
        if self.present:
            given = np.concatenate([lines.reshape(-1, 3) for lines in space.others])
            self.node[: len(given)] = given
        self._make_grid(_extent(self.node), max(map(_longest_segment, space.others), default=0.0))

    def _make_grid(self, extent: np.ndarray, longest: float) -> None:
        """Put the lines that are present into cells that are wide enough for segments of this length.

        extent [3]: of all lines, about.
        """
        chains = self.chains
        chains.longest = WIDER * longest
        width = max(chains.clearance + chains.longest, np.finfo(float).tiny)
        cells, per_length = _cells(self._period, extent, width, max(FEW_CELLS, CELLS_PER_SEGMENT * len(chains.rod)))
        chains.cells, chains.cells_per_length = wp.vec3i(*cells.tolist()), wp.vec3d(*per_length)
        chains.newest = wp.full(int(cells.prod()), -1, dtype=wp.int32, device="cpu")
        launch(kernels.insert_rods, chains, 0, self.present)

    def _put(self, lines: np.ndarray) -> None:
        """Set the nodes of the rods after those that are present."""
        begin = int(self.chains.begin.numpy()[self.chains.first.numpy()[self.present]]) if len(lines) else 0
        self.node[begin : begin + lines.shape[0] * self._nodes] = lines.reshape(-1, 3)
        if (longest := _longest_segment(lines)) > self.chains.longest:
            end = begin + lines.shape[0] * self._nodes
            self._make_grid(_extent(self.node[:end]), longest)

    def add(self, lines: np.ndarray) -> None:
        """Put ``lines`` [rod, node, 3] into the grid, too."""
        self._put(lines)
        launch(kernels.insert_rods, self.chains, self.present, len(lines))
        self.present += len(lines)

    def those_that_fit(self, lines: np.ndarray) -> np.ndarray:
        """Which of ``lines`` [rod, node, 3] touch none that is present, and no earlier one that fits [rod]."""
        self._put(lines)
        fits = wp.zeros(len(lines), dtype=wp.int32, device="cpu")
        launch(kernels.insert_rods_that_fit, self.chains, self.present, fits)
        launch(kernels.remove_rods, self.chains, self.present, fits)
        return fits.numpy().astype(bool)

    def count_touching(self, most: int) -> int:
        """The number of pairs of lines that touch; about ``most`` where there are more."""
        self.chains.newest.fill_(-1)
        last_touched = wp.full(self.present, -1, dtype=wp.int32, device="cpu")
        count = wp.zeros(1, dtype=wp.int32, device="cpu")
        launch(kernels.count_touching, self.chains, last_touched, most, count)
        return int(count.numpy()[0])


def launch(kernel: wp.Kernel, *inputs: Any) -> None:
    """Run a kernel on the host in a single thread."""
    with exclusive:
        wp.launch(kernel, dim=1, inputs=list(inputs), device="cpu")


def _chains(nodes: np.ndarray) -> Any:
    """The struct of segments of rods with so many nodes [rod], all nodes at the origin."""
    each = np.maximum(nodes - 1, 1)
    first = np.concatenate([[0], np.cumsum(each)])
    rod = np.repeat(np.arange(len(nodes)), each)
    # Every rod but the first begins one node further than its segments would without a gap.
    begin = np.arange(first[-1]) + np.repeat(np.cumsum(nodes) - nodes - first[:-1], each)
    chains = kernels.Segments()
    for name, values in (("first", first), ("rod", rod), ("begin", begin), ("end", begin + (nodes > 1)[rod])):
        setattr(chains, name, wp.array(values.astype(np.int32), device="cpu"))
    chains.node = wp.zeros(int(nodes.sum()), dtype=wp.vec3d, device="cpu")
    chains.cell, chains.older = (wp.zeros(len(rod), dtype=wp.int32, device="cpu") for _ in range(2))
    return chains


def _cells(period: np.ndarray, extent: np.ndarray, width: float, most: int) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of cells [3] along the axes, after which they repeat, and cells per length [3]; none is narrower.

    On a periodic axis they divide the period.
    """
    cells = np.clip(np.where(period > 0, period, extent) // width + (period == 0), 1, most).astype(int)
    while cells.astype(float).prod() > most:
        cells[np.argmax(cells)] = FEWER * cells.max()
    return cells, np.where(period > 0, cells / np.where(period > 0, period, 1.0), 1 / width)


def _extent(points: np.ndarray) -> np.ndarray:
    """Of points [n, 3] along each axis, as far as they are finite."""
    finite = points[np.isfinite(points).all(axis=1)]
    return np.ptp(finite, axis=0) if len(finite) else np.zeros(3)


def _longest_segment(lines: np.ndarray) -> float:
    """The largest length of a segment of lines [rod, node, 3], as far as they are finite."""
    along = np.diff(lines, axis=1)
    squares = np.einsum("rni,rni->rn", along, along)
    return float(np.sqrt(squares.max(initial=0.0, where=np.isfinite(squares))))

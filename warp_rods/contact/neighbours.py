"""Steric forces between the rods of all ensembles of a scene, from neighbour lists on one hash grid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import warp as wp

from warp_rods.device import Shared, exclusive
from warp_rods.device import device as device_of
from warp_rods.kernels.contact import neighbour_list, pair_lanes, steric
from warp_rods.kernels.layout import per_node, to_host
from warp_rods.rods.ensemble import Ensemble
from warp_rods.rods.recorded import Recorded, RecordedInThreads
from warp_rods.rods.slices import thread_slices

CELLS = 64
"""Cells of the grid along an axis without a period. The grid wraps around, so it covers scenes of any extent."""
MOST_CELLS = 2**21
"""Largest number of cells of the grid: 16 MB."""
PLACES = 64
"""Initial length of the lists."""
MARGIN = 1.25
"""Lists that turn out too short become longer than needed by this factor."""


class Neighbours:
    """Regularised repulsion of strength g0, range a and core ε between the nodes of ``ensembles`` (5.39).

    ``apply`` writes the force per length, and its stiffness K, at the present positions to the arrays of each ensemble.
    It uses lists of the neighbours within the cut-off and a ``skin`` (default ε), and rebuilds them when a node has
    moved by half the skin. period [3]: of the box along each axis, 0 for an axis without one; the nearest image of each
    pair counts. Rods that are frozen do not act on others.
    """

    def __init__(
        self,
        ensembles: Sequence[Ensemble],
        strength: float,
        range: float,
        core: float,
        device: Any = None,
        *,
        period: Any = (0.0, 0.0, 0.0),
        skin: float | None = None,
    ):
        self.strength, self.range, self.core = strength, range, core
        self.skin = core if skin is None else skin
        self._ensembles, self._device = list(ensembles), device_of(device)
        # Read before any recording: an ensemble may have to allocate its forces first, and then compute its frames.
        forces = [e.force_array for e in self._ensembles]
        self._arrays = [
            (e.position_array, e.spacing_array, e.status_array, f, e.contact_stiffness_array)
            for e, f in zip(self._ensembles, forces, strict=True)
        ]
        self._yukawa = _yukawa(strength, range, core)
        self._first = [0, *np.cumsum([e.count * e.nodes for e in self._ensembles]).tolist()]
        with exclusive:
            self._allocate(np.asarray(period, dtype=float))
        self._record()
        self._listed = False

    @property
    def outdated(self) -> bool:
        """Whether an ensemble has replaced its arrays since this object was made: then make a new one."""
        known = (position for position, *_ in self._arrays)
        return any(e.position_array is not position for e, position in zip(self._ensembles, known, strict=True))

    @property
    def cutoff(self) -> float:
        """Pairs farther apart do not interact."""
        return steric.CUTOFF * self.range

    @property
    def threads(self) -> int:
        """The number of threads that share the sums over pairs."""
        return self._sum_pairs.threads

    @property
    def count(self) -> int:
        """The number of nodes of all ensembles."""
        return self._first[-1]

    def _allocate(self, period: np.ndarray) -> None:
        count, device = self.count, self._device
        points = neighbour_list.Points()
        for name in ("position", "last_position", "listed_position", "cell"):
            setattr(points, name, wp.zeros(count, dtype=wp.vec3d, device=device))
        for name in ("weight", "arc_length", "excluded"):
            setattr(points, name, wp.zeros(count, dtype=wp.float64, device=device))
        points.largest_moves = wp.zeros(2, dtype=wp.float64, device=device)
        self._moves = Shared(points.largest_moves)
        nodes = [np.repeat(e.nodes, e.count) for e in self._ensembles]
        rod = np.repeat(np.arange(sum(map(len, nodes))), np.concatenate(nodes))
        points.rod = wp.array(rod.astype(np.int32), device=device)
        self._blocks = _blocks(np.concatenate(nodes))
        cells, cells_per_length = _grid(period, self.cutoff + self.skin)
        points.period, points.cells_per_length = wp.vec3d(*period), wp.vec3d(*cells_per_length)
        self._points = points
        x, y, z = cells.tolist()
        self._grid = wp.HashGrid(x, y, z, device=device, dtype=wp.float64)
        self._grid.reserve(count)
        self._sums = steric.PairSums()
        self._sums.force = wp.zeros(count, dtype=wp.vec3d, device=device)
        self._sums.energy = wp.zeros(count, dtype=wp.float64, device=device)
        self._sums.stiffness = wp.zeros(count, dtype=wp.mat33d, device=device)
        self._allocate_lists(PLACES)

    def _allocate_lists(self, places: int) -> None:
        self._lists = neighbour_list.Lists()
        for name, values in zip(("first", "size", "block"), self._blocks, strict=True):
            setattr(self._lists, name, wp.array(values.astype(np.int32), device=self._device))
        blocks = len(self._blocks[0])
        self._lists.neighbour = per_node(blocks, places, wp.int32, self._device)
        self._lists.count = wp.zeros(blocks, dtype=wp.int32, device=self._device)

    def _record(self) -> None:
        self._collect = Recorded(self._launch_collect, self._device)
        self._keep = Recorded(self._launch_keep, self._device)
        shared: tuple[int, int] = (
            (self.count, 1) if self._device.is_cuda else (len(self._blocks[0]), neighbour_list.BLOCK)
        )
        slices = thread_slices(*shared, self._device)
        self._sum_pairs = RecordedInThreads([partial(self._launch_sum_pairs, s) for s in slices], self._device)
        self._distribute = Recorded(self._launch_distribute, self._device)

    def apply(self) -> float:
        """Write force and stiffness per length at the present positions; rebuild the lists first if they do not hold.

        Returns the largest displacement of a node since the last ``keep``; length.
        """
        since_kept, since_listed = self._largest_moves()
        if not self._listed or since_listed > self.skin / 2:
            self.rebuild_lists()
        self._sum_pairs()
        self._distribute()
        return since_kept

    def keep(self) -> None:
        """Count displacements from the present positions on."""
        self._keep()

    @property
    def kept(self) -> np.ndarray:
        """The positions of the last ``keep`` [node, 3], which can be set."""
        with exclusive:
            return to_host(self._points.last_position)

    @kept.setter
    def kept(self, positions: np.ndarray) -> None:
        with exclusive:
            self._points.last_position.assign(positions)

    def _largest_moves(self) -> tuple[float, float]:
        """The largest displacement of a node since the last ``keep``, and since the lists were built; length."""
        self._collect()
        since_kept, since_listed = map(math.sqrt, self._moves.read())
        return since_kept, since_listed

    def rebuild_lists(self) -> None:
        """Build the lists for the present positions."""
        with exclusive:
            self._collect()
            points = self._points
            wp.launch(neighbour_list.set_listed_positions, dim=self.count, inputs=[points], device=self._device)
            self._grid.build(points.cell, wp.float64(1.0))
            while not self._fill_lists():
                pass
            self._listed = True

    def _fill_lists(self) -> bool:
        """Fill the lists. If they are too short, allocate longer ones and return False."""
        width = self.cutoff + self.skin
        inputs = [self._grid.id, self._points, width, width, self._lists]
        wp.launch(neighbour_list.list_neighbours, dim=len(self._blocks[0]), inputs=inputs, device=self._device)
        longest = int(self._lists.count.numpy().max(initial=0))
        if longest <= self._lists.neighbour.shape[1]:
            return True
        self._allocate_lists(int(MARGIN * longest) + 1)
        self._record()
        return False

    def _launch_keep(self) -> None:
        self._launch_collect()
        wp.launch(neighbour_list.keep_positions, dim=self.count, inputs=[self._points], device=self._device)

    def _launch_collect(self) -> None:
        wp.launch(neighbour_list.forget_moves, dim=2, inputs=[self._points], device=self._device)
        for first, (position, spacing, status, *_) in zip(self._first, self._arrays, strict=False):
            inputs = [position, spacing, status, first, self.core, self._points]
            wp.launch(neighbour_list.collect_points, dim=position.shape, inputs=inputs, device=self._device)

    def _launch_sum_pairs(self, points: slice) -> None:
        inputs = [self._points, self._lists, self._yukawa, points.start, self._sums]
        # On a GPU every thread is a lane.
        kernel = steric.sum_pairs if self._device.is_cuda else pair_lanes.sum_pairs
        wp.launch(kernel, dim=points.stop - points.start, inputs=inputs, device=self._device)

    def _launch_distribute(self) -> None:
        for first, (*_, force, stiffness) in zip(self._first, self._arrays, strict=False):
            inputs = [self._sums, first, force, stiffness]
            wp.launch(steric.distribute, dim=force.shape, inputs=inputs, device=self._device)

    def energies(self) -> list[np.ndarray]:
        """Steric energy of each ensemble [rod] at the last ``apply``; each rod of a pair has half of its energy."""
        with exclusive:
            found = []
            for first, e in zip(self._first, self._ensembles, strict=False):
                energy = wp.zeros(e.count, dtype=wp.float64, device=self._device)
                inputs = [self._points, self._sums, first, e.nodes, energy]
                wp.launch(steric.find_rod_energies, dim=e.count, inputs=inputs, device=self._device)
                found.append(to_host(energy))
            return found


def _blocks(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First point and size of each block, and the block of each point, of rods of so many nodes [rod]."""
    blocks = -(-nodes // neighbour_list.BLOCK)
    place = neighbour_list.BLOCK * (np.arange(blocks.sum()) - np.repeat(np.cumsum(blocks) - blocks, blocks))
    size = np.minimum(np.repeat(nodes, blocks) - place, neighbour_list.BLOCK)
    return np.repeat(np.cumsum(nodes) - nodes, blocks) + place, size, np.repeat(np.arange(len(size)), size)


def _grid(period: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of cells [3], and cells per length [3]; no cell is narrower than ``width``."""
    cells = np.where(period > 0, np.clip(period // width, 1, MOST_CELLS), CELLS).astype(int)
    while cells.astype(float).prod() > MOST_CELLS:  # wider cells also find every pair
        cells[np.argmax(cells)] //= 2
    return cells, np.where(period > 0, cells / np.where(period > 0, period, 1), 1 / width)


def _yukawa(strength: float, range: float, core: float) -> Any:
    """Parameters of G(ρ) = g0 e^(−ρ/a)/4πρ for the kernels."""
    y = steric.Yukawa()
    y.strength, y.inverse_range, y.core_square = strength / (4 * np.pi), 1 / range, core**2
    y.cutoff_square = (steric.CUTOFF * range) ** 2
    y.rho_cutoff = np.sqrt(y.cutoff_square + y.core_square)
    y.G_cutoff = y.strength * np.exp(-y.rho_cutoff / range) / y.rho_cutoff
    y.F_cutoff = (1 / y.rho_cutoff + 1 / range) * y.G_cutoff
    return y

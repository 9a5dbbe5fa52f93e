"""Steric forces between the rods of all ensembles of a scene, over one neighbour grid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import warp as wp

from warp_rods.kernels import steric
from warp_rods.kernels.layout import to_host
from warp_rods.recorded import Recorded

CELLS = 64
"""Cells of the grid along each axis; space wraps round it, so its extent does not matter."""


class Crowd(Protocol):
    """What an ensemble must show to be pushed: device arrays [rod, node], and [rod]."""

    count: int
    nodes: int

    @property
    def position_array(self) -> wp.array: ...
    @property
    def force_array(self) -> wp.array: ...
    @property
    def spacing_array(self) -> wp.array: ...


class Neighbours:
    """Repulsion of strength g0, range a and core ε between the nodes of ``ensembles`` (5.39), regularised.

    ``apply`` writes the force per length of the present positions into each ensemble's force.
    """

    def __init__(self, ensembles: Sequence[Crowd], strength: float, range: float, core: float, device=None):
        self.strength, self.range, self.core = strength, range, core
        self._ensembles, self._device = list(ensembles), wp.get_device(device)
        # Asked for here and not under capture: an ensemble may have to make room for forces, and then lay out frames.
        forces = [e.force_array for e in self._ensembles]
        self._arrays = [(e.position_array, e.spacing_array, f) for e, f in zip(self._ensembles, forces, strict=True)]
        sizes = [e.count * e.nodes for e in self._ensembles]
        self._first = [0, *np.cumsum(sizes).tolist()]
        self._cloud = self._allocate(self._first[-1])
        self._grid = wp.HashGrid(CELLS, CELLS, CELLS, device=self._device, dtype=wp.float64)
        self._grid.reserve(self._first[-1])
        self.apply = Recorded(self._launch, self._device)

    @property
    def stale(self) -> bool:
        """Whether an ensemble has other nodes than when this was built: then build it anew."""
        return self._first != [0, *np.cumsum([e.count * e.nodes for e in self._ensembles]).tolist()]

    def _allocate(self, points: int) -> steric.Cloud:
        cloud = steric.Cloud()
        for name in ("position", "force"):
            setattr(cloud, name, wp.zeros(points, dtype=wp.vec3d, device=self._device))
        for name in ("weight", "arc", "apart", "energy"):
            setattr(cloud, name, wp.zeros(points, dtype=wp.float64, device=self._device))
        cloud.rod = wp.zeros(points, dtype=wp.int32, device=self._device)
        owner, rods = [], 0
        for e in self._ensembles:
            owner.append(np.repeat(np.arange(rods, rods + e.count), e.nodes))
            rods += e.count
        cloud.rod.assign(np.concatenate(owner).astype(np.int32))
        return cloud

    def _launch(self) -> None:
        cloud, device = self._cloud, self._device
        for first, (position, spacing, _) in zip(self._first, self._arrays, strict=False):
            inputs = [position, spacing, first, self.core, cloud]
            wp.launch(steric.pack, dim=position.shape, inputs=inputs, device=device)
        self._grid.build(cloud.position, wp.float64(steric.REACH * self.range))
        inputs = [self._grid.id, cloud, self.strength, self.range, self.core]
        wp.launch(steric.gather, dim=self._first[-1], inputs=inputs, device=device)
        for first, (_, _, force) in zip(self._first, self._arrays, strict=False):
            wp.launch(steric.unpack, dim=force.shape, inputs=[cloud, first, force], device=device)

    def energies(self) -> list[np.ndarray]:
        """Each ensemble's steric energy [rod] as of the last ``apply``: a pair's energy is shared by halves."""
        found = []
        for first, e in zip(self._first, self._ensembles, strict=False):
            energy = wp.zeros(e.count, dtype=wp.float64, device=self._device)
            inputs = [self._cloud, first, e.nodes, energy]
            wp.launch(steric.rod_energies, dim=e.count, inputs=inputs, device=self._device)
            found.append(to_host(energy))
        return found

"""Soft walls that keep swimmers in a slab, or in or around a surface."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from warp_rods.contact.neighbours import Crowd
from warp_rods.device import device as device_of
from warp_rods.device import exclusive
from warp_rods.kernels.contact import box as box_kernels
from warp_rods.kernels.layout import per_rod, to_host
from warp_rods.kernels.surface.geometry import Numbers, Parameters
from warp_rods.membranes.surfaces import Surface
from warp_rods.rods.recorded import Recorded


class Walls:
    """A wall W = ½ k (d + δ)² per length for d > −δ, d the distance outside it, on every node of ``ensembles``.

    where: the ``Surface`` that is the wall, or the height of a slab between walls at z = ±height/2. outside: keep
    rods where φ > 0, not inside. strength k, force per length and depth; reach δ, length. ``add`` adds the force per
    length of the present positions to each ensemble's force.
    """

    def __init__(
        self,
        ensembles: Sequence[Crowd],
        where: Surface | float,
        strength: float,
        reach: float,
        outside: bool = False,
        device: Any = None,
    ):
        self.strength, self.reach, self.side = strength, reach, -1.0 if outside else 1.0
        self._device = device_of(device)
        self._ensembles = list(ensembles)
        with exclusive:
            if isinstance(where, Surface):
                field, self._parameters = where.field, where.device_parameters(self._device)
            else:
                p = Parameters()
                p.v = Numbers(where, *[0.0] * 7)
                field, self._parameters = box_kernels.slab, wp.array([p], dtype=Parameters, device=self._device)
            self._energies = [per_rod(e.count, device=self._device) for e in self._ensembles]
        self._kernel = box_kernels.walls_of(field)
        for e in self._ensembles:
            _ = e.force_array  # an ensemble may have to make room for forces, and then lay out frames
        self.add = Recorded(self._launch, self._device)

    def _launch(self) -> None:
        for e, energy in zip(self._ensembles, self._energies, strict=True):
            inputs = [
                e.position_array, e.spacing_array, self._parameters, self.side, self.strength, self.reach,
                e.force_array, energy,
            ]  # fmt: skip
            wp.launch(self._kernel, dim=e.count, inputs=inputs, device=self._device)

    def energies(self) -> list[np.ndarray]:
        """Each ensemble's energy in the wall [rod], ∫ W ds, as of the last ``add``."""
        with exclusive:
            return [to_host(energy) for energy in self._energies]

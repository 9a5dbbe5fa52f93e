"""Readings of an ensemble of Cosserat rods, in addition to those of every ensemble."""

from __future__ import annotations

from functools import partial

import numpy as np
import warp as wp

from warp_rods.kernels.layout import to_host
from warp_rods.rods.cosserat.arrays import Arrays
from warp_rods.rods.cosserat.launches import CosseratLaunches
from warp_rods.rods.readings import Reading, Readings
from warp_rods.rods.tiles import Tiled, is_tiled


class CosseratReadings(Readings):
    """Readings of the present state, computed when they are read."""

    _arrays: Arrays
    _launches: CosseratLaunches

    def readings(self) -> dict[str, Reading]:
        """How each variable is read, by its name."""
        a, output = self._arrays, self._arrays.output

        def of(array: wp.array) -> Reading:
            return Reading(self._launches.find_output, partial(self._on_host, array))

        found = {name: of(getattr(output, name)) for name in ("energy", "energy_density", "dissipation", "power")}
        found |= {
            name: of(getattr(output, name)) for name in ("strain", "stretch", "internal_moment", "internal_force")
        }
        found |= {name: of(getattr(a, name)) for name in ("position", "rotation", "orientation")}
        found["tension"] = Reading(self._launches.find_output, lambda: to_host(output.internal_force)[..., 0])
        found["status"] = Reading(_no_update, partial(to_host, a.rods.status))
        return found

    @property
    def rotation(self) -> np.ndarray:
        """Directors as columns [rod, node, 3, 3]."""
        return self.reading("rotation")

    @property
    def stretch(self) -> np.ndarray:
        """U: ∂r/∂s in the directors [rod, node, 3]: along the first stretch, 1 at rest, along the others shear."""
        return self.reading("stretch")

    @property
    def internal_moment(self) -> np.ndarray:
        """Internal moment m in the directors [rod, node, 3]."""
        return self.reading("internal_moment")

    @property
    def internal_force(self) -> np.ndarray:
        """Internal force n in the directors [rod, node, 3]; its first component is the tension."""
        return self.reading("internal_force")

    def _on_host(self, array: wp.array) -> np.ndarray:
        """A copy [rod, …] of an array [rod, …] or [tile, …]."""
        return Tiled(array, self._arrays.failed_at.shape[0]).numpy() if is_tiled(array) else to_host(array)


def _no_update() -> None:
    """Arrays of the state are always up to date."""

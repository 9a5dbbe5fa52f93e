"""Readings of an ensemble: what users, measures and trajectories read of its present state."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Collection, Mapping
from typing import NamedTuple

import numpy as np

from warp_rods.device import exclusive
from warp_rods.documented import Documented
from warp_rods.errors import named
from warp_rods.rods.variables import Variable


class Reading(NamedTuple):
    """How a variable is read: ``update`` computes it on the device, ``take`` copies it to the host."""

    update: Callable[[], None]
    take: Callable[[], np.ndarray]


class Readings(metaclass=Documented):
    """Readings of the present state, which they do not change. Each is a new NumPy array.

    A frozen rod has the readings of its last valid shape. Tension, dissipation and power follow from that shape and the
    present force: they are NaN where the force that stopped the rod is not finite. In sums over rods use those whose
    ``status`` is 0, as the measures of a trajectory do.
    """

    saved: Mapping[str, Variable]
    """The variables of a frame by name, those of contact included; ``variables`` returns the others."""

    @abstractmethod
    def readings(self) -> dict[str, Reading]:
        """How each variable is read, by its name."""

    @property
    def stride(self) -> int:
        """Every ``stride``-th node is saved."""
        return 1

    def reading(self, name: str) -> np.ndarray:
        """A variable of the present state, at all nodes; raises SceneError for an unknown name."""
        with exclusive:
            reading = named(self.readings(), "name", name)
            reading.update()
            return reading.take()

    def variables(self, names: Collection[str] | None = None) -> dict[str, np.ndarray]:
        """A frame at the saved nodes: variables of ``saved`` except those of contact, or those ``names`` of them."""
        wanted = self.saved if names is None else names
        with exclusive:
            readings = {name: row for name, row in self.readings().items() if name in self.saved and name in wanted}
            for update in dict.fromkeys(row.update for row in readings.values()):
                update()
            taken = {name: row.take() for name, row in readings.items()}
        saved_nodes = slice(None, None, self.stride)
        return {name: v[:, saved_nodes] if "node" in self.saved[name].dims else v for name, v in taken.items()}

    @abstractmethod
    def static(self) -> dict[str, np.ndarray]:
        """What a trajectory saves once: names of ``variables.STATIC``."""

    @property
    def position(self) -> np.ndarray:
        """Centre line r [rod, node, 3]; length."""
        return self.reading("position")

    @property
    def orientation(self) -> np.ndarray:
        """Directors of the material frame, tangent first, as quaternions x, y, z, w [rod, node, 4]."""
        return self.reading("orientation")

    @property
    def strain(self) -> np.ndarray:
        """Twist and two bending strains of the material frame [rod, node, 3]; 1/length."""
        return self.reading("strain")

    @property
    def tension(self) -> np.ndarray:
        """λ [rod, node]; force."""
        return self.reading("tension")

    @property
    def energy(self) -> np.ndarray:
        """Elastic energy [rod]; force times length."""
        return self.reading("energy")

    @property
    def energy_density(self) -> np.ndarray:
        """Elastic energy per length [rod, node]; force."""
        return self.reading("energy_density")

    @property
    def dissipation(self) -> np.ndarray:
        """Power dissipated by drag [rod]."""
        return self.reading("dissipation")

    @property
    def power(self) -> np.ndarray:
        """Power of everything that does work on a rod [rod]: dE/dt = ``power`` − ``dissipation``."""
        return self.reading("power")

    @property
    def status(self) -> np.ndarray:
        """The ``Status`` of each rod [rod]: 0 unless it was frozen."""
        return self.reading("status")

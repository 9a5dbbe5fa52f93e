"""What rods of a scene feel of each other and of their box: sterics over one grid of neighbours, and walls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from warp_rods.contact.neighbours import Neighbours
from warp_rods.contact.walls import Walls
from warp_rods.membranes.surface import Surface
from warp_rods.scene.scene import Scene


class Surroundings:
    """Forces on the ``ensembles`` {name: ensemble} of a scene that are not their own; ``apply`` makes them present.

    container: the surface of the scene's box, where it has one.
    """

    def __init__(self, scene: Scene, ensembles: Mapping[str, Any], device: Any, container: Surface | None = None):
        self._scene, self._ensembles, self._device = scene, dict(ensembles), device
        self._container = container  # owns the grid that the walls' kernels read
        self._cells = [table.name for table in scene.swimmers]
        self.neighbours = self._build_neighbours()
        self._walls = self._build_walls()
        if self._walls and not self.neighbours:
            self._clear = [self._ensembles[name].force_array for name in self._cells]
        else:
            self._clear = []

    def _build_neighbours(self) -> Neighbours | None:
        steric = self._scene.steric
        if steric is None or steric.strength == 0:
            return None
        crowd = list(self._ensembles.values())
        period = self._scene.period
        return Neighbours(crowd, steric.strength, steric.range, steric.core, self._device, period=period)

    def _build_walls(self) -> Walls | None:
        box = self._scene.box
        if box is None or box.wall is None:
            return None
        where: Any = self._container or box.height
        crowd = [self._ensembles[name] for name in self._cells]
        return Walls(crowd, where, box.wall.strength, box.wall.range, box.side == "outside", self._device)

    @property
    def recordable(self) -> bool:
        """Whether ``apply`` is kernels alone, on one thread."""
        return self.neighbours is None or self.neighbours.threads == 1

    @property
    def version(self) -> Any:
        """Another object when what ``apply`` launches has changed."""
        return None if self.neighbours is None else self.neighbours.version

    def refresh(self) -> None:
        """Make lists of neighbours of the present positions."""
        if self.neighbours and not self._rebuilt():
            self.neighbours.renew()

    def settle(self) -> None:
        """Measure how far nodes move from the present positions on: they have been put there."""
        if self.neighbours and not self._rebuilt():
            self.neighbours.settle()

    def _rebuilt(self) -> bool:
        """Start anew where an ensemble has other arrays than before; says whether it does."""
        assert self.neighbours is not None
        if not self.neighbours.stale:
            return False
        self.neighbours = self._build_neighbours()
        assert self.neighbours is not None
        self.neighbours.renew()
        return True

    def apply(self) -> None:
        """Forces of the present positions, by lists of neighbours that are made when ``refresh`` is called."""
        if self.neighbours:
            self._rebuilt()
            self.neighbours.push()
        for force in self._clear:
            force.zero_()
        if self._walls:
            self._walls.add()

    def energies(self) -> dict[str, dict[str, np.ndarray]]:
        """Ensemble → variable → energy [rod] as of the last ``apply``."""
        none = {name: np.zeros(e.count) for name, e in self._ensembles.items()}
        steric, walls = dict(none), {name: none[name] for name in self._cells}
        if self.neighbours:
            steric = dict(zip(self._ensembles, self.neighbours.energies(), strict=True))
        if self._walls:
            walls = dict(zip(self._cells, self._walls.energies(), strict=True))
        return {
            name: {"steric_energy": steric[name], **({"wall_energy": walls[name]} if name in walls else {})}
            for name in self._ensembles
        }

"""Forces on the rods of a scene that come from other rods and from the walls of their box."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods.device import exclusive
from warp_rods.membranes.surface import Surface
from warp_rods.rods.ensemble import Ensemble
from warp_rods.scene.scene import Scene

if TYPE_CHECKING:
    from warp_rods.contact.neighbours import Neighbours
    from warp_rods.contact.walls import Walls


class Surroundings:
    """Steric forces between the ``ensembles`` {name: ensemble} of a scene, and the forces of its walls on swimmers.

    container: the surface of the box of the scene, if it has one. ``apply`` writes the forces at the present positions.
    """

    def __init__(self, scene: Scene, ensembles: Mapping[str, Ensemble], device: Any, container: Surface | None = None):
        self._scene, self._ensembles, self._device = scene, dict(ensembles), device
        self._container = container  # a reference, because the wall kernels read its grid
        self._swimmers = [table.name for table in scene.swimmers]
        self.neighbours = self._make_neighbours()
        self._walls = self._make_walls()
        # Steric forces overwrite the force of an ensemble; without them it must be set to zero before walls add to it.
        alone = self._walls is not None and self.neighbours is None
        swimmers = [self._ensembles[name] for name in self._swimmers] if alone else []
        self._to_zero = [array for e in swimmers for array in (e.force_array, e.contact_stiffness_array)]
        # A force set by the user would be overwritten silently.
        for name in self._ensembles if self.neighbours else self._swimmers if self._walls else ():
            self._ensembles[name].reserve_force("contact ([steric] or a wall of the box)")

    def _make_neighbours(self) -> Neighbours | None:
        steric = self._scene.steric
        if steric is None or steric.strength == 0:
            return None
        from warp_rods.contact.neighbours import Neighbours

        ensembles = list(self._ensembles.values())
        period = self._scene.period
        return Neighbours(ensembles, steric.strength, steric.range, steric.core, self._device, period=period)

    def _make_walls(self) -> Walls | None:
        box = self._scene.box
        if box is None or box.wall is None:
            return None
        from warp_rods.contact.rooms import WALLED
        from warp_rods.contact.walls import Walls

        wall: Any = WALLED[box.kind](box) if box.kind in WALLED else self._container or box.height
        swimmers = [self._ensembles[name] for name in self._swimmers]
        return Walls(swimmers, wall, box.wall.strength, box.wall.range, box.side == "outside", self._device)

    @property
    def has_walls(self) -> bool:
        """Whether walls push swimmers."""
        return self._walls is not None

    def apply(self) -> float:
        """Write the forces at the present positions; returns the largest displacement since ``keep``, in cores."""
        move = 0.0
        if self.neighbours:
            if self.neighbours.outdated:
                self.keep()
            move = self.neighbours.apply() / self.neighbours.core
        with exclusive:
            for array in self._to_zero:
                array.zero_()
        if self._walls:
            self._walls.add_forces()
        return move

    def keep(self) -> None:
        """Count displacements from the present positions on."""
        if self.neighbours:
            if self.neighbours.outdated:
                self.neighbours = self._make_neighbours()
            assert self.neighbours is not None
            self.neighbours.keep()

    def state(self) -> dict[str, np.ndarray]:
        """The positions from which displacements count: the next steps depend on them, besides the ensembles."""
        return {"kept": self.neighbours.kept} if self.neighbours else {}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a ``state``, after the ensembles."""
        self.keep()
        if self.neighbours:
            self.neighbours.kept = state["kept"]

    def energies(self) -> dict[str, dict[str, np.ndarray]]:
        """Ensemble → variable → energy [rod] at the last ``apply``."""
        zero = {name: np.zeros(e.count) for name, e in self._ensembles.items()}
        steric, walls = dict(zero), {name: zero[name] for name in self._swimmers}
        if self.neighbours:
            steric = dict(zip(self._ensembles, self.neighbours.energies(), strict=True))
        if self._walls:
            walls = dict(zip(self._swimmers, self._walls.energies(), strict=True))
        return {
            name: {"steric_energy": steric[name], **({"wall_energy": walls[name]} if name in walls else {})}
            for name in self._ensembles
        }

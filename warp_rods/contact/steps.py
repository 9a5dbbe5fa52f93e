"""Time steps under contact: divided into substeps before rods could pass through each other (docs/model.md §6.4).

A few substeps form a block. Neighbour lists must be valid for a whole block, otherwise the block is repeated with new
lists. No node may move by more than a fraction of the core ε in one substep, otherwise the block is repeated with
substeps of half the length.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from warp_rods.contact.neighbours import Neighbours
from warp_rods.contact.surroundings import Surroundings
from warp_rods.rods.ensemble import Ensemble
from warp_rods.rods.recorded import Recorded

BLOCK = 4
"""Substeps after which displacements are checked."""
LARGEST_MOVE = 0.125
"""Largest displacement of a node in one substep, in units of the core ε."""
MOST_SUBSTEPS = 1024
"""Largest number of substeps in one step."""
SAFETY = 0.5
"""Fraction of the stability bound that is used, because contact changes until the lists are rebuilt."""


def largest_step(rate: float) -> float:
    """The bound on Δt for a contact rate κ (1/time), Δt = (4/3)/(2κ).

    With an extrapolated force the two-step formula gives (3z² − 4z + 1)/2 = −x(2z − 1), which leaves the unit circle at
    z = −1, x = 4/3. Both nodes of a pair move, which doubles the rate (docs/model.md §6.4).
    """
    return np.inf if rate == 0 else 4 / 3 / (2 * rate)


class Contact:
    """Steps of all ``ensembles`` of a scene under the forces of their ``surroundings``."""

    def __init__(self, ensembles: Mapping[str, Ensemble], surroundings: Surroundings, device: Any):
        self._ensembles, self._surroundings, self._device = ensembles, surroundings, device
        self._graph: Recorded | None = None
        self._recorded: tuple[object, ...] = ()
        self.substeps = 1
        """The present number of substeps in a step: a power of 2."""
        self._fewest = 1
        self.finest = 1
        """The largest number of substeps used so far."""
        self.unresolved = False
        """Whether a node moved too far even in the shortest substeps."""

    def advance(self, dt: float, steps: int) -> Iterator[int]:
        """Take ``steps`` steps of ``dt``; yields from time to time the number of steps taken."""
        if not self._surroundings.neighbours:
            for done in range(1, steps + 1):
                self._take_substeps(dt, 1)
                yield done
            return
        left, since_listed = self._rebuild_lists(dt, steps * self.substeps), 0.0
        while left:
            before, count = self._state(), min(BLOCK, left)
            self._take_substeps(dt / self.substeps, count)
            move, moved = self._largest_moves()
            if move > LARGEST_MOVE and self.substeps < MOST_SUBSTEPS:
                self._restore(before)
                left = self._halve(left)
            elif moved > self._allowed_move and since_listed:
                self._restore(before)
                left, since_listed = self._rebuild_lists(dt, left), 0.0
            else:
                self.unresolved |= move > LARGEST_MOVE
                left = self._double(left - count, move)
                if 2 * moved - since_listed < self._allowed_move:
                    since_listed = moved
                else:
                    left, since_listed = self._rebuild_lists(dt, left), 0.0
                yield steps - -(-left // self.substeps)

    def _take_substeps(self, dt: float, count: int) -> None:
        ensembles = self._ensembles.values()
        if not (self._surroundings.recordable and all(e.recordable for e in ensembles)):
            for _ in range(count):
                self._surroundings.apply()
                for ensemble in ensembles:
                    ensemble.advance(dt)
            return
        for ensemble in ensembles:
            ensemble.set_step(dt)
        for _ in range(count):
            self._recorded_substep()()
            for ensemble in ensembles:
                ensemble.finish_step()

    def _recorded_substep(self) -> Recorded:
        """Forces and one substep of every ensemble in a single graph."""
        versions = (self._surroundings.version, *(ensemble.version for ensemble in self._ensembles.values()))
        if self._graph is None or self._recorded != versions:
            self._graph, self._recorded = Recorded(self._launch, self._device), versions
        return self._graph

    def _launch(self) -> None:
        self._surroundings.apply()
        for ensemble in self._ensembles.values():
            ensemble.take_step()

    @property
    def _neighbours(self) -> Neighbours:
        assert self._surroundings.neighbours is not None
        return self._surroundings.neighbours

    @property
    def _allowed_move(self) -> float:
        """Displacement up to which the lists are valid, in units of the core."""
        return self._neighbours.skin / self._neighbours.core / 2

    def _largest_moves(self) -> tuple[float, float]:
        """The largest displacement in a substep, and since the lists were built, in units of the core."""
        step, since_listed = self._neighbours.largest_moves()
        return step / self._neighbours.core, since_listed / self._neighbours.core

    def _rebuild_lists(self, dt: float, left: int) -> int:
        """Rebuild the lists and make the substeps as short as contact requires; returns the substeps left."""
        self._surroundings.rebuild_lists()
        bound = SAFETY * largest_step(self._neighbours.contact_rate())
        self._fewest = 1
        while dt / self._fewest > bound and self._fewest < MOST_SUBSTEPS:
            self._fewest *= 2
        while self.substeps < self._fewest:
            left = self._halve(left)
        return left

    def _halve(self, left: int) -> int:
        """Halve the substeps; returns the substeps left."""
        self.substeps *= 2
        self.finest = max(self.finest, self.substeps)
        return 2 * left

    def _double(self, left: int, move: float) -> int:
        """Double the substeps, if no node then moves too far and they still end with the step; returns those left."""
        if self.substeps == self._fewest or left % 2 or 2 * move > LARGEST_MOVE:
            return left
        self.substeps //= 2
        return left // 2

    def _state(self) -> dict[str, dict[str, np.ndarray]]:
        return {name: ensemble.state() for name, ensemble in self._ensembles.items()}

    def _restore(self, state: dict[str, dict[str, np.ndarray]]) -> None:
        for name, ensemble in self._ensembles.items():
            ensemble.restore(state[name])
        self._surroundings.skip_move()

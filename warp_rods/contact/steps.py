"""Steps that all ensembles of a scene take together (docs/model.md §1.5, §6.4).

A step is tried before it is taken: every ensemble extrapolates its rods to the end of the step, contact acts there, and
each ensemble finds the result and its error. Nothing of the present state has changed until then. No node may move by
more than a fraction of the core ε in one step, otherwise it is repeated shorter.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from warp_rods.contact.surroundings import Surroundings
from warp_rods.rods.control import Control
from warp_rods.rods.ensemble import Ensemble

LARGEST_MOVE = 0.25
"""Largest displacement of a node in one step, in units of the core ε."""
MOST_PARTS = 1024
"""Largest number of parts of one step of a given length."""


class Contact:
    """Steps of all ``ensembles`` of a scene under the forces of their ``surroundings``."""

    def __init__(self, ensembles: Mapping[str, Ensemble], surroundings: Surroundings):
        self._ensembles, self._surroundings = ensembles, surroundings
        self.control = Control(min(e.first_step for e in ensembles.values()))
        """Steps whose length follows their error."""
        self.parts = 1
        """The present number of parts of a step of a given length: a power of 2."""
        self.finest = 1
        """The largest number of parts so far."""
        self.unresolved = False
        """Whether a node moved too far even in the shortest step."""

    # --- steps of a given length --------------------------------------------------------------------------------------

    def advance(self, dt: float, steps: int) -> Iterator[int]:
        """Take ``steps`` steps of ``dt``; yields the number of steps taken after each."""
        for done in range(1, steps + 1):
            largest = 0.0
            for length in self._first.lengths_of_steps(dt, 1):
                parts = self.parts
                for _ in range(parts):
                    largest = max(largest, self._take(length / parts, dt / MOST_PARTS))
            if 2 * largest < LARGEST_MOVE and self.parts > 1:
                self.parts //= 2
            yield done

    def _take(self, dt: float, shortest: float) -> float:
        """Take a step of ``dt``, in halves if a node would move too far; returns the largest move in units of ε."""
        move = self._try(dt)
        if move > LARGEST_MOVE and dt > shortest:
            self.parts = min(2 * self.parts, MOST_PARTS)
            self.finest = max(self.finest, self.parts)
            return max(self._take(dt / 2, shortest), self._take(dt / 2, shortest))
        self._accept(move)
        return move

    # --- steps by error -----------------------------------------------------------------------------------------------

    def advance_to(self, time: float, tolerance: float, unit: float) -> Iterator[float]:
        """Advance past ``time`` in steps with errors below ``tolerance``, and show that time; yields the time reached.

        unit: of time, for the shortest step. A rod whose step is not valid even then is frozen.
        """
        while self._first.reached < time:
            control = self.control
            move = self._try(control.step)
            error = max(float(e.error_of_step().max()) for e in self._ensembles.values()) / tolerance
            if control.accepts(error, move / LARGEST_MOVE, unit):
                self._accept(move)
            else:
                for ensemble in self._ensembles.values():
                    ensemble.reject_step()
            yield self._first.reached
        for ensemble in self._ensembles.values():
            ensemble.show_at(time)

    # --- state --------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, np.ndarray]:
        """What the next steps depend on, besides the ensembles."""
        return {"parts": np.array(self.parts), "control": self.control.state()}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a ``state``."""
        self.parts = int(state["parts"])
        self.control.restore(state["control"])

    # --- one step -----------------------------------------------------------------------------------------------------

    @property
    def _first(self) -> Ensemble:
        return next(iter(self._ensembles.values()))

    def _try(self, dt: float) -> float:
        """Try a step of ``dt``; returns the largest displacement of a node since the last step, in units of ε."""
        ensembles = self._ensembles.values()
        for ensemble in ensembles:
            ensemble.set_step(dt)
            ensemble.prepare_step(dt)
            ensemble.predict_step()
        move = self._surroundings.apply()
        for ensemble in ensembles:
            ensemble.try_step()
        return move

    def _accept(self, move: float) -> None:
        """Make the step tried the present state."""
        self.unresolved |= move > LARGEST_MOVE
        self._surroundings.keep()
        lost = False
        for ensemble in self._ensembles.values():
            lost |= bool(np.isinf(ensemble.error_of_step()).any())
            ensemble.accept_step()
            ensemble.finish_step()
        if lost:  # a rod that is frozen acts on the others where it was
            for ensemble in self._ensembles.values():
                ensemble.show()
            self._surroundings.keep()

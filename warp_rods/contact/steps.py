"""Steps that contact allows: halved before rods could pass through each other, and lengthened again after.

A few steps make a stretch. Lists of neighbours hold over a stretch, or it is redone with new ones; no node moves by
more than a share of the core ε in a step, or the stretch is redone in halved steps.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from warp_rods.contact.neighbours import Neighbours
from warp_rods.contact.surroundings import Surroundings
from warp_rods.rods.recorded import Recorded

STRETCH = 4
"""Steps between two looks at how far nodes have come."""
LARGEST_MOVE = 0.125
"""Of the core ε, that a node may move in a step."""
FINEST = 1024
"""Parts that a step is cut into at most."""
SAFETY = 0.5
"""Share taken of the bound that the stiffness of contact sets, as it changes until lists are made anew."""


def largest_step(stiffness: float) -> float:
    """The bound on Δt at which contact that pulls nodes back at this rate, 1/time, is stable: 4/3 of 1/2 of 1/rate.

    Of SBDF2 with the force extrapolated, (3z² − 4z + 1)/2 = −x(2z − 1) leaves the unit circle at z = −1, x = 4/3;
    nodes of a pair move both, which doubles the rate (model §3).
    """
    return np.inf if stiffness == 0 else 4 / 3 / (2 * stiffness)


class Contact:
    """Steps of all ``ensembles`` of a scene under what they feel of their ``surroundings``."""

    def __init__(self, ensembles: dict[str, Any], surroundings: Surroundings, device: Any):
        self._ensembles, self._surroundings, self._device = ensembles, surroundings, device
        self._graph: Recorded | None = None
        self._recorded: tuple[object, ...] = ()
        self.parts = 1
        """Steps taken in place of one: a power of 2."""
        self._fewest = 1
        self.finest = 1
        """The most parts that were needed so far."""
        self.unresolved = False
        """Whether a node moved too far even in the finest of steps."""

    def advance(self, dt: float, steps: int) -> Iterator[int]:
        """Take ``steps`` steps of ``dt``; yields now and then how many are done."""
        if not self._surroundings.neighbours:
            for done in range(1, steps + 1):
                self._walk(dt, 1)
                yield done
            return
        left, drift = self._renew(dt, steps * self.parts), 0.0
        while left:
            before, count = self._state(), min(STRETCH, left)
            self._walk(dt / self.parts, count)
            move, now = self._moved()
            if move > LARGEST_MOVE and self.parts < FINEST:
                self._restore(before)
                left = self._cut(left)
            elif now > self._slack and drift:
                self._restore(before)
                left, drift = self._renew(dt, left), 0.0
            else:
                self.unresolved |= move > LARGEST_MOVE
                left = self._lengthen(left - count, move)
                left, drift = (left, now) if 2 * now - drift < self._slack else (self._renew(dt, left), 0.0)
                yield steps - -(-left // self.parts)

    def _walk(self, dt: float, steps: int) -> None:
        crowd = self._ensembles.values()
        if not (self._surroundings.recordable and all(e.recordable for e in crowd)):
            for _ in range(steps):
                self._surroundings.apply()
                for ensemble in crowd:
                    ensemble.step(dt)
            return
        for ensemble in crowd:
            ensemble.set_step(dt)
        for _ in range(steps):
            self._whole_step()()
            for ensemble in crowd:
                ensemble.finish_step()

    def _whole_step(self) -> Recorded:
        """Forces and a step of every ensemble in one graph."""
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
    def _slack(self) -> float:
        """How far a node may come, of the core, while lists hold."""
        return self._neighbours.skin / self._neighbours.core / 2

    def _moved(self) -> tuple[float, float]:
        """The longest way of a node in a step and since lists were made, of the core."""
        step, drift = self._neighbours.moved()
        return step / self._neighbours.core, drift / self._neighbours.core

    def _renew(self, dt: float, left: int) -> int:
        """New lists, and as many parts at least as the stiffness of contact asks for; returns the steps left."""
        self._surroundings.refresh()
        bound = SAFETY * largest_step(self._neighbours.stiffness())
        self._fewest = 1
        while dt / self._fewest > bound and self._fewest < FINEST:
            self._fewest *= 2
        while self.parts < self._fewest:
            left = self._cut(left)
        return left

    def _cut(self, left: int) -> int:
        self.parts *= 2
        self.finest = max(self.finest, self.parts)
        return 2 * left

    def _lengthen(self, left: int, move: float) -> int:
        """Twice as long steps where that moves no node too far, and they end with the step that was asked for."""
        if self.parts == self._fewest or left % 2 or 2 * move > LARGEST_MOVE:
            return left
        self.parts //= 2
        return left // 2

    def _state(self) -> dict[str, dict[str, np.ndarray]]:
        return {name: ensemble.state() for name, ensemble in self._ensembles.items()}

    def _restore(self, state: dict[str, dict[str, np.ndarray]]) -> None:
        for name, ensemble in self._ensembles.items():
            ensemble.restore(state[name])
        self._surroundings.settle()

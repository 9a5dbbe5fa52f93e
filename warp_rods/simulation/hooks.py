"""Functions that a simulation calls as it goes: *when* (a cadence) is separate from *what* (the function)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from warp_rods.errors import SceneError

if TYPE_CHECKING:
    from warp_rods.simulation.loop import Simulation


class Cadence(Protocol):
    """When a hook is due."""

    def count(self, simulation: Simulation) -> int:
        """How many times it has come due until now, the start included."""


@dataclass(frozen=True)
class Every:
    """Due at the start and then each so many planned ``steps``, or each so much ``time``; made by ``every``."""

    steps: int | None = None
    time: float | None = None

    def count(self, simulation: Simulation) -> int:
        """How many times it has come due until now, the start included."""
        if self.steps is not None:
            return simulation.steps_taken // self.steps + 1
        assert self.time is not None
        return math.floor(simulation.now / self.time * (1 + 1e-12) + 1e-9) + 1


@dataclass(frozen=True)
class EveryFrame:
    """Due when the simulation reaches a frame that is saved."""

    def count(self, simulation: Simulation) -> int:
        """How many frames have been reached, the first included."""
        return simulation.frame + 1


def every(steps: int | None = None, time: float | None = None) -> Every:
    """The cadence of each so many steps or each so much time, one of them; raises SceneError for neither or both."""
    if (steps is None) == (time is None):
        raise SceneError("every: give steps or time, one of them")
    if steps is not None and (isinstance(steps, bool) or int(steps) != steps or steps < 1):
        raise SceneError(f"every: steps = {steps!r}: must be a whole number, 1 or more")
    if time is not None and not 0 < time < math.inf:
        raise SceneError(f"every: time = {time!r}: must be positive")
    return Every(None if steps is None else int(steps), None if time is None else float(time))


@dataclass
class Hook:
    """A ``function`` of the simulation, called whenever its ``cadence`` has come due since the last call."""

    cadence: Cadence
    function: Callable[[Simulation], Any]
    called: int = 0

    def call_if_due(self, simulation: Simulation) -> None:
        """Call the function once, however often it has come due."""
        count = self.cadence.count(simulation)
        if count > self.called:
            self.called = count
            self.function(simulation)

    def skip_past(self, simulation: Simulation) -> None:
        """Let what has come due until now count as called: the simulation was put where it is."""
        self.called = self.cadence.count(simulation)

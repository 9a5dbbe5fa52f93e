"""Functions that a simulation calls during a run: a cadence says when, a function says what."""

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
        """The number of times it has become due so far, the start included."""

    def next_time(self, simulation: Simulation) -> float:
        """The time at which it is due next, where rods take steps of their own; infinity: at a frame."""


@dataclass(frozen=True)
class Every:
    """Due at the start and then after every ``steps`` planned steps or every interval of ``time``; see ``every``."""

    steps: int | None = None
    time: float | None = None

    def count(self, simulation: Simulation) -> int:
        """The number of times it has become due so far, the start included."""
        if self.steps is not None:
            return simulation.steps_taken // self.steps + 1
        assert self.time is not None
        return math.floor(simulation.now / self.time * (1 + 1e-12) + 1e-9) + 1

    def next_time(self, simulation: Simulation) -> float:
        """The next multiple of the interval."""
        return math.inf if self.time is None else self.time * self.count(simulation)


@dataclass(frozen=True)
class EveryFrame:
    """Due at every frame."""

    def count(self, simulation: Simulation) -> int:
        """The number of frames reached, the first included."""
        return simulation.frame + 1

    def next_time(self, simulation: Simulation) -> float:
        """Infinity: at frames only."""
        return math.inf


def every(steps: int | None = None, time: float | None = None) -> Every:
    """The cadence of a number of steps or of an interval of time; raises SceneError unless one of them is given."""
    if (steps is None) == (time is None):
        raise SceneError("every: give steps or time, and not both")
    if steps is not None and (isinstance(steps, bool) or int(steps) != steps or steps < 1):
        raise SceneError(f"every: steps = {steps!r}: must be a whole number, 1 or more")
    if time is not None and not 0 < time < math.inf:
        raise SceneError(f"every: time = {time!r}: must be positive")
    return Every(None if steps is None else int(steps), None if time is None else float(time))


@dataclass
class Hook:
    """A ``function`` of the simulation that is called when its ``cadence`` is due."""

    cadence: Cadence
    function: Callable[[Simulation], Any]
    called: int = 0

    def next_time(self, simulation: Simulation) -> float:
        """The time at which it is due next, where rods take steps of their own; infinity: at a frame."""
        return self.cadence.next_time(simulation)

    def call_if_due(self, simulation: Simulation) -> None:
        """Call the function once if it has become due since the last call."""
        count = self.cadence.count(simulation)
        if count > self.called:
            self.called = count
            self.function(simulation)

    def skip_past(self, simulation: Simulation) -> None:
        """Do not call the function for times before the present one, from which a restored simulation continues."""
        self.called = self.cadence.count(simulation)

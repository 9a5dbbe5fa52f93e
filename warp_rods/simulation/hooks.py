"""Functions that a simulation calls during a run: a cadence says when, a function says what."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, SupportsFloat, SupportsIndex

from warp_rods import arguments
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


def every(steps: SupportsIndex | None = None, time: SupportsFloat | None = None) -> Every:
    """The cadence of a number of steps or of an interval of time; raises SceneError unless one of them is given.

    Steps by error do not end at its times: a function is called with the state that the scheme's polynomial gives
    there, and once for all the steps taken since the last call.
    """
    if (steps is None) == (time is None):
        raise SceneError("every: give steps or time, and not both")
    if steps is not None:
        return Every(steps=arguments.whole("every: steps", steps))
    return Every(time=arguments.real("every: time", time))


@dataclass
class Hook:
    """A ``function`` of the simulation that is called when its ``cadence`` is due."""

    cadence: Cadence
    function: Callable[[Simulation], Any]
    called: int = 0
    ended: bool = False
    """Whether the function has stopped the run; it is not called again."""

    @classmethod
    def read(cls, name: str, given: Any) -> Hook:
        """From a pair of a cadence and a function; raises SceneError with ``name`` for anything else."""
        if not isinstance(given, (tuple, list)) or len(given) != 2:
            raise arguments.wrong(name, given, "a pair of a cadence, such as every(steps=10), and a function")
        cadence, function = given
        counts = callable(getattr(cadence, "count", None)) and not isinstance(cadence, (str, tuple, list))
        if not counts:
            raise arguments.wrong(f"{name}: cadence", cadence, "every(steps=…), every(time=…), or have a method count")
        return cls(cadence, arguments.function(f"{name}: function", function, 1, "a function of the simulation"))

    def next_time(self, simulation: Simulation) -> float:
        """The time at which it is due next, where rods take steps of their own; infinity: at a frame."""
        next_time = getattr(self.cadence, "next_time", None)
        return math.inf if next_time is None else next_time(simulation)

    def call_if_due(self, simulation: Simulation) -> None:
        """Call the function once if it has become due since the last call."""
        count = self.cadence.count(simulation)
        if count > self.called and not self.ended:
            self.called = count
            going = simulation.stopped is None
            self.function(simulation)
            self.ended = going and simulation.stopped is not None

    def skip_past(self, simulation: Simulation) -> None:
        """Do not call the function for times before the present one, from which a restored simulation continues."""
        self.called = self.cadence.count(simulation)


def read_hooks(hooks: Any) -> list[Hook]:
    """Hooks from pairs of a cadence and a function; raises SceneError naming the first that is not one."""
    if isinstance(hooks, (str, bytes)) or not isinstance(hooks, Iterable):
        raise arguments.wrong("hooks", hooks, "a list of pairs of a cadence and a function")
    return [Hook.read(f"hooks[{index}]", given) for index, given in enumerate(hooks)]

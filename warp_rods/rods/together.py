"""Steps that several ensembles take together (docs/model.md §1.5, §6.4).

A step is tried before it is taken: every ensemble extrapolates its rods to the end of the step, contact acts there, and
each ensemble finds the result and its error. Nothing of the present state has changed until then. No node may move by
more than a fraction of the steric core ε in one step, otherwise it is repeated shorter.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from warp_rods.rods.control import Control

LARGEST_MOVE = 0.25
"""Largest displacement of a node in one step, in units of the core ε."""
MOST_PARTS = 1024
"""Largest number of parts of one step of a given length."""
STARTING = 0.004
"""Error allowed in the first steps of a given length Δt, in units of (Δt/τ)³ with the natural time τ of the rods. A
step of second order has such an error later, but a start that is rough or contradicts the ends needs shorter ones."""
SMALLEST_STARTING = 1e-9
"""The smallest error allowed in the first steps."""
LONGEST_START = 32, 10.0
"""The time for which the first steps of a given length are divided at most, in steps and in τ; the longer counts."""
MOST_STARTING = 5000
"""The largest number of parts of these steps."""
LONGER = 2.0
"""The ratio of a step of a given length to the longest one before above which the steps start again."""
SHARE_OF_LARGEST = 0.1
"""The largest error of a rod may exceed the allowed root mean square by the inverse."""


class Rods(Protocol):
    """What an ensemble does in a step, in this order; see ``Ensemble``."""

    step_tolerance: float

    @property
    def first_step(self) -> float: ...
    @property
    def natural_time(self) -> float: ...
    @property
    def reached(self) -> float: ...

    def set_step(self, dt: float) -> None: ...
    def prepare_step(self, dt: float) -> bool: ...
    def predict_step(self) -> None: ...
    def apply_given_force(self) -> None: ...
    def try_step(self) -> None: ...
    def error_of_step(self) -> np.ndarray: ...
    def reject_step(self) -> None: ...
    def give_up(self, allowed: float) -> None: ...
    def accept_step(self) -> None: ...
    def finish_step(self) -> None: ...
    def step_to_event(self, step: float) -> float: ...
    def foresee(self, start: float, end: float) -> None: ...
    def next_event(self) -> float: ...
    def end_planned_step(self) -> None: ...
    def hold_force(self) -> None: ...
    def bring_together(self) -> None: ...
    def show_at(self, time: float) -> None: ...
    def show(self) -> None: ...


class Forces(Protocol):
    """What acts on the rods in a step."""

    def apply(self) -> float:
        """Write forces at the present positions; returns the largest displacement since ``keep``, in units of ε."""

    def keep(self) -> None:
        """Count displacements from the present positions on."""


class Together:
    """Steps of ``ensembles``, of the same length for all, under ``forces`` besides those that the ensembles have."""

    def __init__(self, ensembles: Sequence[Rods], forces: Forces | None = None):
        self._ensembles, self._forces = list(ensembles), forces
        self.longest = np.inf
        """The longest step by error: what depends on time must not pass unseen."""
        self.restart()

    def restart(self) -> None:
        """Begin with short steps."""
        self.control = Control(min(e.first_step for e in self._ensembles))
        """Steps whose length follows their error."""
        self._starting = True
        """Whether the next step of a given length is one of the first, which are divided as their error demands."""
        self._started, self._longest, self._taken_before = self.reached, 0.0, 0
        """When the first steps began, the longest step of a given length since, and the steps taken before."""
        self._parts = 1
        """Parts of a step of a given length, so that no node moves too far: a power of 2."""
        self.finest = 1
        """The largest number of parts so far."""
        self.unresolved = False
        """Whether a node moved too far even in the shortest step."""

    @property
    def reached(self) -> float:
        """The time that the steps have reached."""
        return self._ensembles[0].reached

    # --- steps of a given length --------------------------------------------------------------------------------------

    def advance(self, dt: float, steps: int) -> Iterator[int]:
        """Take ``steps`` steps of ``dt``; yields the number of steps taken after each."""
        self._align()
        for done in range(1, steps + 1):
            if dt > LONGER * self._longest or self._next_event() < self.reached + dt:
                self._starting, self._started, self._taken_before = True, self.reached, self.control.taken
            self._longest = max(self._longest, dt)
            if self._starting:
                self._start(dt)
            else:
                self._take_parts(dt)
            for ensemble in self._ensembles:
                ensemble.end_planned_step()
            yield done

    def _start(self, dt: float) -> None:
        """One of the first steps of ``dt``, divided as its error demands."""
        natural = min(e.natural_time for e in self._ensembles)
        step_tolerance = max(e.step_tolerance for e in self._ensembles)
        allowed = max(STARTING * (self._longest / natural) ** 3, SMALLEST_STARTING) / step_tolerance
        end = self.reached + dt
        while (left := end - self.reached) > 1e-12 * dt:
            if self.control.taken - self._taken_before >= MOST_STARTING:
                self._take(self._before_event(left), 1)
                continue
            # Not a short rest at the end: the last two steps are of the same length.
            step = self.control.step
            step = self._before_event(left if left <= step else min(step, left / 2))
            self._follow_error(step, allowed, dt, give_up=False)
        duration = max(LONGEST_START[0] * self._longest, LONGEST_START[1] * natural)
        in_time = self.reached < self._started + duration and self.control.taken - self._taken_before < MOST_STARTING
        self._starting = self.control.step < self._longest and in_time

    def _take_parts(self, dt: float) -> None:
        """A step of ``dt`` in the present number of parts, or more of them."""
        parts, largest = self._parts, 0.0
        for _ in range(parts):
            largest = max(largest, self._take(dt, parts))
        if 2 * largest < LARGEST_MOVE and self._parts > 1:
            self._parts //= 2

    def _take(self, dt: float, parts: int) -> float:
        """Take a part of a step of ``dt``, in halves if a node would move too far; returns the largest move in ε."""
        move = self._try(dt / parts)
        if move > LARGEST_MOVE and parts < MOST_PARTS:
            self._parts = max(self._parts, 2 * parts)
            self.finest = max(self.finest, self._parts)
            return max(self._take(dt, 2 * parts), self._take(dt, 2 * parts))
        self._accept(move)
        return move

    # --- steps by error -----------------------------------------------------------------------------------------------

    def advance_to(self, time: float, tolerance: float) -> Iterator[float]:
        """Advance past ``time`` in steps by error, and show that time; yields the time that is shown after each.

        tolerance: of a run. A rod whose shortest step is not valid or has too large an error is frozen.
        """
        self._align()
        for ensemble in self._ensembles:
            ensemble.hold_force()
            ensemble.foresee(self.reached, time)
        while self.reached < time:
            step = min(self.control.step, self.longest)
            dt = self._before_event(min(e.step_to_event(step) for e in self._ensembles))
            self._follow_error(dt, tolerance, time, give_up=True)
            if self.reached < time:
                yield self.reached
        for ensemble in self._ensembles:
            ensemble.show_at(time)
        yield time

    def _follow_error(self, dt: float, tolerance: float, unit: float, *, give_up: bool) -> None:
        """Try a step of ``dt``; take it or not, as its error demands, which chooses the next one.

        give_up: whether rods are frozen whose error is too large even in the shortest step.
        """
        move = self._try(dt)
        error = size_of(np.concatenate([e.error_of_step() / e.step_tolerance for e in self._ensembles])) / tolerance
        if self.control.accepts(dt, error, move / LARGEST_MOVE, self.reached, unit):
            if give_up and error > 1:
                for ensemble in self._ensembles:
                    ensemble.give_up(ensemble.step_tolerance * tolerance)
            self._accept(move)
        else:
            for ensemble in self._ensembles:
                ensemble.reject_step()

    def _next_event(self) -> float:
        """The time of the next event of a rod, at which its steps begin anew; those at the time reached happen."""
        return min(e.next_event() for e in self._ensembles)

    def _before_event(self, step: float) -> float:
        """A step that does not pass the next event; the last two before it are of the same length."""
        left = self._next_event() - self.reached
        return left if step >= left else left / 2 if 2 * step > left else step

    def _align(self) -> None:
        """Let ensembles begin anew together, if one has been moved apart: by steps of its own, or by a force set."""
        times = {ensemble.reached for ensemble in self._ensembles}
        if len(times) > 1 or np.isinf(self.reached):
            for ensemble in self._ensembles:
                ensemble.bring_together()
            self.restart()

    # --- one step -----------------------------------------------------------------------------------------------------

    def _try(self, dt: float) -> float:
        """Try a step of ``dt``; returns the largest displacement of a node since the last step, in units of ε."""
        replaced = False
        for ensemble in self._ensembles:
            ensemble.set_step(dt)
            replaced |= ensemble.prepare_step(dt)
        if replaced and self._forces is not None:
            self._keep_present()
        for ensemble in self._ensembles:
            ensemble.predict_step()
        move = 0.0 if self._forces is None else self._forces.apply()
        for ensemble in self._ensembles:
            ensemble.apply_given_force()
            ensemble.try_step()
        return move

    def _accept(self, move: float) -> None:
        """Make the step tried the present state."""
        self.unresolved |= move > LARGEST_MOVE
        if self._forces is not None:
            self._forces.keep()
        for ensemble in self._ensembles:
            ensemble.accept_step()
            ensemble.finish_step()

    def _keep_present(self) -> None:
        """Count displacements from the present state on, where the last step has put positions at another one."""
        assert self._forces is not None
        for ensemble in self._ensembles:
            ensemble.show()
        self._forces.keep()

    # --- state --------------------------------------------------------------------------------------------------------

    def state(self) -> np.ndarray:
        """What the next steps depend on, besides the ensembles [9]."""
        start = (self._starting, self._started, self._longest, self._taken_before)
        return np.array([*start, self._parts, *self.control.state()])

    def restore(self, state: np.ndarray) -> None:
        """Return to a ``state``."""
        self._starting, self._started, self._longest = bool(state[0]), float(state[1]), float(state[2])
        self._taken_before, self._parts = int(state[3]), int(state[4])
        self.control.restore(state[5:])


def size_of(errors: np.ndarray) -> float:
    """The error of a step of many rods [rod]: root mean square, or a share of the largest if that is more.

    Rods that are frozen have a negative error and do not count.
    """
    counted = errors[errors >= 0]
    if not len(counted):
        return 0.0
    return max(float(np.sqrt(np.mean(counted**2))), SHARE_OF_LARGEST * float(counted.max()))


def exhaust(steps: Iterator[object]) -> None:
    """Take all the steps of an iterator."""
    for _ in steps:
        pass

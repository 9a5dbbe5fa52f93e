"""The contract of every ensemble of rods with users, the simulation loop, contact and measures.

A kind of rod is a folder beside this file with a subclass of ``Ensemble``; CONTRIBUTING.md says what it provides.
"""

from __future__ import annotations

import functools
import logging
from abc import abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Generic, NamedTuple, Never, Protocol, Self, SupportsFloat, SupportsIndex, TypeVar, overload

import numpy as np
import warp as wp

from warp_rods import arguments
from warp_rods.device import device as device_of
from warp_rods.device import exclusive
from warp_rods.errors import SceneError
from warp_rods.kernels.layout import to_host
from warp_rods.notebook import html_table
from warp_rods.rods.changes import Changes
from warp_rods.rods.clock import Clock
from warp_rods.rods.control import TOLERANCE
from warp_rods.rods.per_rod import check_step, vectors
from warp_rods.rods.readings import Readings
from warp_rods.rods.status import Status
from warp_rods.rods.tiles import Tiled
from warp_rods.rods.together import Together, exhaust

LOG = logging.getLogger("warp_rods")
TELL, TELL_TOTAL = 10.0, 0.5
"""Users are told of a step of a given length with a larger error, in units of ``step_tolerance``, and of errors of a
rod that add up to more. Results wrong by more than 3 % had either: tests/simulation/test_steps_too_long.py."""
LONGEST_SHARE = 3.0
"""A force is not extrapolated farther than this many planned steps."""
FORCE_STATE = ("force", "force_previous")
"""Arrays of the state of an ensemble whose force was set."""

FOR_THE_LOOP = frozenset(
    {
        *("advance", "set_step", "prepare_step", "finish_step", "ends_of_space", "pace_arrays", "error_report"),
        *("predict_step", "try_step", "error_of_step", "accept_step", "reject_step", "show_at", "show", "reached"),
        *(
            "first_step",
            "natural_time",
            "gather",
            "has_own_steps",
            "changes_in_time",
            "step_tolerance",
            "take_own_steps",
            "bring_together",
            "hold_force",
            "foresee",
            "changes",
        ),
        *("threads", "refine", "middle", "tracked", "evaluate", "contact_stiffness_array"),
        *("apply_given_force", "end_planned_step", "step_to_event", "next_event", "position_array", "force_array"),
        *("spacing_array", "status_array", "give_up", "reserve_force", "failed_at", "stride"),
        *("arrays_of_state", "allocate_for", "check_state", "nodes_of", "readings", "saved", "static"),
    }
)
"""Members for the simulation loop, contact and trajectories (see CONTRIBUTING.md), left out of ``help``."""
T = TypeVar("T")


class Failure(NamedTuple):
    """A frozen rod: its number, the time, and what happened."""

    rod: int
    time: float
    what: str


def shape_of(array: wp.array | Tiled) -> tuple[int, ...]:
    """The shape of an array on the host, components of vectors and matrices included."""
    if isinstance(array, Tiled):
        return array.shape
    on_gpu = wp.get_device(array.device).is_cuda
    return (array.__cuda_array_interface__ if on_gpu else array.__array_interface__)["shape"]


class Fixed(Generic[T]):
    """A read-only attribute of an ensemble, given when the ensemble was made."""

    def __init__(self, description: str, of: str = ""):
        """``of``: the name under which the value was given, if it is another."""
        self.__doc__, self._name = description, of

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = self._name or name

    @overload
    def __get__(self, ensemble: None, owner: type) -> Self: ...
    @overload
    def __get__(self, ensemble: Ensemble, owner: type) -> T: ...
    def __get__(self, ensemble: Ensemble | None, owner: type) -> Self | T:
        return self if ensemble is None else ensemble._fixed[self._name]

    def __set__(self, ensemble: Ensemble, value: Never) -> None:
        raise AttributeError(f"{self._name} is fixed once the ensemble is made: make a new ensemble with the new value")


class Parameter(Fixed[np.ndarray]):
    """A parameter of the rods as a read-only attribute [rod] or [rod, component], which ``parameters`` lists."""


class Launches(Protocol):
    """The launches of a step of one kind of rods, which the methods of an ensemble with like names make."""

    def try_step(self) -> None: ...

    def give_up(self, allowed: float) -> None: ...

    def accept(self) -> None: ...

    def reject(self) -> None: ...


class Ensemble(Readings):
    """``count`` rods of ``nodes`` nodes each, one batch on one device. NumPy in, NumPy out; no files.

    A rod that fails is frozen at its last valid state and gets a ``status``; the other rods continue.
    """

    _unlisted = FOR_THE_LOOP
    _launches: Launches
    step_tolerance: float
    """Error allowed in a step, in units of that at the end: errors add up, and periodic motion drifts in phase."""
    count = Fixed[int]("Number of rods.")
    device = Fixed[wp.Device]("Where the rods are.")

    def __init_subclass__(cls, **options: Any) -> None:
        """Wrong names of arguments are a SceneError, as wrong values are."""
        super().__init_subclass__(**options)
        if "__init__" in vars(cls):
            cls.__init__ = arguments.naming(cls.__init__)  # type: ignore[method-assign]

    def __init__(self, count: int, nodes: int, parameters: Mapping[str, np.ndarray], device: Any, **fixed: Any):
        """``parameters``: values of ``Parameter`` attributes; ``fixed``: of the other ``Fixed`` attributes."""
        self._nodes = arguments.whole("nodes", nodes)
        fixed |= {"count": arguments.whole("count", count), "device": device_of(device)}
        for values in parameters.values():
            values.setflags(write=False)
        self._parameters: Mapping[str, np.ndarray] = MappingProxyType(dict(parameters))
        self._fixed: Mapping[str, Any] = MappingProxyType({**fixed, **parameters})
        self._force_from = ""
        self._given: np.ndarray | None = None
        self._given_before: np.ndarray | None = None
        self._written: np.ndarray | None = None
        with exclusive:
            self._clock = Clock(self.device)
        self._warned = False

    @property
    def nodes(self) -> int:
        """Number of nodes of each rod."""
        return self._nodes

    def __repr__(self) -> str:
        frozen = int((self.status != Status.OK).sum())
        state = f"{frozen} of them frozen" if frozen else "all ok"
        rods = f"{self.count} rod{'s' if self.count > 1 else ''} of {self.nodes} nodes"
        return f"<{type(self).__name__}: {rods} on {self.device}, t = {self.time:g}, {state}>"

    def _repr_html_(self) -> str:
        frozen = [Status(value) for value in self.status if value != Status.OK]
        lost = [("frozen", f"{frozen.count(one)}: a rod that {one.words}") for one in dict.fromkeys(frozen)]
        rows = [("rods", self.count), ("nodes", self.nodes), ("device", self.device), ("time", f"{self.time:g}"), *lost]
        return html_table(rows, title=type(self).__name__)

    # --- steps ------------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """The present time."""
        return self._clock.time

    def step(self, dt: SupportsFloat, steps: SupportsIndex = 1) -> None:
        """Advance by ``steps`` steps of ``dt`` under the present ``force``; second order, from a rough start, too.

        Large errors are told once, by the logger ``warp_rods``. Raises SceneError for a step that is not positive.
        """
        dt, steps = check_step(dt, steps)
        self.advance(dt, steps)
        self._warn()

    def advance(self, dt: float, steps: int = 1) -> None:
        """``step`` without its checks, for a run, which has chosen its step."""
        if self.time < self.reached:
            self.bring_together()
        exhaust(self._steps.advance(dt, steps))

    def bring_together(self) -> None:
        """Begin anew from the present state and time, beyond which steps by error have gone."""
        self.gather()
        self._clock.reached = self._clock.time
        self._steps.restart()

    @abstractmethod
    def gather(self) -> None:
        """Begin anew from the present state, with no past."""

    @functools.cached_property
    def _steps(self) -> Together:
        return Together([self])

    def _warn(self) -> None:
        """Tell once that steps of a given length are too long."""
        if not self._warned and (line := self.error_report()):
            self._warned = True
            LOG.warning(f"{self!r}: {line}")

    def error_report(self) -> str:
        """What steps of a given length have got wrong so far, in words; empty if they are well."""
        with exclusive:
            largest, total = (to_host(getattr(self.pace_arrays, name)) for name in ("largest_error", "total_error"))
        excess = np.maximum(largest / (TELL * self.step_tolerance), total / TELL_TOTAL)
        rod = int(np.argmax(np.where(self.status == Status.OK, excess, 0.0)))
        if self.status[rod] != Status.OK or excess[rod] <= 1:
            return ""
        return (
            f"by t = {self.time:g} a step of rod {rod} had an error of {largest[rod]:.2g} of its length, and all its "
            f"steps {total[rod]:.2g}, by estimate: the result can be wrong without diverging; use shorter steps, or "
            f"let the error choose them"
        )

    @property
    def ends_of_space(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner [3] of the box beyond which rods are frozen; infinite where there is none."""
        return np.full(3, -np.inf), np.full(3, np.inf)

    def set_step(self, dt: SupportsFloat) -> None:
        """Set the length of the next steps; raises SceneError for one that is not positive."""
        dt, _ = check_step(dt)
        with exclusive:
            self._clock.set_step(dt)

    @property
    def has_own_steps(self) -> bool:
        """Whether each rod can take steps of its own."""
        return False

    def advance_to(self, time: SupportsFloat, tolerance: SupportsFloat = TOLERANCE) -> None:
        """Advance to ``time`` in steps whose length follows their error, each rod in steps of its own where it can.

        tolerance: about the error at the end, of places over L and of strains. Raises SceneError for an earlier time.
        """
        time, tolerance = arguments.real("time", time, "zero or more"), arguments.real("tolerance", tolerance)
        if time < self.time:
            raise SceneError(f"time = {time:g}: must not be before the present time, {self.time:g}")
        if not self.has_own_steps:
            exhaust(self._steps.advance_to(time, tolerance))
            return
        self.hold_force()
        with exclusive:
            self.take_own_steps(time, self.step_tolerance * tolerance)
        self._clock.reached = np.inf
        self.show_at(time)

    @property
    def changes_in_time(self) -> bool:
        """Whether parameters of the rods change in time."""
        return False

    def take_own_steps(self, time: float, allowed: float) -> None:
        """Launch steps of each rod until it reaches ``time``; where ``has_own_steps``."""
        raise NotImplementedError

    @property
    @abstractmethod
    def pace_arrays(self) -> Any:
        """``Pace`` on the device: times of the levels of each rod, its next step, and the steps that it has taken."""

    @property
    def steps_taken(self) -> np.ndarray:
        """Steps that each rod has taken [rod]."""
        with exclusive:
            return to_host(self.pace_arrays.taken)

    @property
    def steps_rejected(self) -> np.ndarray:
        """Steps that each rod has tried and repeated, because their error was too large [rod]."""
        with exclusive:
            return to_host(self.pace_arrays.rejected)

    @property
    def reached(self) -> float:
        """The time that steps have reached; not before ``time``."""
        return self._clock.reached

    def show_at(self, time: float) -> None:
        """Make ``time``, readings and positions those of a time within the last step."""
        self._clock.time = time

    @property
    @abstractmethod
    def first_step(self) -> float:
        """The first step that an error may choose, short on every scale of the rods."""

    @property
    @abstractmethod
    def natural_time(self) -> float:
        """The shortest time in which a rod changes as a whole."""

    def prepare_step(self, dt: float) -> bool:
        """Work on the host before a step of ``dt``; returns whether it has replaced the arrays on the device."""
        return False

    def predict_step(self) -> None:
        """Launch what puts ``position_array`` at the end of the step, as far as it can be foretold, for contact."""

    def show(self) -> None:
        """Put ``position_array`` at the present state, where steps leave it elsewhere."""

    def try_step(self) -> None:
        """Launch the rest of a step: its result and its error, which are kept beside the present state."""
        self._launches.try_step()

    def error_of_step(self) -> np.ndarray:
        """Error of the step tried [rod]: of strains over 1/L and their own, of places over L; negative for frozen rods.

        Infinite where the result is not valid.
        """
        with exclusive:
            return to_host(self._step_error)

    @property
    @abstractmethod
    def _step_error(self) -> wp.array:
        """``error_of_step`` on the device [rod]."""

    def give_up(self, allowed: float) -> None:
        """Launch what makes the results of rods whose error is above ``allowed`` invalid: no step may be shorter."""
        self._launches.give_up(allowed)

    def accept_step(self) -> None:
        """Launch what makes the result of the step tried the present state; rods without a valid one are frozen."""
        self._launches.accept()

    def reject_step(self) -> None:
        """Count the step tried as repeated; the present state is as it was."""
        self._launches.reject()

    def finish_step(self) -> None:
        """Advance the time on the host after a step that was accepted."""
        self._clock.tick()

    @property
    @abstractmethod
    def threads(self) -> int:
        """The number of threads that share a step."""

    # --- contact ----------------------------------------------------------------------------------------------------

    @property
    @abstractmethod
    def position_array(self) -> wp.array:
        """Centre line of the present state on the device [rod, node]; length."""

    @property
    @abstractmethod
    def force_array(self) -> wp.array:
        """External force per length in space on the device [rod, node]; contact writes to it."""

    @property
    @abstractmethod
    def contact_stiffness_array(self) -> wp.array:
        """Σ_j w_j |∂f/∂r| per length of each node against its own motion, in space, on the device [rod, node] (3, 3).

        Contact writes to it; allocated by the first call. Steps treat it as the drag D (u − v**) of docs/model.md §6.4.
        """

    @property
    @abstractmethod
    def spacing_array(self) -> wp.array:
        """Δs on the device [rod]; length."""

    @property
    @abstractmethod
    def status_array(self) -> wp.array:
        """``Status`` on the device [rod]; rods that are frozen do not act on others."""

    @property
    def force(self) -> np.ndarray:
        """External force per length in space [rod, node, 3]: of the present state where a function or contact gives it.

        Set it to one vector, or one for each node. Raises SceneError for values that do not fit or are not finite, and
        where a function or contact gives it.
        """
        return self._read_force()

    @force.setter
    def force(self, value: Any) -> None:
        if self._force_from:
            raise SceneError(f"force: it cannot be set, because {self._force_from} gives it at every step")
        given = vectors(value, self.count, self.nodes)
        if self.time < self.reached:  # steps by error have gone beyond the time from which this force acts
            self.bring_together()
        self._given = given
        self._set_force(given)
        self._written = self._given

    def apply_given_force(self) -> None:
        """Write the force that was set, extrapolated to the end of the step from its values at planned steps."""
        if self._given is None:
            return
        values, before, share = self._given, self._given_before, self._clock.share
        if before is not None and self._clock.changing and 0 < share < LONGEST_SHARE:
            values = values + share * (values - before)
        if values is not self._written:
            self._set_force(values)
            self._written = values

    def step_to_event(self, step: float) -> float:
        """A step from the time reached, ended where something happens to a rod that its error might not show."""
        return self.changes.longest_step(self.reached, step)

    def foresee(self, start: float, end: float) -> None:
        """Look at what formulas in t do from a time to another, so that no step by error passes over it."""
        if not self.changes.within(start, end):
            self.changes.foresee(start, end)

    @functools.cached_property
    def changes(self) -> Changes:
        """What formulas and tables in t do, as far as it is foreseen."""
        return self._find_changes()

    def _find_changes(self) -> Changes:
        """What changes in time."""
        return Changes([])

    def next_event(self) -> float:
        """The time of the next event of a rod, beyond which no step goes; an event at the time reached happens."""
        return np.inf

    def end_planned_step(self) -> None:
        """End a step that the user planned: the force set now is the previous one of the next.

        Only a force that changes from step to step is extrapolated: a jump would act backwards for a step.
        """
        given, before = self._given, self._given_before
        self._clock.changing = given is not None and before is not None and not np.array_equal(before, given)
        self.hold_force()
        self._clock.plan()

    def hold_force(self) -> None:
        """Write the force that was set as it is, for readings and for steps by error."""
        self._given_before = self._given
        if self._given is not None and self._written is not self._given:
            self._set_force(self._given)
            self._written = self._given

    def reserve_force(self, source: str) -> None:
        """Refuse forces set by the user from now on, because ``source`` writes the force at every step."""
        self._force_from = source

    def _read_force(self) -> np.ndarray:
        if self._given is not None:
            return self._given.copy()
        with exclusive:
            return to_host(self.force_array)

    def _set_force(self, values: np.ndarray) -> None:
        with exclusive:
            self.force_array.assign(values)

    # --- state and failures -----------------------------------------------------------------------------------------

    @abstractmethod
    def arrays_of_state(self) -> dict[str, wp.array | Tiled]:
        """Every device array that the next step depends on, the external force included, without the clock."""

    def state(self) -> dict[str, np.ndarray]:
        """Everything that the next step depends on. After ``restore`` the next steps have the same bits."""
        with exclusive:
            arrays = {name: to_host(array) for name, array in self.arrays_of_state().items()}
            if self._given is not None:
                arrays["force"] = self._given.copy()
                arrays["force_previous"] = (self._given if self._given_before is None else self._given_before).copy()
            return {**arrays, "clock": self._clock.state(), "steps": self._steps.state()}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a ``state`` of an ensemble with the same parameters.

        A state without a force is one without external forces. Raises SceneError, and changes nothing, for a state that
        lacks arrays or has arrays of other shapes, as those of another kind, count or number of nodes have.
        """
        given = self.check_state(state)
        with exclusive:
            self.allocate_for(given)
            for name, array in self.arrays_of_state().items():
                array.assign(given[name])
            self._restore_force(given)
            self._clock.restore(given["clock"])
            self._steps.restore(given["steps"])

    def _restore_force(self, state: Mapping[str, np.ndarray]) -> None:
        """The forces of a state; one without them has none."""
        set_before, self._written = self._given is not None, None
        self._given = self._given_before = None
        if "force" in state:
            self._given, self._given_before = (np.array(state[name], dtype=float) for name in FORCE_STATE)
        elif set_before:
            self.force_array.zero_()

    def check_state(self, state: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The arrays of a state; raises SceneError naming the first that is missing or does not fit."""
        if not isinstance(state, Mapping):
            raise arguments.wrong("state", state, "a mapping of arrays, as state() returns it")
        with exclusive:
            own = {name: shape_of(array) for name, array in self.arrays_of_state().items()}
        own |= {"clock": self._clock.state().shape, "steps": self._steps.state().shape}
        nodes = self.nodes_of(state)
        own |= {name: (self.count, self.nodes, 3) for name in FORCE_STATE if "force" in state}
        if missing := [name for name in own if name not in state]:
            raise SceneError(f"state: has no {missing[0]!r}; must be a state of {type(self).__name__}")
        given = {}
        for name, array in state.items():
            given[name] = (
                arguments.reals(f"state[{name!r}]", array) if name in ("clock", "steps") else np.asarray(array)
            )
            shape = own.get(name, given[name].shape)
            fits = (shape[0], nodes, *shape[2:]) if shape[1:2] == (self.nodes,) else shape
            if given[name].shape != fits or given[name].dtype.kind not in "iuf":
                raise SceneError(f"state[{name!r}]: has shape {given[name].shape}; must be numbers of shape {fits}")
        return given

    def allocate_for(self, state: Mapping[str, np.ndarray]) -> None:
        """Allocate device arrays of the sizes in ``state``, if they differ from the present ones."""

    def nodes_of(self, state: Mapping[str, np.ndarray]) -> int:
        """The number of nodes in a state that ``restore`` takes."""
        return self.nodes

    @property
    @abstractmethod
    def failed_at(self) -> np.ndarray:
        """The time at which each rod was frozen [rod]; meaningless for the others."""

    def failures(self) -> list[Failure]:
        """The frozen rods."""
        status, when = self.status, self.failed_at
        frozen = np.flatnonzero(status != Status.OK)
        return [Failure(int(rod), float(when[rod]), Status(int(status[rod])).words) for rod in frozen]

    def parameters(self, rod: int) -> dict[str, Any]:
        """The parameters of one rod by name; raises SceneError for a rod that is not there."""
        rod = arguments.whole("rod", rod, 0)
        if rod >= self.count:
            raise SceneError(f"rod = {rod}: must be less than the number of rods, {self.count}")
        return {name: values[rod].tolist() for name, values in self._parameters.items()} | self._settings(rod)

    def _settings(self, rod: int) -> dict[str, Any]:
        """What else defines one rod, by name, in plain types."""
        return {}

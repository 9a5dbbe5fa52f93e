"""The contract of every ensemble of rods with users, the simulation loop, contact and measures.

A kind of rod is a folder beside this file with a subclass of ``Ensemble``; CONTRIBUTING.md says what it provides.
"""

from __future__ import annotations

import logging
from abc import abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import warp as wp

from warp_rods.device import device as device_of
from warp_rods.device import exclusive
from warp_rods.kernels.layout import to_host
from warp_rods.rods.clock import Clock
from warp_rods.rods.per_rod import check_step, vectors
from warp_rods.rods.readings import Readings
from warp_rods.rods.status import Status
from warp_rods.rods.step_limits import StepLimit

LOG = logging.getLogger("warp_rods")
FORCE_STATE = ("force", "force_previous")
"""Arrays of the state that an ensemble without external forces may lack."""


class Failure(NamedTuple):
    """A frozen rod: its number, the time, and what happened."""

    rod: int
    time: float
    what: str


class Parameter:
    """A parameter of an ensemble as a read-only attribute."""

    def __init__(self, description: str):
        self.__doc__ = description

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, ensemble: Ensemble | None, owner: type | None = None) -> Any:
        return self if ensemble is None else ensemble._parameters[self._name]

    def __set__(self, ensemble: Ensemble, value: Any) -> None:
        raise AttributeError(f"{self._name} is fixed once the ensemble is made: make a new ensemble with the new value")


class Ensemble(Readings):
    """``count`` rods of ``nodes`` nodes each, one batch on one device. NumPy in, NumPy out; no files.

    All rods take the same steps. A rod that fails is frozen at its last valid state and gets a ``status``; the other
    rods continue.
    """

    def __init__(self, count: int, nodes: int, parameters: Mapping[str, np.ndarray], device: Any):
        self.count, self.nodes, self.device = count, nodes, device_of(device)
        for values in parameters.values():
            values.setflags(write=False)
        self._parameters: Mapping[str, np.ndarray] = MappingProxyType(dict(parameters))
        with exclusive:
            self._clock = Clock(self.device)
        self._warned = False

    def __repr__(self) -> str:
        frozen = int((self.status != Status.OK).sum())
        state = f"{frozen} of them frozen" if frozen else "all ok"
        what = f"{type(self).__name__}: {self.count} rods of {self.nodes} nodes on {self.device}"
        return f"<{what}, t = {self.time:g}, {state}>"

    # --- steps ------------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """The present time."""
        return self._clock.time

    def step(self, dt: float, steps: int = 1) -> None:
        """Advance by ``steps`` steps of ``dt`` under the present ``force``; second order in ``dt``.

        The order does not suffer when ``dt`` changes, because the coefficients follow the ratio of the steps. A step
        above ``step_limit`` is warned of once, by the logger ``warp_rods``. Raises SceneError for a step that is not
        positive.
        """
        check_step(dt, steps)
        self._warn_of(dt)
        self.advance(dt, steps)

    def advance(self, dt: float, steps: int = 1) -> None:
        """``step`` without its checks, for a run, which has chosen its step."""
        self.set_step(dt)
        for _ in range(steps):
            self.prepare_step(dt)
            self.take_step()
            self.finish_step()

    def _warn_of(self, dt: float) -> None:
        if self._warned:
            return
        limit = self.step_limit
        if dt > limit.step:
            self._warned = True
            LOG.warning(
                f"dt = {dt:g} is above {limit.step:.3g}, the bound on the step of {self!r}: {limit.reason}. Above it "
                f"the result can be wrong without diverging: use a smaller step"
            )

    @property
    @abstractmethod
    def step_limit(self) -> StepLimit:
        """The largest stable step, and the formula that gives it."""

    def set_step(self, dt: float) -> None:
        """Set the length of the next steps."""
        with exclusive:
            self._clock.set_step(dt)

    def prepare_step(self, dt: float) -> None:
        """Work on the host before a step of ``dt``."""

    @abstractmethod
    def take_step(self) -> None:
        """Launch one step of the length given to ``set_step``."""

    def finish_step(self) -> None:
        """Advance the time on the host after a step."""
        self._clock.tick()

    @property
    @abstractmethod
    def recordable(self) -> bool:
        """Whether a step consists of kernel launches of one thread, so that a longer graph may contain it."""

    @property
    @abstractmethod
    def threads(self) -> int:
        """The number of threads that share a step."""

    # --- contact ----------------------------------------------------------------------------------------------------

    @property
    @abstractmethod
    def version(self) -> object:
        """An object that is replaced when device arrays are; graphs recorded before are then invalid."""

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
    def spacing_array(self) -> wp.array:
        """Δs on the device [rod]; length."""

    @property
    @abstractmethod
    def transverse_drag(self) -> np.ndarray:
        """ζ⊥ [rod]."""

    @property
    def force(self) -> np.ndarray:
        """External force per length in space [rod, node, 3]. Set it to one vector, or to one vector for each node."""
        with exclusive:
            return to_host(self.force_array)

    @force.setter
    def force(self, value: Any) -> None:
        self._set_force(value)

    def _set_force(self, value: Any) -> None:
        given = vectors(value, self.count, self.nodes)
        with exclusive:
            self.force_array.assign(given)

    # --- state and failures -----------------------------------------------------------------------------------------

    @abstractmethod
    def arrays_of_state(self) -> dict[str, wp.array]:
        """Every device array that the next step depends on, the external force included, without the clock."""

    def state(self) -> dict[str, np.ndarray]:
        """Everything that the next step depends on. After ``restore`` the next steps have the same bits."""
        with exclusive:
            arrays = {name: to_host(array) for name, array in self.arrays_of_state().items()}
            return {**arrays, "clock": self._clock.state()}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a ``state`` of an ensemble with the same parameters.

        A state without a force is one without external forces.
        """
        with exclusive:
            self.allocate_for(state)
            for name, array in self.arrays_of_state().items():
                if name in state or name not in FORCE_STATE:
                    array.assign(state[name])
                else:
                    array.zero_()
            self._clock.restore(state["clock"])

    def allocate_for(self, state: Mapping[str, np.ndarray]) -> None:
        """Allocate device arrays of the sizes in ``state``, if they differ from the present ones."""

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
        """The parameters of one rod by name."""
        return {name: values[rod].tolist() for name, values in self._parameters.items()}

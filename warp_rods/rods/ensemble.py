"""What every ensemble of rods is to its users, to the loop, to contact and to measures.

A kind of rod is a folder beside this file with a subclass of ``Ensemble``; CONTRIBUTING.md says what it provides.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple

import numpy as np
import warp as wp

from warp_rods.device import device as device_of
from warp_rods.device import exclusive
from warp_rods.kernels.layout import to_host
from warp_rods.rods.clock import Clock
from warp_rods.rods.per_rod import check_step, vectors
from warp_rods.rods.status import Status
from warp_rods.rods.variables import Variable

OF_FORCES = ("force", "force_before")
"""Names of arrays of state that rods without external forces need not have."""


class Failure(NamedTuple):
    """A frozen rod: its number, the time, and what happened."""

    rod: int
    time: float
    what: str


class Reading(NamedTuple):
    """How a variable is read: what brings it up to date, and what takes it then."""

    update: Callable[[], None]
    take: Callable[[], np.ndarray]


class Parameter:
    """A parameter of an ensemble as a read-only attribute: it is fixed when the ensemble is made."""

    def __init__(self, description: str):
        self.__doc__ = description

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, ensemble: Ensemble | None, owner: type | None = None) -> Any:
        return self if ensemble is None else ensemble._parameters[self._name]

    def __set__(self, ensemble: Ensemble, value: Any) -> None:
        raise AttributeError(f"{self._name} is fixed once an ensemble is made: make another one with the new value")


class Ensemble(ABC):
    """``count`` rods of ``nodes`` nodes each, one batch on one device. NumPy in, NumPy out; no files.

    Every reading is a NumPy array of its own. All rods take the same steps; one that fails is frozen at its last
    sound state, with a ``status``, and the others go on.
    """

    saved: ClassVar[Mapping[str, Variable]]
    """The variables of a frame, by name. ``variables`` returns all that do not come from contact."""

    def __init__(self, count: int, nodes: int, parameters: Mapping[str, np.ndarray], device: Any):
        self.count, self.nodes, self.device = count, nodes, device_of(device)
        for values in parameters.values():
            values.setflags(write=False)
        self._parameters: Mapping[str, np.ndarray] = MappingProxyType(dict(parameters))
        with exclusive:
            self._clock = Clock(self.device)

    def __repr__(self) -> str:
        lost = int((self.status != Status.SOUND).sum())
        state = f"{lost} of them frozen" if lost else "all sound"
        what = f"{type(self).__name__}: {self.count} rods of {self.nodes} nodes on {self.device}"
        return f"<{what}, t = {self.time:g}, {state}>"

    # --- steps ------------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """The time reached."""
        return self._clock.time

    def step(self, dt: float, steps: int = 1) -> None:
        """Advance by ``steps`` steps of ``dt`` under the present ``force``; second order in ``dt``.

        A change of ``dt`` keeps the order: the coefficients follow the ratio of the steps. Raises SceneError for a
        step that is not positive.
        """
        check_step(dt, steps)
        self.set_step(dt)
        for _ in range(steps):
            self.prepare_step(dt)
            self.take_step()
            self.finish_step()

    def set_step(self, dt: float) -> None:
        """Make ``dt`` the length of the steps to come."""
        with exclusive:
            self._clock.set_step(dt)

    def prepare_step(self, dt: float) -> None:  # noqa: B027 (most kinds have nothing to prepare)
        """What the host does before a step of ``dt``."""

    @abstractmethod
    def take_step(self) -> None:
        """Launch one step as long as ``set_step`` said."""

    def finish_step(self) -> None:
        """Let the time of a step pass that has been taken."""
        self._clock.tick()

    @property
    @abstractmethod
    def recordable(self) -> bool:
        """Whether a step is kernels alone, on one thread: then ``take_step`` may become a part of a longer graph."""

    @property
    @abstractmethod
    def threads(self) -> int:
        """How many threads share a step."""

    # --- what contact needs -----------------------------------------------------------------------------------------

    @property
    @abstractmethod
    def version(self) -> object:
        """Another object once device arrays were replaced: graphs that were recorded with the old ones are stale."""

    @property
    @abstractmethod
    def position_array(self) -> wp.array:
        """Centre line on the device [rod, node], that of the present state; length."""

    @property
    @abstractmethod
    def force_array(self) -> wp.array:
        """External force per length on the device [rod, node], in space, to be written to."""

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
        """External force per length in space [rod, node, 3], yours to set: one vector, or one a node."""
        with exclusive:
            return to_host(self.force_array)

    @force.setter
    def force(self, value: Any) -> None:
        self._set_force(value)

    def _set_force(self, value: Any) -> None:
        given = vectors(value, self.count, self.nodes)
        with exclusive:
            self.force_array.assign(given)

    # --- readings ---------------------------------------------------------------------------------------------------

    @abstractmethod
    def readings(self) -> dict[str, Reading]:
        """How each variable is read, by its name."""

    @property
    def stride(self) -> int:
        """Every so many nodes are saved."""
        return 1

    def reading(self, name: str) -> np.ndarray:
        """A variable of the present state, at all nodes."""
        with exclusive:
            reading = self.readings()[name]
            reading.update()
            return reading.take()

    def variables(self) -> dict[str, np.ndarray]:
        """The present state as the trajectory keeps it: names and shapes of ``saved``, without those of contact."""
        with exclusive:
            readings = {name: row for name, row in self.readings().items() if name in self.saved}
            for update in dict.fromkeys(row.update for row in readings.values()):
                update()
            taken = {name: row.take() for name, row in readings.items()}
        thin = slice(None, None, self.stride)
        return {name: v[:, thin] if "node" in self.saved[name].dims else v for name, v in taken.items()}

    @property
    def position(self) -> np.ndarray:
        """Centre line r [rod, node, 3]; length."""
        return self.reading("position")

    @property
    def orientation(self) -> np.ndarray:
        """Directors of the material frame, tangent first, as quaternions x, y, z, w [rod, node, 4]."""
        return self.reading("orientation")

    @property
    def strain(self) -> np.ndarray:
        """Twist and the two bendings of the material frame [rod, node, 3]; 1/length."""
        return self.reading("strain")

    @property
    def tension(self) -> np.ndarray:
        """λ [rod, node]; force."""
        return self.reading("tension")

    @property
    def energy(self) -> np.ndarray:
        """Elastic energy [rod]; force times length."""
        return self.reading("energy")

    @property
    def energy_density(self) -> np.ndarray:
        """Elastic energy per length [rod, node]; force."""
        return self.reading("energy_density")

    @property
    def dissipation(self) -> np.ndarray:
        """Power lost to drag [rod]."""
        return self.reading("dissipation")

    @property
    def power(self) -> np.ndarray:
        """Power of all that does work on a rod [rod]: dE/dt is ``power`` less ``dissipation``."""
        return self.reading("power")

    @property
    def status(self) -> np.ndarray:
        """The ``Status`` of each rod [rod]: 0 where it is sound."""
        return self.reading("status")

    @abstractmethod
    def static(self) -> dict[str, np.ndarray]:
        """What the trajectory keeps once: names of ``variables.STATIC``."""

    # --- state and failures -----------------------------------------------------------------------------------------

    @abstractmethod
    def arrays_of_state(self) -> dict[str, wp.array]:
        """Every device array that the next step depends on, the external force included; the clock apart."""

    def state(self) -> dict[str, np.ndarray]:
        """All that the next step depends on; ``restore`` goes on from it to the same bits."""
        with exclusive:
            arrays = {name: to_host(array) for name, array in self.arrays_of_state().items()}
            return {**arrays, "clock": self._clock.state()}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go back to a ``state`` of an ensemble of the same parameters.

        A state without a force is that of rods that felt none.
        """
        with exclusive:
            self.make_room(state)
            for name, array in self.arrays_of_state().items():
                if name in state or name not in OF_FORCES:
                    array.assign(state[name])
                else:
                    array.zero_()
            self._clock.restore(state["clock"])

    def make_room(self, state: Mapping[str, np.ndarray]) -> None:  # noqa: B027 (most kinds have arrays of one size)
        """Make the device arrays those of a ``state``, whose sizes may differ."""

    @property
    @abstractmethod
    def failed_at(self) -> np.ndarray:
        """When each rod was frozen [rod]; without meaning for a sound one."""

    def failures(self) -> list[Failure]:
        """The frozen rods."""
        status, when = self.status, self.failed_at
        lost = np.flatnonzero(status != Status.SOUND)
        return [Failure(int(rod), float(when[rod]), Status(int(status[rod])).words) for rod in lost]

    def parameters(self, rod: int) -> dict[str, Any]:
        """The parameters of one rod by name: what distinguishes it."""
        return {name: values[rod].tolist() for name, values in self._parameters.items()}

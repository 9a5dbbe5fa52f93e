"""An ensemble of active Kirchhoff rods that swim freely: parameters, state, step (model.md §2; thesis chapter 4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import warp as wp

from warp_rods.errors import SceneError
from warp_rods.kernels.free.motion import NOT_FINITE, TOO_BENT
from warp_rods.kernels.free.output import force_field
from warp_rods.kernels.layout import to_host
from warp_rods.rods.free.arrays import PARAMETERS, allocate
from warp_rods.rods.free.flagella import PASSIVE, Flagella
from warp_rods.rods.free.launches import FreeLaunches
from warp_rods.rods.free.readings import FreeReadings
from warp_rods.rods.free.shapes import from_midpoint, initial_strain
from warp_rods.rods.per_rod import check_step, each_rod, vectors
from warp_rods.rods.variables import SWIMMER_VARIABLES

SHAPE = ("bending", "twist", "activity")
MIDPOINT = ("rotation", "position", "angle", "spin", "velocity", "roll")
STATUS = {
    0: "well",
    int(NOT_FINITE): "became non-finite",
    int(TOO_BENT): "came to bend by more than half a turn between nodes",
}
UPRIGHT = np.eye(3)


class FreeRods(FreeReadings):
    """Active rods, each with its own parameters. NumPy in, NumPy out; no files.

    Dimensionless as model.md §1: length L, velocity f*/ζ∥, time ζ∥L/f*. One number for all rods or one a rod:
    bend β⊥, twist β∥, moment M, drag_ratio η, rotational_drag ηr. flagella: ``Flagella``, a mapping with its
    fields, or None for passive rods. shape: a table as in a scene, or strains [rod, node, 3] of the material
    frame, index 0 twist; strains are set to 0 at the ends, which are free. symmetric: keep the π-rotation
    symmetry of C.4 exactly, for rods that start with it in the gauge of C.49. external: force per length in
    space, a function ``(t, position [rod, node, 3], rotation [rod, node, 3, 3]) -> [rod, node, 3]`` or a
    ``wp.func`` ``(x, tangent, t) -> vec3d``; the columns of rotation are the Bishop frame, tangent first.
    position [rod, 3], rotation [rod, 3, 3]: the material frame of the middle node at the start.

    Raises SceneError for an even number of nodes or fewer than 17, for impossible parameters, and for lists
    that do not match.
    """

    saved = SWIMMER_VARIABLES

    def __init__(
        self,
        count: int,
        nodes: int = 65,
        *,
        bend: Any,
        twist: Any,
        moment: Any = 0.0,
        drag_ratio: Any = 2.0,
        rotational_drag: Any = 3e-3,
        flagella: Flagella | Mapping[str, Any] | None = Flagella(),  # noqa: B008 (frozen)
        shape: Any = None,
        symmetric: bool = False,
        device: Any = None,
        external: Callable | None = None,
        position: Any = (0.0, 0.0, 0.0),
        rotation: Any = UPRIGHT,
    ):
        if nodes < 17 or nodes % 2 == 0:
            raise SceneError(f"nodes = {nodes}: must be an odd whole number, 17 or more")
        if flagella is None:
            flagella = PASSIVE
        elif isinstance(flagella, Mapping):
            flagella = Flagella(**flagella)
        self.count, self.nodes, self.symmetric, self.flagella = count, nodes, symmetric, flagella
        self.device = wp.get_device(device)
        self.time = 0.0
        self._next_step = self._last_step = 0.0
        given = (bend, twist, moment, drag_ratio, rotational_drag, flagella.relaxation, flagella.diffusion)
        self._values = {name: _parameter(name, value, count) for name, value in zip(PARAMETERS, given, strict=True)}
        self._arrays = allocate(self._values, nodes, flagella.number, symmetric, self.device)
        self._place(shape, position, rotation)
        self._run = FreeLaunches(self._arrays)
        self._external: Callable | None = None
        if isinstance(external, wp.Function):
            self._bear_loads(force_field(external))
        elif external is not None:
            self._bear_loads()
            self._external = external

    def _place(self, shape: Any, position: Any, rotation: Any) -> None:
        """Strains of the material frame to the Bishop frame: the two agree at the midpoint at the start."""
        strain = initial_strain(shape, self.nodes, self._values)
        bishop = (strain[..., 1] + 1j * strain[..., 2]) * np.exp(1j * from_midpoint(strain[..., 0]))
        activity = self.flagella.start(np.linspace(-0.5, 0.5, self.nodes))
        if self.symmetric:
            _check_symmetry(bishop, strain[..., 0], _filled(activity, (self.count, self.nodes)))
        now, midpoint = self._arrays.now, self._arrays.midpoint
        now.bending.assign(np.stack([bishop.real, bishop.imag], axis=-1))
        now.twist.assign(np.ascontiguousarray(strain[..., 0]))
        now.activity.assign(_filled(activity, (self.count, self.nodes)))
        midpoint.rotation.assign(_filled(rotation, (self.count, 3, 3)))
        midpoint.position.assign(_filled(position, (self.count, 3)))

    def _bear_loads(self, field: Any = None) -> None:
        if self.symmetric:
            raise SceneError("symmetric = true: an external force could break the symmetry")
        self._run.bear_loads(field)

    def step(self, dt: float, steps: int = 1) -> None:
        """Advance by ``steps`` steps of ``dt`` under the present ``force``; second order (SBDF2, Magnus).

        A change of ``dt`` keeps the order: the coefficients follow the ratio of the steps.
        """
        check_step(dt, steps)
        self.set_step(dt)
        for _ in range(steps):
            self._ask()
            self.take_step()
            self.passed(dt)

    @property
    def recordable(self) -> bool:
        """Whether a step is kernels alone, on one thread: then ``take_step`` can be a part of a recorded sequence."""
        return self._external is None and self._run.threads == 1

    def take_step(self) -> None:
        """Launch one step as long as ``set_step`` said."""
        self._run.advance()

    def passed(self, dt: float) -> None:
        """Let the time of a step of ``dt`` pass, which has been taken."""
        self.time += dt
        self._last_step = dt

    def set_step(self, dt: float) -> None:
        """Make ``dt`` the length of the steps to come."""
        if dt != self._next_step:
            ratio = dt / self._last_step if self._last_step else 0.0
            self._arrays.clock.assign([dt, ratio, self.time])
            self._next_step = dt

    def _ask(self) -> None:
        """Take the force of this moment from the function given as ``external``."""
        if self._external is not None:
            self.force = self._external(self.time, to_host(self._arrays.position), to_host(self._arrays.rotation))

    @property
    def force(self) -> np.ndarray:
        """External force per length in space [rod, node, 3], yours to set."""
        return to_host(self.force_array)

    @force.setter
    def force(self, value: np.ndarray) -> None:
        self.force_array.assign(vectors(value, self.count, self.nodes))

    @property
    def force_array(self) -> wp.array:
        """External force per length in space on the device [rod, node]; asking for it makes steps heed it."""
        if self._run.force is None:
            self._bear_loads()
        assert self._run.force is not None
        return self._run.force

    @property
    def position_array(self) -> wp.array:
        """Centre line on the device [rod, node]: always present where there are external forces."""
        if self._run.force is None:
            self._run.frames()
        return self._arrays.position

    @property
    def spacing_array(self) -> wp.array:
        """Δs on the device [rod]."""
        return self._arrays.spacing

    @property
    def cross_drag(self) -> np.ndarray:
        """ζ⊥ = η [rod], in units of ζ∥."""
        return self._values["drag_ratio"]

    def static(self) -> dict[str, np.ndarray]:
        """What the trajectory keeps once: names of ``variables.STATIC``."""
        return {"length": np.ones(self.count), **{name: self._values[name] for name in PARAMETERS[:5]}}

    def state(self) -> dict[str, np.ndarray]:
        """All that the next step depends on; ``restore`` goes on from it to the same bits."""
        return {name: to_host(array) for name, array in self._kept().items()} | {
            "time": np.array([self.time, self._next_step, self._last_step])
        }

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Go back to a ``state`` of an ensemble of the same shape and parameters."""
        if "load" in state:
            _ = self.force_array
        for name, array in self._kept().items():
            array.assign(state[name])
        self.time, self._next_step, self._last_step = (float(value) for value in state["time"])
        if self._run.force is not None:
            self._run.frames()

    def _kept(self) -> dict[str, wp.array]:
        a = self._arrays
        arrays = {name: getattr(a.now, name) for name in SHAPE}
        arrays |= {f"{name}_change": getattr(a.change, name) for name in SHAPE}
        arrays |= {f"midpoint_{name}": getattr(a.midpoint, name) for name in MIDPOINT}
        arrays |= {"status": a.rods.status, "failed_at": a.failed_at, "clock": a.clock}
        if self._run.force is not None:
            arrays |= {"load": a.load.before, "force": self._run.force}
        return arrays

    def failures(self) -> list[tuple[int, float, str]]:
        """Frozen rods: number, time and what happened."""
        status, when = self.status, self._arrays.failed_at.numpy()
        return [(int(rod), float(when[rod]), STATUS[int(status[rod])]) for rod in np.flatnonzero(status)]

    def parameters(self, rod: int) -> dict[str, float]:
        """What distinguishes one rod, to name it by."""
        return {name: float(values[rod]) for name, values in self._values.items()}


def _check_symmetry(bending: np.ndarray, twist: np.ndarray, activity: np.ndarray) -> None:
    """Raises SceneError for a start without the parities of C.49: k(−s) = −k̄(s), τ even, f odd."""
    odd = {
        "shape": np.abs(bending[:, ::-1] + bending.conj()).max() / max(np.abs(bending).max(), 1e-300),
        "shape (twist)": np.abs(twist[:, ::-1] - twist).max() / max(np.abs(twist).max(), 1e-300),
        "flagella": np.abs(activity[:, ::-1] + activity).max(),
    }
    for name, residual in odd.items():
        if residual > 1e-9:
            raise SceneError(f"symmetric = true: the {name} at the start lacks the symmetry (C.49); even modes have it")


def _parameter(name: str, value: Any, count: int) -> np.ndarray:
    """One value a rod of a parameter: positive, but for the moment of either sign and a diffusion that may be 0."""
    try:
        values = each_rod(value, count)
    except ValueError as error:
        raise SceneError(f"{name}: {error}") from None
    allowed = np.isfinite(values) & ((name == "moment") | (values > 0) | ((name == "diffusion") & (values == 0)))
    if not allowed.all():
        raise SceneError(f"{name} = {values[~allowed][0]:g}: must be positive")
    return values


def _filled(value: Any, shape: tuple[int, ...]) -> np.ndarray:
    return np.ascontiguousarray(np.broadcast_to(np.asarray(value, dtype=float), shape))

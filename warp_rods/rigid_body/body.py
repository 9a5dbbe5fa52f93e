"""Rigid bodies: parameters, state, readings and steps."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.documented import Documented
from warp_rods.errors import SceneError
from warp_rods.frames import checks
from warp_rods.rigid_body.potential import Potential, check_gradient, evaluate, wrench
from warp_rods.rigid_body.variational import cayley, cross, half_turn, momentum, on


class RigidBody(metaclass=Documented):
    """Rigid bodies with the Lagrangian ½ ω·Jω + ½ u·Mu − V(R, r) (3.35) to (3.45). NumPy in, NumPy out.

    One body, or any number at once: arrays have any leading axes [...], which are those of all arguments together.
    inertia [..., 3]: principal moments J, whose axes are those of the body frame. mass: M, a number, or [..., 3] along
    these axes (a body in an ideal fluid has different ones); [body, 1] for one number a body; None for bodies that turn
    about a fixed point, the place ``position``. rotation [..., 3, 3], position [..., 3]: the frame S = (R, r) at the
    start, of the centre of mass. angular_velocity ω, velocity u [..., 3]: in the body frame. Units are the user's.

    potential: a function ``(R, r) -> (V, dV/dR, dV/dr)`` of frames [..., 3, 3], [..., 3] that returns arrays [...],
    [..., 3, 3] (column i: the gradient by the director b_i) and [..., 3]. Weight m g at R c + r, for example:

        def weight(R, r):
            height = r[..., 2] + R[..., 2, :] @ c
            return m * g * height, m * g * np.outer(e_z, c) + 0 * R, m * g * e_z + 0 * r

    ``step`` is a variational integrator on SE(3), symmetric and second order. It conserves
    the momentum of every symmetry to round-off: all of the spatial momentum without a potential. The energy oscillates
    by O(Δt²) and does not drift. Raises SceneError for impossible values, and where the gradient is not that of V.
    """

    def __init__(
        self,
        inertia: Any,
        mass: Any = 1.0,
        *,
        rotation: Any = np.eye(3),  # noqa: B008 (never changed)
        position: Any = (0.0, 0.0, 0.0),
        angular_velocity: Any = (0.0, 0.0, 0.0),
        velocity: Any = (0.0, 0.0, 0.0),
        potential: Potential | None = None,
    ):
        self._held = mass is None
        J = checks.vectors("inertia", inertia)
        M = np.ones(3) if mass is None else checks.finite("mass", mass)
        arguments.check("inertia", J, "positive")
        arguments.check("mass", M, "positive")
        R, r = checks.rotations("rotation", rotation), checks.vectors("position", position)
        omega, u = checks.vectors("angular_velocity", angular_velocity), checks.vectors("velocity", velocity)
        if self._held and u.any():
            raise arguments.wrong("velocity", velocity, "zero for a body that turns about a fixed point (mass = None)")
        shape = _together(inertia=J, mass=M, rotation=R[..., 0], position=r, angular_velocity=omega, velocity=u)
        self._J, self._M, self._r, omega, u = (np.array(np.broadcast_to(a, shape)) for a in (J, M, r, omega, u))
        self._R = np.array(np.broadcast_to(R, (*shape, 3)))
        self._directed = not self._held and bool((self._M[..., :1] != self._M).any())
        self._moment, self._force = self._J * omega, self._M * u
        self._potential = potential
        self._time = 0.0
        if potential is not None:
            arguments.function("potential", potential, 2, "a function (R, r) -> (V, dV/dR, dV/dr)")
            size = np.sqrt(self._J.max(axis=-1, keepdims=True) / self._M.max(axis=-1, keepdims=True))
            check_gradient(potential, self._R, self._r, size, self._held)
        self._wrench = wrench(potential, self._R, self._r, self._held)

    def __repr__(self) -> str:
        bodies = "a body" if self._r.ndim == 1 else f"bodies {list(self._r.shape[:-1])}"
        how = " about a fixed point" if self._held else ""
        return f"<RigidBody: {bodies}{how}, t = {self._time:g}>"

    # --- readings ---------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """The time t since the start."""
        return self._time

    @property
    def rotation(self) -> np.ndarray:
        """R [..., 3, 3]: its columns are the axes of the body."""
        return self._R.copy()

    @property
    def position(self) -> np.ndarray:
        """r [..., 3], in space."""
        return self._r.copy()

    @property
    def angular_velocity(self) -> np.ndarray:
        """ω [..., 3] in the body frame (3.33)."""
        return self._moment / self._J

    @property
    def velocity(self) -> np.ndarray:
        """u = Rᵀ ∂t r [..., 3] in the body frame (3.33)."""
        return self._force / self._M

    @property
    def momentum(self) -> tuple[np.ndarray, np.ndarray]:
        """(Jω, Mu), each [..., 3], in the body frame: ∇_ω 𝓛 and ∇_u 𝓛 of (3.44), (3.45)."""
        return self._moment.copy(), self._force.copy()

    @property
    def spatial_momentum(self) -> tuple[np.ndarray, np.ndarray]:
        """Angular momentum about the origin (of held bodies: about their fixed point) and linear one, in space."""
        linear = on(self._R, self._force)
        arm = np.zeros(3) if self._held else self._r
        return on(self._R, self._moment) + np.cross(arm, linear), linear

    @property
    def kinetic_energy(self) -> np.ndarray:
        """½ ω·Jω + ½ u·Mu [...]."""
        return 0.5 * np.sum(self._moment**2 / self._J + self._force**2 / self._M, axis=-1)

    @property
    def potential_energy(self) -> np.ndarray:
        """V(R, r) [...]."""
        if self._potential is None:
            return np.zeros(self._r.shape[:-1])
        return evaluate(self._potential, self._R, self._r)[0]

    @property
    def energy(self) -> np.ndarray:
        """Kinetic and potential energy [...]."""
        return self.kinetic_energy + self.potential_energy

    # --- motion -----------------------------------------------------------------------------------------------------

    def step(self, dt: float, steps: int = 1) -> None:
        """Take steps of length ``dt``; negative ones go back the same way, to round-off.

        The step makes Σ Δt 𝓛 stationary, with S_{k+1} = S_k (H², H y), H = cay(Δt ω/2), y = Δt u, and V by the
        trapezoid rule (docs/model.md §4.2). Raises SceneError where a body turns by more than a radian in a step.
        """
        dt = arguments.real("dt", dt, arguments.ANY)
        if dt == 0:
            raise arguments.wrong("dt", dt, "different from zero")
        for _ in range(arguments.whole("steps", steps)):
            self._step(dt)

    def _step(self, dt: float) -> None:
        half = 0.5 * dt
        moment, force = self._moment + half * self._wrench[0], self._force + half * self._wrench[1]
        z = half_turn(self._J, self._M, dt * moment, dt * force, self._directed)
        if z is None:
            raise SceneError(
                f"dt = {dt:g}: at t = {self._time:g} a body turns by more than a radian in a step; "
                f"try dt = {0.1 * dt:.2g}"
            )
        H = cayley(z)
        back = np.swapaxes(H, -1, -2)
        l = dt * on(back, force)
        y = l / self._M
        self._r = self._r + on(self._R @ H, y)
        R = self._R @ H @ H
        self._R = R @ (1.5 * np.eye(3) - 0.5 * np.swapaxes(R, -1, -2) @ R)  # against the growth of round-off
        self._wrench = wrench(self._potential, self._R, self._r, self._held)
        self._moment = momentum(-z, 2 * self._J * z, -cross(y, l)) / dt + half * self._wrench[0]
        self._force = on(back, l) / dt + half * self._wrench[1]
        self._time += dt


def _together(**arrays: np.ndarray) -> tuple[int, ...]:
    """The shape [..., 3] of all of them together."""
    try:
        return np.broadcast_shapes(*(array.shape for array in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape[:-1]}" for name, array in arrays.items())
        raise SceneError(f"leading axes must agree; given are {shapes}") from None

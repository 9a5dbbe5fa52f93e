"""Fixed shapes of a free swimmer, i.e. zeros of the equations that its time stepper integrates, and their stability.

A fixed shape in space may rotate about its own tangent. In the Bishop frame this means ``dk/dt = iΩk`` with the same Ω
at every node.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.documented import Documented
from warp_rods.errors import SceneError
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import from_midpoint
from warp_rods.theory.steady_equations import Equations, Swimmer, solve

__all__ = ["FixedShape", "Swimmer", "at_rest", "settled", "start"]

TOLERANCE = 1e-7
"""Root mean square of the last Newton step. Round-off of ∂⁴ prevents less for stiff rods with many nodes."""
MAX_ITERATIONS = 15
DIVERGENCE = 1e6
"""Size of a Newton step above which the iteration is taken to diverge."""


@dataclass(frozen=True)
class FixedShape(metaclass=Documented):
    """A shape of a swimmer, and the rate Ω = ``spin`` at which it rotates about its own tangent in the Bishop frame.

    fields: Re k, Im k, τ, f [4, node]; 1/L and f*. ``dk/dt = iΩk``, while τ and f are constant.
    """

    swimmer: Swimmer
    fields: np.ndarray = field(repr=False)
    spin: float = 0.0

    @property
    def bending(self) -> np.ndarray:
        """k = Ω[1] + iΩ[2] in the Bishop frame [node], 1/L."""
        return self.fields[0] + 1j * self.fields[1]

    @property
    def curvature(self) -> np.ndarray:
        """Signed curvature κ = Ω[2] of a planar shape [node], 1/L."""
        return self.fields[1]

    @property
    def twist(self) -> np.ndarray:
        """τ [node], 1/L."""
        return self.fields[2]

    @property
    def activity(self) -> np.ndarray:
        """f [node], f*."""
        return self.fields[3]

    def rods(self) -> FreeRods:
        """An ensemble of this one rod, which can be stepped in time."""
        return self.swimmer.rods(self.fields[None], self.swimmer.parameters, self.swimmer.symmetric)

    def write_scene(self, path: str | Path, end: float = 10.0, name: str = "cell") -> Path:
        """Write a scene that starts from exactly this shape, which is in a file ``.npz`` beside it; returns its path.

        Files of these names are replaced. Raises SceneError where it cannot be written.
        """
        from warp_rods.theory.steady_scene import write_scene

        return write_scene(self, path, end, name)

    @property
    def speed(self) -> float:
        """Speed |u| of the middle node, f*/ζ∥."""
        rates, middle = self.rods().rates(), self.swimmer.nodes // 2
        along = rates["axial"][0, middle - 1 : middle + 1].mean()
        return float(np.hypot(along, abs(rates["transverse"][0, middle])))

    @property
    def angular_speed(self) -> float:
        """Rate |ω| at which the shape turns in space, radians per ζ∥L/f*."""
        across = self.rods().rates()["angular_velocity"][0]
        middle = self.swimmer.nodes // 2
        return float(np.hypot(abs(across[middle - 1 : middle + 1].mean()), self.spin))

    def released(self) -> FixedShape:
        """The same shape, free to leave its plane and symmetry: its eigenvalues are those of all perturbations."""
        return replace(self, swimmer=replace(self.swimmer, planar=False, symmetric=False))

    def eigenvalues(self, count: int = 6) -> np.ndarray:
        """Leading ``count`` eigenvalues of the equations linearised about the shape, largest real part first; f*/(ζ∥L).

        In the frame that rotates with the shape, without the neutral mode of that rotation. Perturbations are
        restricted to those of the swimmer: planar, symmetric, or neither.
        """
        equations = Equations(self.swimmer)
        state = equations.state(self.fields)
        return equations.spectrum(equations.linearise(state, self.swimmer.parameters)[1], state, self.spin)[:count]


def at_rest(shape: FixedShape) -> FixedShape:
    """The fixed shape next to ``shape``, stable or not, by Newton's method; exact to round-off.

    Raises ArithmeticError where none is found, and where fixed shapes form a continuum (D = 0).
    """
    equations, parameters = Equations(shape.swimmer), shape.swimmer.parameters
    state = equations.state(shape.fields)
    spin = equations.spin(state)
    for _ in range(MAX_ITERATIONS):
        residual, system, _ = equations.system(state, spin, parameters)
        step = solve(system[:, :-1], residual)
        state, spin = state - step[:-1], spin - float(step[-1])
        if np.sqrt(np.mean(step**2)) < TOLERANCE:
            return FixedShape(shape.swimmer, equations.fields(state[None])[0], spin)
        if not np.abs(step).max() < DIVERGENCE:
            break
    raise ArithmeticError("no fixed shape was found: start closer to one, for example from a longer run in time")


def start(swimmer: Swimmer, strain: Any, activity: Any) -> FixedShape:
    """A shape from which to start: strain [node, 3] in the material frame, as trajectories have it, and f [node]."""
    tau, bend1, bend2 = np.moveaxis(np.asarray(strain, dtype=float), -1, 0)
    bishop = (bend1 + 1j * bend2) * np.exp(1j * from_midpoint(tau[None])[0])
    fields = np.stack([bishop.real, bishop.imag, tau, np.asarray(activity, dtype=float)])
    if fields.shape != (4, swimmer.nodes):
        raise SceneError(
            f"strain, activity: given at {fields.shape[1]} nodes; must be {swimmer.nodes}, the nodes of the swimmer"
        )
    return FixedShape(swimmer, fields)


def settled(
    swimmer: Swimmer, shape: Any = None, flagella: Any = "tanh", time: float = 10.0, step: float | None = None
) -> FixedShape:
    """The fixed shape that a swimmer reaches: a simulation of duration ``time``, then Newton's method.

    shape, flagella: initial shape and profile as ``FreeRods`` takes them. step: Δt; chosen by error if left out. Raises
    ArithmeticError where the simulation ends far from any fixed shape.
    """
    profile = flagella if swimmer.held is None else np.array(swimmer.held)
    given: dict[str, Any] = dict(swimmer.parameters)
    field = Flagella(given.pop("relaxation"), given.pop("diffusion"), profile, law=swimmer.law)
    rods = FreeRods(1, swimmer.nodes, shape=shape, flagella=field, symmetric=swimmer.symmetric, device="cpu", **given)
    if step is None:
        rods.advance_to(time)
    else:
        rods.step(step, round(time / step))
    if failures := rods.failures():
        raise ArithmeticError(f"the swimmer {failures[0][2]} at time {failures[0][1]:g}: take a smaller step")
    return at_rest(start(swimmer, rods.strain[0], rods.activity[0]))

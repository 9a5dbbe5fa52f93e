"""Fixed shapes of a free swimmer: zeros of the equations that its time stepper integrates, and their stability.

A fixed shape in space may turn about its own tangent: in the Bishop frame ``dk/dt = iΩk`` with one Ω all along it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import from_midpoint
from warp_rods.theory.steady_equations import Equations, Swimmer, solved

__all__ = ["FixedShape", "Swimmer", "at_rest", "settled", "start"]

AT_REST = 1e-7
"""Root mean square of the last Newton step, as close as round-off of ∂⁴ lets stiff, fine rods come."""
TRIES = 15
TOO_FAR = 1e6
"""Newton step at which it is given up."""


@dataclass(frozen=True)
class FixedShape:
    """A shape of a swimmer, and the rate Ω at which it turns about its own tangent in the Bishop frame.

    fields: Re k, Im k, τ, f [4, node], 1/L and f*. At rest ``dk/dt = iΩk`` and τ, f do not change.
    """

    swimmer: Swimmer
    fields: np.ndarray = field(repr=False)
    spin: float = 0.0

    @property
    def bending(self) -> np.ndarray:
        """k = Ω[1] + iΩ[2] of the Bishop frame [node], 1/L."""
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
        """An ensemble of this one rod, to step in time."""
        return self.swimmer.rods(self.fields[None], self.swimmer.parameters, self.swimmer.symmetric)

    @property
    def speed(self) -> float:
        """|u| of the midpoint, f*/ζ∥."""
        rates, middle = self.rods().rates(), self.swimmer.nodes // 2
        along = rates["axial"][0, middle - 1 : middle + 1].mean()
        return float(np.hypot(along, abs(rates["transverse"][0, middle])))

    def eigenvalues(self, count: int = 6) -> np.ndarray:
        """Leading ``count`` eigenvalues of the rates about the shape, complex, largest real part first; ζ∥L/f* = 1.

        Seen from the frame that turns with it, and without the neutral direction in which that frame turns.
        Perturbations are those that the swimmer allows: planar, symmetric.
        """
        equations = Equations(self.swimmer)
        state = equations.state(self.fields)
        return equations.spectrum(equations.linear(state, self.swimmer.parameters)[1], state, self.spin)[:count]


def at_rest(shape: FixedShape) -> FixedShape:
    """The fixed shape near to ``shape``, stable or not, by Newton's method; exact to round-off.

    Raises ArithmeticError where none is found, or where it is one of a continuum (D = 0).
    """
    equations, parameters = Equations(shape.swimmer), shape.swimmer.parameters
    state = equations.state(shape.fields)
    spin = equations.spin(state)
    for _ in range(TRIES):
        residual, system, _ = equations.system(state, spin, parameters)
        step = solved(system[:, :-1], residual)
        state, spin = state - step[:-1], spin - float(step[-1])
        if np.sqrt(np.mean(step**2)) < AT_REST:
            return FixedShape(shape.swimmer, equations.fields(state[None])[0], spin)
        if not np.abs(step).max() < TOO_FAR:
            break
    raise ArithmeticError("no fixed shape was found: start closer to one, say from a longer run in time")


def start(swimmer: Swimmer, strain: Any, activity: Any) -> FixedShape:
    """A shape to start from: strain [node, 3] of the material frame, as in a trajectory's last frame, and f [node]."""
    tau, bend1, bend2 = np.moveaxis(np.asarray(strain, dtype=float), -1, 0)
    bishop = (bend1 + 1j * bend2) * np.exp(1j * from_midpoint(tau[None])[0])
    fields = np.stack([bishop.real, bishop.imag, tau, np.asarray(activity, dtype=float)])
    if fields.shape != (4, swimmer.nodes):
        raise SceneError(f"strain, activity: of {fields.shape[1]} nodes; the swimmer has {swimmer.nodes}")
    return FixedShape(swimmer, fields)


def settled(
    swimmer: Swimmer, shape: Any = None, flagella: Any = "tanh", time: float = 10.0, step: float = 1e-3
) -> FixedShape:
    """The fixed shape that a swimmer comes to: a run of length ``time``, then Newton's method.

    shape, flagella: start and profile as ``FreeRods`` takes them. Raises ArithmeticError where the run ends far
    from any fixed shape.
    """
    profile = flagella if swimmer.held is None else np.array(swimmer.held)
    given: dict[str, Any] = dict(swimmer.parameters)
    field = Flagella(given.pop("relaxation"), given.pop("diffusion"), profile, law=swimmer.law)
    rods = FreeRods(1, swimmer.nodes, shape=shape, flagella=field, symmetric=swimmer.symmetric, device="cpu", **given)
    rods.step(step, round(time / step))
    if failures := rods.failures():
        raise ArithmeticError(f"the swimmer {failures[0][2]} at time {failures[0][1]:g}: take a smaller step")
    return at_rest(start(swimmer, rods.strain[0], rods.activity[0]))

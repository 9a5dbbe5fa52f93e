"""Linear stability of a filament clamped at its start: equilibria, spectra, critical lengths (docs/model.md §3).

The rates are those of ``BoundRods``. Its Jacobian is computed by finite differences from one batch of filaments, each
with Ω perturbed at one node, so that no equation is derived a second time.
"""

from __future__ import annotations

__all__ = ["Clamped", "critical_length", "equilibrium", "follow", "growth_rate", "linearise"]

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq

from warp_rods.documented import Documented
from warp_rods.membranes.surfaces import Surface
from warp_rods.rods.bound.rods import BoundRods

PERTURBATION = 1e-4
"""Change of Ω, in units of 1/length. At this size truncation error and round-off of the differences are equal."""
MAX_STEPS = 200
TOLERANCE = 1e-8
"""Largest change of Ω, in units of 1/length, in the last Newton step of an equilibrium."""
MAX_CHANGE = 0.3
"""Largest change of Ω, in units of 1/length, in one step of the relaxation."""
FIRST_CHANGE = 1e-2
"""Change of Ω, in units of 1/length, in the first step of the relaxation, approximately."""


@dataclass(frozen=True)
class Clamped(metaclass=Documented):
    """A filament clamped at ``position`` [3] along ``direction`` [3] on ``surface``; its tip is free.

    ``parameters``: stiffness, intrinsic and drag, each [3], as ``BoundRods`` takes them. The functions below take its
    length. A shape is Ω [nodes − 1] at all nodes but the last (there Ω = σ3), or one number; 1/length.
    """

    surface: Surface
    position: Any
    direction: Any
    nodes: int = 65
    parameters: dict[str, Any] = field(default_factory=dict)

    def filaments(self, length: float, shapes: np.ndarray) -> BoundRods:
        """An ensemble on the CPU: this filament in each of the ``shapes`` [shape, nodes − 1]."""
        return BoundRods(
            self.surface,
            np.tile(self.position, (len(shapes), 1)),
            np.tile(self.direction, (len(shapes), 1)),
            nodes=self.nodes,
            length=length,
            at="start",
            ends=("clamped", "free"),
            geodesic_curvature=np.pad(shapes, ((0, 0), (0, 1))),
            device="cpu",
            **self.parameters,
        )

    def rates(self, length: float, shapes: np.ndarray) -> np.ndarray:
        """∂Ω/∂t (D.27) of ``shapes`` [shape, nodes − 1]; 1/length/time."""
        rods = self.filaments(length, shapes)
        return rods.reading("geodesic_rate")[:, :-1]


def linearise(filament: Clamped, length: float, shape: Any = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """∂Ω/∂t [nodes − 1] of a shape, and its Jacobian with respect to Ω [nodes − 1, nodes − 1]; 1/time."""
    size, step = filament.nodes - 1, PERTURBATION / length
    change = step * np.eye(size)
    rates = filament.rates(length, np.vstack([change, -change, np.zeros(size)]) + shape)
    return rates[-1], (rates[:size] - rates[size:-1]).T / (2 * step)


def equilibrium(filament: Clamped, length: float, start: Any = 0.0) -> np.ndarray:
    """The equilibrium shape [nodes − 1] to which a filament relaxes from the shape ``start``.

    Implicit Euler steps with one Newton iteration each and increasing time steps, until a full Newton step for
    equilibrium changes nothing. A start in equilibrium is returned, stable or not. Raises ArithmeticError where no
    equilibrium is found.
    """
    shape = np.broadcast_to(np.asarray(start, dtype=float), filament.nodes - 1)
    time_step = None
    for _ in range(MAX_STEPS):
        rate, jacobian = linearise(filament, length, shape)
        newton = np.linalg.solve(-jacobian, rate)
        if length * np.abs(newton).max() < TOLERANCE:
            return shape + newton
        time_step = time_step or FIRST_CHANGE / (length * np.abs(rate).max())
        change = np.linalg.solve(np.eye(len(shape)) / time_step - jacobian, rate)
        size = length * np.abs(change).max()
        shape = shape + change * min(1.0, MAX_CHANGE / size)
        time_step *= np.clip(0.5 * MAX_CHANGE / size, 0.5, 2.0)
    raise ArithmeticError(
        f"no equilibrium was found for a filament of length {length:g} in {MAX_STEPS} steps: start closer to one"
    )


def follow(filament: Clamped, lengths: Sequence[float], start: Any = 0.0) -> np.ndarray:
    """Equilibrium shapes [length, nodes − 1] of a filament whose length slowly goes through ``lengths``, up or down.

    ``start``: the shape from which the filament relaxes at the first length. Each following relaxation starts from the
    previous shape at equal arc length. A shape that has become unstable, or has ceased to exist, is thus replaced by
    the one to which the filament snaps.
    """
    tip = filament.parameters.get("intrinsic", (0.0, 0.0, 0.0))[2]
    fraction = np.linspace(0.0, 1.0, filament.nodes)
    shapes = [equilibrium(filament, lengths[0], start)]
    for before, length in pairwise(lengths):
        guess = np.interp(length * fraction[:-1], before * fraction, np.append(shapes[-1], tip))
        shapes.append(equilibrium(filament, length, guess))
    return np.array(shapes)


def growth_rate(filament: Clamped, length: float, shape: Any = 0.0) -> float:
    """Largest real part of the eigenvalues of the Jacobian at a shape; 1/time. Negative: the shape is stable."""
    return float(np.linalg.eigvals(linearise(filament, length, shape)[1]).real.max())


def critical_length(filament: Clamped, lengths: tuple[float, float], start: Any = 0.0) -> float:
    """The length between two ``lengths`` at which the equilibrium next to ``start`` (0: the geodesic) becomes unstable.

    Second order in Δs. Raises ValueError where the filament is stable at both lengths, or unstable at both.
    """

    def rate(length: float) -> float:
        return growth_rate(filament, length, equilibrium(filament, length, start))

    ends = [rate(length) for length in lengths]
    if ends[0] * ends[1] > 0:
        stability = "stable" if ends[0] < 0 else "unstable"
        raise ValueError(
            f"filaments of length {lengths[0]:g} and {lengths[1]:g} are both {stability}: choose lengths on both sides "
            f"of the critical one"
        )
    return float(brentq(rate, *lengths, xtol=1e-9 * lengths[1]))

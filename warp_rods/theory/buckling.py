"""Linear stability of a filament clamped at its start: equilibria, spectra and critical lengths (model §3).

The operator is that of the ensemble itself: one batch of filaments, each with Ω perturbed at one node, gives its
columns as differences of ∂Ω/∂t. Nothing here is derived a second time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq

from warp_rods.membranes.surfaces import Surface
from warp_rods.rods.bound.rods import BoundRods

PERTURBATION = 1e-4
"""Change of Ω per 1/length: the square of its effect and the round-off of ∂Ω/∂t, which is divided by it, balance."""
TRIES = 200
AT_REST = 1e-8
"""Largest change of Ω, per 1/length, in the last Newton step of an equilibrium."""
LARGEST_CHANGE = 0.3
"""Largest change of Ω, per 1/length, in one step of relaxing."""
FIRST_CHANGE = 1e-2
"""And about that of the first."""


@dataclass(frozen=True)
class Clamped:
    """A filament clamped at ``position`` [3] along ``direction`` [3] on ``surface``, its tip free, its length open.

    ``parameters``: stiffness, intrinsic, drag, each [3], of ``BoundRods``. A shape is Ω at all nodes but the last,
    where it is σ3: ``turn`` [nodes − 1] or a number, 1/length.
    """

    surface: Surface
    position: Any
    direction: Any
    nodes: int = 65
    parameters: dict[str, Any] = field(default_factory=dict)

    def filaments(self, length: float, turns: np.ndarray) -> BoundRods:
        """An ensemble on the CPU of this filament in every shape of ``turns`` [shape, nodes − 1]."""
        return BoundRods(
            self.surface,
            np.tile(self.position, (len(turns), 1)),
            np.tile(self.direction, (len(turns), 1)),
            nodes=self.nodes,
            length=length,
            at="start",
            ends=("clamped", "free"),
            geodesic_curvature=np.pad(turns, ((0, 0), (0, 1))),
            device="cpu",
            **self.parameters,
        )

    def rates(self, length: float, turns: np.ndarray) -> np.ndarray:
        """∂Ω/∂t (D.27) of shapes [shape, nodes − 1]; 1/length/time."""
        rods = self.filaments(length, turns)
        return rods.reading("geodesic_rate")[:, :-1]


def operator(filament: Clamped, length: float, turn: Any = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """∂Ω/∂t [nodes − 1] of a shape and its derivatives with respect to Ω [nodes − 1, nodes − 1]; 1/time."""
    size, step = filament.nodes - 1, PERTURBATION / length
    change = step * np.eye(size)
    rates = filament.rates(length, np.vstack([change, -change, np.zeros(size)]) + turn)
    return rates[-1], (rates[:size] - rates[size:-1]).T / (2 * step)


def equilibrium(filament: Clamped, length: float, turn: Any = 0.0) -> np.ndarray:
    """Shape at rest [nodes − 1] that a filament of shape ``turn`` relaxes to.

    By implicit Euler steps, each one Newton step long and longer than the last, until a whole Newton step for rest
    is no change. A start that is at rest stays, stable or not. Raises ArithmeticError where no rest is found.
    """
    shape = np.broadcast_to(np.asarray(turn, dtype=float), filament.nodes - 1)
    pace = None
    for _ in range(TRIES):
        rate, jacobian = operator(filament, length, shape)
        newton = np.linalg.solve(-jacobian, rate)
        if length * np.abs(newton).max() < AT_REST:
            return shape + newton
        pace = pace or FIRST_CHANGE / (length * np.abs(rate).max())
        change = np.linalg.solve(np.eye(len(shape)) / pace - jacobian, rate)
        size = length * np.abs(change).max()
        shape = shape + change * min(1.0, LARGEST_CHANGE / size)
        pace *= np.clip(0.5 * LARGEST_CHANGE / size, 0.5, 2.0)
    raise ArithmeticError(f"a filament of length {length:g} did not come to rest in {TRIES} steps")


def follow(filament: Clamped, lengths: Sequence[float], turn: Any = 0.0) -> np.ndarray:
    """Shapes at rest [length, nodes − 1] of a filament that grows, or is cut, slowly through ``lengths``.

    ``turn``: the shape from which it relaxes at the first. Each next one starts from the last at equal arc length,
    so that a shape that has lost stability, or is no more, gives way to the one that it falls to.
    """
    tip = filament.parameters.get("intrinsic", (0.0, 0.0, 0.0))[2]
    share = np.linspace(0.0, 1.0, filament.nodes)
    shapes = [equilibrium(filament, lengths[0], turn)]
    for before, length in pairwise(lengths):
        start = np.interp(length * share[:-1], before * share, np.append(shapes[-1], tip))
        shapes.append(equilibrium(filament, length, start))
    return np.array(shapes)


def growth_rate(filament: Clamped, length: float, turn: Any = 0.0) -> float:
    """Largest real part of the eigenvalues of a shape's operator; 1/time. Below zero: stable."""
    return float(np.linalg.eigvals(operator(filament, length, turn)[1]).real.max())


def critical_length(filament: Clamped, lengths: tuple[float, float], turn: Any = 0.0) -> float:
    """The length between two at which the rest state nearest to the shape ``turn`` (0: the geodesic) loses stability.

    Second order in Δs. Raises ValueError where both lengths are stable, or both are not.
    """

    def rate(length: float) -> float:
        return growth_rate(filament, length, equilibrium(filament, length, turn))

    ends = [rate(length) for length in lengths]
    if ends[0] * ends[1] > 0:
        said = "stable" if ends[0] < 0 else "unstable"
        raise ValueError(f"filaments of length {lengths[0]:g} and {lengths[1]:g} are both {said}")
    return float(brentq(rate, *lengths, xtol=1e-9 * lengths[1]))

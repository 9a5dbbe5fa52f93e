"""The semi-discrete equations of one free swimmer, on the unknowns that ends, plane and symmetry leave (model.md §2).

The equations are those of ``FreeRods.rates``, which the time stepper integrates, and their Jacobian is a batch of
perturbed rods: nothing is derived a second time. It is dense, as λ and ω0 tie all nodes together, but a few hundred
unknowns make that the quickest way as well as the plainest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy import linalg, sparse

from warp_rods.errors import SceneError
from warp_rods.rods.free.arrays import PARAMETERS
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import from_midpoint
from warp_rods.rods.per_rod import each_rod
from warp_rods.scene.swimmers import Swimmers

DEFAULTS = {
    "moment": 0.0, "drag_ratio": 2.0, "rotational_drag": 3e-3, "relaxation": 1e-2, "diffusion": 1e-3,
}  # fmt: skip
PARITIES = (-1, 1, 1, -1)
"""Of Re k, Im k, τ and f under s → −s in a shape with the π-rotation symmetry (C.49)."""
PERTURBATION = 1e-2
"""Of each unknown, for five-point differences: rates are cubic in all but for the tension's denominator."""
DIFFERENCES = {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12}
"""Weights of the fourth-order first difference."""
Nearby = Mapping[int, Mapping[str, float]]
"""Parameters at the places of ``DIFFERENCES`` about those of a state."""
BATCH = 512
"""Rods evaluated at a time, which bounds the memory."""
STRAIGHT = 1e-7
"""Norm of the unknown bendings below which a shape is straight, and has no phase."""


@dataclass(frozen=True)
class Swimmer:
    """One swimmer whose fixed shapes are sought: the numbers that ``FreeRods`` takes, dimensionless.

    parameters: bend β⊥ and twist β∥, and where not as in ``DEFAULTS`` moment M, drag_ratio η, rotational_drag ηr,
    relaxation τf, diffusion D. planar: bent in one plane and without twist, which needs M = 0. symmetric: with the
    π-rotation symmetry of C.49. held: f [node], for flagella that keep to it and are no unknowns. Raises SceneError
    for names unknown or missing, a moment in a plane, and what ``FreeRods`` refuses.
    """

    nodes: int
    parameters: Mapping[str, float]
    planar: bool = True
    symmetric: bool = False
    held: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        whole = DEFAULTS | {name: float(value) for name, value in self.parameters.items()}
        wrong, missing = whole.keys() - set(PARAMETERS), set(PARAMETERS) - whole.keys()
        if wrong or missing:
            raise SceneError(f"parameters: {', '.join(sorted(wrong | missing))}: needed are {', '.join(PARAMETERS)}")
        if self.planar and whole["moment"] != 0:
            raise SceneError(f"moment = {whole['moment']:g}: takes a swimmer out of its plane; use planar = False")
        object.__setattr__(self, "parameters", whole)

    @classmethod
    def of(cls, table: Swimmers, rod: int = 0, planar: bool | None = None) -> Swimmer:
        """Rod ``rod`` of a scene's table [[swimmers]]; planar by default where it has no moment."""
        of_flagella = ("relaxation", "diffusion")
        values = {
            name: each_rod(getattr(table.flagella if name in of_flagella else table, name), table.count)[rod]
            for name in PARAMETERS
        }
        flat = bool(values["moment"] == 0) if planar is None else planar
        return cls(table.nodes, values, planar=flat, symmetric=table.symmetric)

    def having(self, **parameters: float) -> Swimmer:
        """The same swimmer with other values of some parameters."""
        return replace(self, parameters={**self.parameters, **parameters})

    @property
    def law(self) -> str:
        """That of the flagella, of ``flagella.LAWS``."""
        return "relaxing" if self.held is None else "held"

    def rods(self, fields: np.ndarray, parameters: Mapping[str, Any], symmetric: bool = False) -> FreeRods:
        """An ensemble on the CPU with the Re k, Im k, τ, f of ``fields`` [rod, 4, node], Bishop frame."""
        given = dict(parameters)
        flagella = Flagella(given.pop("relaxation"), given.pop("diffusion"), fields[:, 3], law=self.law)
        material = (fields[:, 0] + 1j * fields[:, 1]) * np.exp(-1j * from_midpoint(fields[:, 2]))
        strain = np.stack([fields[:, 2], material.real, material.imag], axis=-1)
        return FreeRods(
            len(fields), self.nodes, **given, flagella=flagella, shape=strain, symmetric=symmetric, device="cpu"
        )


class Equations:
    """The rates of a swimmer on its unknowns: node values that the ends, plane and symmetry leave free [unknown]."""

    def __init__(self, swimmer: Swimmer):
        self.swimmer = swimmer
        self.basis, self.turn = _basis(swimmer.nodes, swimmer.planar, swimmer.symmetric, swimmer.held is not None)
        self.fixed = np.zeros((4, swimmer.nodes))
        if swimmer.held is not None:
            self.fixed[3] = swimmer.held

    def state(self, fields: np.ndarray) -> np.ndarray:
        """Unknowns [unknown] of fields [4, node]; what the swimmer does not allow is left out."""
        return self.basis.T @ fields.ravel()

    def fields(self, states: np.ndarray) -> np.ndarray:
        """Fields [state, 4, node] of unknowns [state, unknown]."""
        return (self.basis @ states.T).T.reshape(len(states), *self.fixed.shape) + self.fixed

    def rates(self, states: np.ndarray, parameters: Mapping[str, Any]) -> np.ndarray:
        """d/dt of states [state, unknown], each with its own parameters {name: number or [state]}."""
        whole = {name: np.broadcast_to(value, len(states)) for name, value in parameters.items()}
        found = np.empty_like(states)
        for start in range(0, len(states), BATCH):
            some = slice(start, start + BATCH)
            rates = self.swimmer.rods(self.fields(states[some]), {n: v[some] for n, v in whole.items()}).rates()
            k = rates["bending_rate"]
            change = np.stack([k.real, k.imag, rates["twist_rate"], rates["activity_rate"]], axis=1)
            found[some] = change.reshape(len(k), -1) @ self.basis
        return found

    def linear(
        self, state: np.ndarray, parameters: Mapping[str, float], nearby: Nearby | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rates [unknown], their Jacobian [unknown, unknown], and their difference over ``nearby`` parameters.

        nearby: {place: parameters} for the places of ``DIFFERENCES``; the difference is per place.
        """
        size = len(state)
        states = np.tile(state, (4 * (size + 1) + 1, 1))
        whole = {name: np.full(len(states), value) for name, value in parameters.items()}
        for block, place in enumerate(DIFFERENCES):
            rows = block * (size + 1) + np.arange(size)
            states[rows, np.arange(size)] += place * PERTURBATION
            for name, value in (nearby or {}).get(place, {}).items():
                whole[name][block * (size + 1) + size] = value
        rates = self.rates(states, whole)
        slopes = np.tensordot(list(DIFFERENCES.values()), rates[:-1].reshape(4, size + 1, size), axes=1)
        return rates[-1], slopes[:-1].T / PERTURBATION, slopes[-1]

    def turns(self, state: np.ndarray) -> bool:
        """Whether a shape can turn about its tangent: one in space, bent, whose phase no symmetry fixes."""
        return self.turn.nnz > 0 and float(np.linalg.norm(self.turn @ state)) > STRAIGHT

    def spin(self, state: np.ndarray) -> float:
        """Rate Ω at which a shape turns about its tangent: that of the best fit of iΩk to dk/dt."""
        turned = self.turn @ state
        if not self.turns(state):
            return 0.0
        return float(turned @ self.rates(state[None], self.swimmer.parameters)[0] / (turned @ turned))

    def system(
        self, state: np.ndarray, spin: float, parameters: Mapping[str, float], nearby: Nearby | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What vanishes at a fixed shape [unknown + 1], and the Jacobian of the rates alone.

        In the middle its derivatives by the state, Ω and the place of ``nearby`` [unknown + 1, unknown + 2]. The last
        row fixes the phase of k, as there is no change along ik; or Ω = 0, where a shape cannot turn.
        """
        rate, jacobian, slope = self.linear(state, parameters, nearby)
        turned = self.turn @ state
        last = np.append(turned, [0.0, 0.0]) if self.turns(state) else np.append(0.0 * state, [1.0, 0.0])
        rows = np.column_stack([jacobian - spin * self.turn.toarray(), -turned, slope])
        return np.append(rate - spin * turned, 0.0), np.vstack([rows, last]), jacobian

    def spectrum(self, jacobian: np.ndarray, state: np.ndarray, spin: float) -> np.ndarray:
        """Eigenvalues, largest real part first, of the Jacobian seen from a frame that turns with the shape."""
        if self.turns(state):
            # J v = 0 for v = ik, so the other eigenvalues are those of J on the directions normal to it.
            others = linalg.null_space((self.turn @ state)[None])
            jacobian = others.T @ (jacobian - spin * self.turn.toarray()) @ others
        values = linalg.eigvals(jacobian)
        return values[np.lexsort((-values.imag, -values.real))]


@lru_cache(maxsize=16)
def _basis(nodes: int, planar: bool, symmetric: bool, held: bool) -> tuple[Any, Any]:
    """Orthonormal columns [4 nodes, unknown] that span the fields allowed, and k → ik on the unknowns."""
    free = (not planar, True, not planar, not held)
    blocks = []
    for allowed, parity, ends in zip(free, PARITIES, (False, False, False, True), strict=True):
        columns = np.eye(nodes)[:, slice(None) if ends else slice(1, -1)]
        if symmetric:
            columns = (columns + parity * columns[::-1])[:, : (columns.shape[1] + 1) // 2]
            columns = columns[:, np.any(columns != 0, axis=0)]
            columns = columns / np.linalg.norm(columns, axis=0)
        blocks.append(columns if allowed else np.empty((nodes, 0)))
    basis = sparse.csr_array(linalg.block_diag(*blocks))
    quarter = np.zeros((4, 4))
    if not planar and not symmetric:
        quarter[0, 1], quarter[1, 0] = -1, 1
    turn = sparse.csr_array(basis.T @ sparse.kron(quarter, sparse.eye(nodes)) @ basis)
    turn.eliminate_zeros()
    return basis, turn


def solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """x of ``matrix x = right``; raises ArithmeticError where the matrix is singular."""
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        raise ArithmeticError("the equations are singular here: no fixed shape stands alone") from None

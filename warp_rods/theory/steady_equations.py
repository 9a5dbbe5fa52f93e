"""The semi-discrete equations of one free swimmer in its independent unknowns (docs/model.md §2.3).

Independent are the node values that end conditions, planarity and symmetry do not fix. The rates are those of
``FreeRods.rates``, which the time stepper integrates. The Jacobian comes from a batch of perturbed rods, so that no
equation is derived a second time. It is dense, as λ and ω0 couple all nodes; for a few hundred unknowns a dense solve
is also the fastest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from scipy import linalg, sparse

from warp_rods import arguments
from warp_rods.documented import Documented
from warp_rods.errors import SceneError
from warp_rods.rods.free.arrays import PARAMETERS
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import from_midpoint
from warp_rods.rods.per_rod import each_rod
from warp_rods.scene.flagella import DEFAULT_LAW
from warp_rods.scene.swimmers import SwimmersTable

DEFAULTS = {
    "moment": 0.0, "drag_ratio": 2.0, "rotational_drag": 3e-3, "relaxation": 1e-2, "diffusion": 1e-3,
}  # fmt: skip
PARITIES = (-1, 1, 1, -1)
"""Parities of Re k, Im k, τ and f under s → −s in a shape with the π-rotation symmetry (C.49)."""
PERTURBATION = 1e-2
"""Change of each unknown in five-point differences. The rates are cubic except for the denominator of the tension."""
DIFFERENCES = {-2: 1 / 12, -1: -8 / 12, 1: 8 / 12, 2: -1 / 12}
"""Offsets and weights of the fourth-order first difference."""
KNOWN_LAWS = ("relaxing", "held")
"""Laws whose fixed shapes can be sought."""
NearbyParameters = Mapping[int, Mapping[str, float]]
"""Changed parameters at each offset of ``DIFFERENCES``."""
BATCH = 512
"""Rods evaluated at a time; limits the memory."""
STRAIGHT = 1e-7
"""Norm of the bending below which a shape counts as straight, and its phase is undefined."""


def _check_plain(table: SwimmersTable) -> None:
    """Raises SceneError for swimmers that are not uniform, straight at rest, free at their ends, and left alone."""
    along = [name for name in ("bend", "twist", "drag_ratio", "rotational_drag") if _changes(getattr(table, name))]
    others = ("drag_along", "natural_bend", "natural_twist", "ends", "couple", "behaviour")
    along += [name for name in others if getattr(table, name) is not None]
    if along:
        raise _not_plain(along[0])


def _not_plain(name: str) -> SceneError:
    return SceneError(
        f"{name}: fixed shapes are found for uniform swimmers that are straight at rest and free at both ends, without "
        f"couple and behaviour; run the scene instead"
    )


def _check_law(law: str) -> None:
    """Raises SceneError for a law whose fixed shapes cannot be sought."""
    if law not in KNOWN_LAWS:
        raise SceneError(f'flagella.law = "{law}": fixed shapes are found for the laws {", ".join(KNOWN_LAWS)} only')


def _changes(value: Any) -> bool:
    """Whether a value of a table may change along rods."""
    parts = value if isinstance(value, tuple) else (value,)
    return not all(isinstance(part, (int, float)) for part in parts)


@dataclass(frozen=True)
class Swimmer(metaclass=Documented):
    """One swimmer whose fixed shapes are sought, with the dimensionless parameters of ``FreeRods``.

    parameters: bend β⊥ and twist β∥; optional, with ``DEFAULTS``, are moment M, drag_ratio η, rotational_drag ηr,
    relaxation τf and diffusion D. planar: bent in one plane and without twist, which needs M = 0. symmetric: with the
    π-rotation symmetry (C.49). held: f [node] of flagella that stay fixed and are not among the unknowns. Raises
    SceneError for an unknown or missing parameter, for another law of flagella, and for a planar swimmer with a moment.
    """

    _unlisted = frozenset({"rods", "law"})

    nodes: int
    parameters: Mapping[str, float]
    planar: bool = True
    symmetric: bool = False
    held: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        # ``FreeRods.parameters`` also lists how the flagella begin and whether symmetry is imposed.
        given = {name: value for name, value in self.parameters.items() if name not in ("flagella", "symmetric")}
        if given.pop("drag_along", 1.0) != 1.0:
            raise SceneError(f"drag_along = {self.parameters['drag_along']}: must be 1 here: ζ∥ is the unit of drag")
        flagella = self.parameters.get("flagella")
        law = flagella.get("law", DEFAULT_LAW) if isinstance(flagella, Mapping) else DEFAULT_LAW
        _check_law(law)
        if law == "held" and self.held is None:
            raise SceneError('flagella.law = "held": needs held, f [node], such as held=tuple(rods.activity[0])')
        if not_plain := [name for name, value in given.items() if np.ndim(value) or isinstance(value, Mapping)]:
            raise _not_plain(not_plain[0])
        whole = DEFAULTS | {name: arguments.real(name, value, arguments.ANY) for name, value in given.items()}
        wrong, missing = whole.keys() - set(PARAMETERS), set(PARAMETERS) - whole.keys()
        if wrong or missing:
            faulty = ", ".join(sorted(wrong | missing))
            raise SceneError(f"parameters: {faulty} unknown or missing; needed are {', '.join(PARAMETERS)}")
        if self.planar and whole["moment"] != 0:
            raise SceneError(f"moment = {whole['moment']:g}: must be 0 for a planar swimmer; or use planar = False")
        object.__setattr__(self, "parameters", whole)

    @classmethod
    def of(cls, table: SwimmersTable, rod: int = 0, planar: bool | None = None) -> Swimmer:
        """Rod ``rod`` of a table [[swimmers]] of a scene; planar by default where its moment is 0.

        With the law ``held`` its flagella keep their profile. Raises SceneError for another law than these two,
        and for nodes = "auto".
        """
        _check_plain(table)
        law = table.flagella.law or DEFAULT_LAW
        _check_law(law)
        of_flagella = ("relaxation", "diffusion")
        values = {
            name: each_rod(getattr(table.flagella if name in of_flagella else table, name), table.count)[rod]
            for name in PARAMETERS
        }
        flat = bool(values["moment"] == 0) if planar is None else planar
        held = None
        if law == "held":
            s = np.linspace(-0.5, 0.5, table.node_count)
            held = tuple(Flagella.read(table.flagella.model_dump()).start(s, table.count)[rod].tolist())
        return cls(table.node_count, values, planar=flat, symmetric=table.symmetric, held=held)

    def with_parameters(self, **parameters: float) -> Swimmer:
        """The same swimmer with other values of some parameters."""
        return replace(self, parameters={**self.parameters, **parameters})

    @property
    def law(self) -> str:
        """The activity law of its flagella: a key of ``LAWS`` in ``scene/flagella.py``."""
        return "relaxing" if self.held is None else "held"

    def rods(self, fields: np.ndarray, parameters: Mapping[str, Any], symmetric: bool = False) -> FreeRods:
        """An ensemble on the CPU with Re k, Im k, τ, f from ``fields`` [rod, 4, node], in the Bishop frame."""
        given = dict(parameters)
        flagella = Flagella(given.pop("relaxation"), given.pop("diffusion"), fields[:, 3], law=self.law)
        material = (fields[:, 0] + 1j * fields[:, 1]) * np.exp(-1j * from_midpoint(fields[:, 2]))
        strain = np.stack([fields[:, 2], material.real, material.imag], axis=-1)
        return FreeRods(
            len(fields), self.nodes, **given, flagella=flagella, shape=strain, symmetric=symmetric, device="cpu"
        )


class Equations:
    """The rates of a swimmer as functions of its independent unknowns [unknown].

    ``rotation``: the sparse matrix that maps the unknowns of k to those of ik.
    """

    def __init__(self, swimmer: Swimmer):
        self.swimmer = swimmer
        self.basis, self.rotation = _basis(swimmer.nodes, swimmer.planar, swimmer.symmetric, swimmer.held is not None)
        self.fixed = np.zeros((4, swimmer.nodes))
        if swimmer.held is not None:
            self.fixed[3] = swimmer.held

    def state(self, fields: np.ndarray) -> np.ndarray:
        """Unknowns [unknown] of fields [4, node]; components that the swimmer does not allow are dropped."""
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

    def linearise(
        self, state: np.ndarray, parameters: Mapping[str, float], nearby: NearbyParameters | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rates [unknown], their Jacobian [unknown, unknown], and their derivative along ``nearby`` parameters.

        nearby: {offset: parameters} for the offsets of ``DIFFERENCES``; the derivative is per unit of offset.
        """
        size = len(state)
        states = np.tile(state, (4 * (size + 1) + 1, 1))
        whole = {name: np.full(len(states), value) for name, value in parameters.items()}
        for block, offset in enumerate(DIFFERENCES):
            rows = block * (size + 1) + np.arange(size)
            states[rows, np.arange(size)] += offset * PERTURBATION
            for name, value in (nearby or {}).get(offset, {}).items():
                whole[name][block * (size + 1) + size] = value
        rates = self.rates(states, whole)
        slopes = np.tensordot(list(DIFFERENCES.values()), rates[:-1].reshape(4, size + 1, size), axes=1)
        return rates[-1], slopes[:-1].T / PERTURBATION, slopes[-1]

    def can_rotate(self, state: np.ndarray) -> bool:
        """Whether a shape can rotate about its tangent: it is bent, neither planar nor symmetric."""
        return self.rotation.nnz > 0 and float(np.linalg.norm(self.rotation @ state)) > STRAIGHT

    def spin(self, state: np.ndarray) -> float:
        """Rate Ω at which a shape rotates about its tangent: the least-squares fit of iΩk to dk/dt."""
        turned = self.rotation @ state
        if not self.can_rotate(state):
            return 0.0
        return float(turned @ self.rates(state[None], self.swimmer.parameters)[0] / (turned @ turned))

    def system(
        self, state: np.ndarray, spin: float, parameters: Mapping[str, float], nearby: NearbyParameters | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Residual [unknown + 1] that is zero at a fixed shape, its derivatives, and the Jacobian of the rates alone.

        The derivatives [unknown + 1, unknown + 2] are with respect to the state, Ω and the offset of ``nearby``. The
        last row fixes the phase of k, by no change along ik; where a shape cannot rotate, it sets Ω = 0.
        """
        rate, jacobian, slope = self.linearise(state, parameters, nearby)
        turned = self.rotation @ state
        last = np.append(turned, [0.0, 0.0]) if self.can_rotate(state) else np.append(0.0 * state, [1.0, 0.0])
        rows = np.column_stack([jacobian - spin * self.rotation.toarray(), -turned, slope])
        return np.append(rate - spin * turned, 0.0), np.vstack([rows, last]), jacobian

    def spectrum(self, jacobian: np.ndarray, state: np.ndarray, spin: float) -> np.ndarray:
        """Eigenvalues of the Jacobian in the frame that rotates with the shape, largest real part first."""
        if self.can_rotate(state):
            # J v = 0 for v = ik: the other eigenvalues are those of J on the directions normal to v.
            others = linalg.null_space((self.rotation @ state)[None])
            jacobian = others.T @ (jacobian - spin * self.rotation.toarray()) @ others
        values = linalg.eigvals(jacobian)
        return values[np.lexsort((-values.imag, -values.real))]


@lru_cache(maxsize=16)
def _basis(nodes: int, planar: bool, symmetric: bool, held: bool) -> tuple[Any, Any]:
    """Orthonormal columns [4 nodes, unknown] that span the allowed fields; and the map k → ik of the unknowns."""
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
    quarter_turn = np.zeros((4, 4))
    if not planar and not symmetric:
        quarter_turn[0, 1], quarter_turn[1, 0] = -1, 1
    rotation = sparse.csr_array(basis.T @ sparse.kron(quarter_turn, sparse.eye(nodes)) @ basis)
    rotation.eliminate_zeros()
    return basis, rotation


def solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The solution x of ``matrix x = right``; raises ArithmeticError where the matrix is singular."""
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        raise ArithmeticError("the equations are singular: fixed shapes here are not isolated") from None

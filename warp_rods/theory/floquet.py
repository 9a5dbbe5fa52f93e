"""Growth of perturbations without the symmetry under rotation by π (C.4) about periodic motions that have it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import linalg

from warp_rods.errors import SceneError
from warp_rods.theory.steady_equations import PARITIES, Equations, Swimmer

__all__ = ["asymmetric_exponents", "asymmetric_part"]

CHANGE = 1e-3
"""Change of the shape in differences, 1/L."""


def asymmetric_part(fields: np.ndarray) -> np.ndarray:
    """The part of fields Re k, Im k, τ, f [..., 4, node] that the symmetry (C.49) forbids."""
    return (fields - np.array(PARITIES)[:, None] * fields[..., ::-1]) / 2


def asymmetric_exponents(swimmer: Swimmer, cycle: np.ndarray, period: float, count: int = 4) -> np.ndarray:
    """Leading ``count`` complex Floquet exponents of perturbations without the symmetry, largest real part first.

    cycle: Re k, Im k, τ, f [frame, 4, node] of a symmetric motion, in the middles of equal parts of its ``period``. The
    equations linearised there are solved exactly in each part: second order in the parts. Imaginary parts are known up
    to multiples of 2π/period. Raises SceneError where the cycle lacks the symmetry.
    """
    size = abs(cycle).max(axis=(0, 2), keepdims=True)
    if (abs(asymmetric_part(cycle)) > 1e-6 * np.maximum(size, 1e-300)).any():
        raise SceneError("cycle: must have the symmetry (C.49): k(−s) = −k̄(s), τ even and f odd, at all frames")
    equations = Equations(replace(swimmer, planar=False, symmetric=False))
    forbidden = _asymmetric_directions(equations)
    growth = np.eye(forbidden.shape[1])
    for fields in cycle:
        growth = linalg.expm(period / len(cycle) * _slopes(equations, fields, forbidden)) @ growth
    exponents = np.log(linalg.eigvals(growth).astype(complex)) / period
    return exponents[np.lexsort((-exponents.imag, -exponents.real))][:count]


def _slopes(equations: Equations, fields: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The Jacobian among ``directions`` [unknown, direction], by central differences: the rates are nearly cubic."""
    state, moved = equations.state(fields), CHANGE * directions.T
    rates = equations.rates(np.concatenate([state + moved, state - moved]), equations.swimmer.parameters)
    ahead, behind = np.split(rates, 2)
    return directions.T @ (ahead - behind).T / (2 * CHANGE)


def _asymmetric_directions(equations: Equations) -> np.ndarray:
    """Orthonormal columns [unknown, direction] that span the perturbations without the symmetry."""
    size = equations.basis.shape[1]
    fields = (equations.basis @ np.eye(size)).T.reshape(size, 4, -1)
    return linalg.orth(equations.basis.T @ asymmetric_part(fields).reshape(size, -1).T, rcond=1e-6)

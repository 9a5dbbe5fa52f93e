"""Checks of the parameters of free rods, before anything is allocated."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.rods.along import Along
from warp_rods.rods.per_rod import parameter

FEWEST_NODES = 17
RULES = {"moment": "any finite number", "diffusion": "zero or more"}
"""Conditions on the parameters that need not be positive."""
SYMMETRIC = 1e-9
"""Larger relative errors of the parities at the start are not regarded as round-off."""


def check_nodes(count: Any, nodes: Any) -> tuple[int, int]:
    """Both as int; raises SceneError for fewer than 1 rod, an even number of nodes, or too few nodes."""
    count, nodes = arguments.whole("count", count), arguments.whole("nodes", nodes)
    if nodes < FEWEST_NODES or nodes % 2 == 0:
        raise SceneError(f"nodes = {nodes}: must be an odd whole number, {FEWEST_NODES} or more")
    return count, nodes


def parameters_of(given: Mapping[str, Any], count: int, prefix: str = "") -> dict[str, np.ndarray]:
    """Each parameter [rod]; raises SceneError naming a parameter, after ``prefix``, with an impossible value."""
    return {name: parameter(prefix + name, value, count, RULES.get(name, "positive")) for name, value in given.items()}


def along_rods(
    given: Mapping[str, Any], count: int, nodes: int, named: Mapping[str, np.ndarray] | None = None
) -> dict[str, np.ndarray]:
    """Each parameter [rod], or [rod, node] where it changes along the rods; raises SceneError."""
    return {name: Along(name, value, count, nodes, "positive", named=named).values for name, value in given.items()}


def symmetric_starts(bending: np.ndarray, twist: np.ndarray, activity: np.ndarray) -> np.ndarray:
    """Which active rods [rod] start with a symmetry under rotation by π (C.49), about any axis, up to round-off.

    k(−s) = −e^{iφ} k̄(s), τ even, f odd: about an axis across the rod at its middle, at the angle φ/2. Includes even and
    odd planar shapes and straight rods.
    """
    k, mirror = bending, bending[:, ::-1]
    overlap = -np.sum(k * mirror, axis=1, keepdims=True)
    phase = overlap / np.maximum(np.abs(overlap), np.finfo(float).tiny)

    def small(residual: np.ndarray, of: np.ndarray) -> np.ndarray:
        return np.abs(residual).max(axis=1) <= SYMMETRIC * np.abs(of).max(axis=1)

    parities = small(mirror + phase * k.conj(), k) & small(twist[:, ::-1] - twist, twist)
    return parities & small(activity[:, ::-1] + activity, activity) & activity.any(axis=1)


def check_symmetry(bending: np.ndarray, twist: np.ndarray, activity: np.ndarray) -> None:
    """Raises SceneError if the shape at the start lacks the parities of (C.49): k(−s) = −k̄(s), τ even, f odd."""
    residuals = {
        "shape": np.abs(bending[:, ::-1] + bending.conj()).max() / max(np.abs(bending).max(), 1e-300),
        "shape (twist)": np.abs(twist[:, ::-1] - twist).max() / max(np.abs(twist).max(), 1e-300),
        "flagella": np.abs(activity[:, ::-1] + activity).max(),
    }
    for name, residual in residuals.items():
        if residual > SYMMETRIC:
            raise SceneError(
                f"symmetric = true: the {name} at the start lacks the symmetry (C.49); even modes have it, and bending "
                f'with odd bend1 and even bend2, such as bend1 = "15*sin(2*pi*s)"'
            )

"""Parameters of an ensemble: one value for all rods, or one for each."""

from __future__ import annotations

from typing import Any, SupportsFloat, SupportsIndex

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.formula import FormulaError, function_of_arc_length

ORTHONORMAL = 1e-6
"""Larger errors of RᵀR are not regarded as round-off."""


def each_rod(values: Any, count: int, size: int = 1) -> np.ndarray:
    """One value for each rod, [count] or [count, size], from one value for all rods or one for each.

    Raises ValueError if the values have another shape.
    """
    given = np.asarray(values, dtype=np.float64)
    one = () if size == 1 else (size,)
    if given.shape not in (one, (count, *one)):
        raise ValueError(f"values of shape {given.shape} do not fit {count} rods: give {one} or {(count, *one)}")
    return np.broadcast_to(given, (count, *one)).copy()


def each_node(values: Any, count: int, nodes: int) -> np.ndarray:
    """One value for each node [count, nodes], from a number, or from a number or a row of node values for each rod.

    Raises ValueError if the values have another shape.
    """
    rows = [values] * count if np.isscalar(values) else list(values)
    if len(rows) != count:
        raise ValueError(f"{len(rows)} rows do not fit {count} rods")
    return np.stack([np.broadcast_to(np.asarray(row, dtype=np.float64), (nodes,)) for row in rows])


def along(name: str, value: Any, s: np.ndarray) -> np.ndarray:
    """Values [node] of a formula of s at arc lengths s [node], −1/2 to 1/2, or of a number; raises SceneError."""
    if not isinstance(value, str):
        return np.full(len(s), arguments.real(name, value, arguments.ANY))
    try:
        function = function_of_arc_length(value)
    except FormulaError as error:
        raise SceneError(f"{name} = {value!r}: {error}") from None
    values = np.empty(len(s))
    for node, at in enumerate(s):
        try:
            values[node] = function(at)
        except FormulaError as error:
            raise SceneError(f"{name} = {value!r}: at s = {at:.4g}, {error}") from None
    return values


def parameter(name: str, values: Any, count: int, rules: str | tuple[str, ...] = "positive") -> np.ndarray:
    """A parameter as one value for each rod [count], or with one rule for each component [count, component].

    Raises SceneError naming the parameter, the value and what is allowed.
    """
    size = 1 if isinstance(rules, str) else len(rules)
    try:
        read = each_rod(arguments.reals(name, values), count, size)
    except SceneError:
        raise
    except ValueError as error:
        raise SceneError(f"{name}: {error}") from None
    columns = [(rules, read)] if isinstance(rules, str) else [(rule, read[:, i]) for i, rule in enumerate(rules)]
    for rule, column in columns:
        arguments.check(name, column, rule)
    return read


def vectors(values: Any, count: int, nodes: int, finite: bool = True) -> np.ndarray:
    """A force [count, nodes, 3] from one vector for all nodes or from values of that shape; raises SceneError."""
    given = arguments.reals("force", values)
    if given.shape not in ((3,), (count, nodes, 3)):
        raise SceneError(f"force: must be one vector, or {(count, nodes, 3)} [rod, node, 3]; has shape {given.shape}")
    if finite:
        arguments.check("force", given, "any finite number")
    return np.ascontiguousarray(np.broadcast_to(given, (count, nodes, 3)))


def frames(rotation: Any, count: int) -> np.ndarray:
    """Right-handed orthonormal frames [rod, 3, 3] from one for all rods or one for each; raises SceneError."""
    R = arguments.reals("rotation", rotation)
    if R.shape not in ((3, 3), (count, 3, 3)):
        raise SceneError(f"rotation: must be a matrix [3, 3], or {(count, 3, 3)} [rod, 3, 3]; has shape {R.shape}")
    R = np.ascontiguousarray(np.broadcast_to(R, (count, 3, 3)))
    error_size = np.abs(np.swapaxes(R, 1, 2) @ R - np.eye(3)).max(axis=(1, 2))
    wrong = np.flatnonzero(~((error_size < ORTHONORMAL) & (np.linalg.det(np.nan_to_num(R)) > 0)))
    if len(wrong):
        raise SceneError(
            f"rotation[{wrong[0]}] = {R[wrong[0]].tolist()}: must be a rotation, with orthonormal columns (tangent "
            f"first) that form a right-handed frame"
        )
    return R


def check_step(dt: SupportsFloat, steps: SupportsIndex = 1) -> tuple[float, int]:
    """A step and a number of steps; raises SceneError unless the step is positive and the number 0 or more."""
    return arguments.real("dt", dt), arguments.whole("steps", steps, 0)

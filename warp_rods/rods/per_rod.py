"""Parameters of an ensemble: one value for all rods, or one for each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, SupportsFloat, SupportsIndex

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.formula import FormulaError, function_of_arc_length, usable_name, with_numbers
from warp_rods.scene.parameters import VARIABLES

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


def named_numbers(given: Any, count: int) -> dict[str, np.ndarray]:
    """Parameters of formulas [rod] by name, from numbers or lists with one for each rod; raises SceneError."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise arguments.wrong("parameters", given, "numbers by name, such as {'k': 7.0}, or None")
    for name in given:
        if not isinstance(name, str) or not usable_name(name) or name in VARIABLES:
            raise SceneError(f"parameters: {name!r} has a meaning in formulas, or is no name: use another one")
    return {name: parameter(f"parameters.{name}", value, count, arguments.ANY) for name, value in given.items()}


def along(name: str, value: Any, s: np.ndarray, named: Mapping[str, np.ndarray] | None = None) -> np.ndarray:
    """Values [node] of a formula of s at arc lengths s [node], −1/2 to 1/2, or of a number; raises SceneError.

    named: parameters of the formula [rod]; the values are then [rod, node] where one of them occurs.
    """
    if not isinstance(value, str):
        return np.full(len(s), arguments.real(name, value, arguments.ANY))
    try:
        function = function_of_arc_length(value, tuple(named or ()))
    except FormulaError as error:
        raise SceneError(f"{name} = {value!r}: {error}") from None
    own = {key: numbers for key, numbers in (named or {}).items() if key in function.names}  # type: ignore[attr-defined]
    rows = [dict(zip(own, numbers, strict=True)) for numbers in zip(*own.values(), strict=True)] if own else [{}]
    values = np.empty((len(rows), len(s)))
    for (rod, node), _ in np.ndenumerate(values):
        try:
            values[rod, node] = function(s[node], **{key: float(number) for key, number in rows[rod].items()})
        except FormulaError as error:
            raise SceneError(f"{name} = {value!r}: at s = {s[node]:.4g}, {error}") from None
    return values if own else values[0]


def with_named(value: Any, named: Mapping[str, np.ndarray]) -> list[Any]:
    """A value with numbers in place of the parameters [rod] in its formulas: once, or for each rod where they differ.

    value: any lists of numbers and formulas.
    """
    alike = all((numbers == numbers[0]).all() for numbers in named.values())
    count = 1 if alike else len(next(iter(named.values())))

    def put_in(part: Any, rod: int) -> Any:
        if isinstance(part, (list, tuple)):
            return type(part)(put_in(inner, rod) for inner in part)
        if not isinstance(part, str):
            return part
        try:
            return with_numbers(part, {name: float(numbers[rod]) for name, numbers in named.items()})
        except FormulaError:
            return part  # its fault is named where it is read

    return [put_in(value, rod) for rod in range(count)]


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

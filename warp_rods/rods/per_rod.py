"""Parameters of an ensemble: one value for all rods, or one for each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from warp_rods.errors import SceneError


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


RULES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "any finite number": np.isfinite,
    "positive": lambda values: np.isfinite(values) & (values > 0),
    "zero or more": lambda values: np.isfinite(values) & (values >= 0),
}
"""Conditions on the values of a parameter."""


def parameter(name: str, values: Any, count: int, rules: str | tuple[str, ...] = "positive") -> np.ndarray:
    """A parameter as one value for each rod [count], or with one rule for each component [count, component].

    Raises SceneError naming the parameter, the value and what is allowed.
    """
    size = 1 if isinstance(rules, str) else len(rules)
    try:
        read = each_rod(values, count, size)
    except (ValueError, TypeError) as error:
        raise SceneError(f"{name}: {error}") from None
    columns = [(rules, read)] if isinstance(rules, str) else [(rule, read[:, i]) for i, rule in enumerate(rules)]
    for rule, column in columns:
        if len(wrong := column[~RULES[rule](column)]):
            raise SceneError(f"{name} = {wrong[0]:g}: must be {rule}")
    return read


def vectors(values: Any, count: int, nodes: int) -> np.ndarray:
    """A force [count, nodes, 3] from one vector for all nodes or from values of that shape; raises SceneError."""
    given = np.asarray(values, dtype=np.float64)
    if given.shape not in ((3,), (count, nodes, 3)):
        raise SceneError(f"force: must be one vector, or {(count, nodes, 3)} [rod, node, 3]; has shape {given.shape}")
    return np.ascontiguousarray(np.broadcast_to(given, (count, nodes, 3)))


def count_of(name: str, value: Any) -> int:
    """A whole number, 1 or more; raises SceneError naming it."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)) or value < 1:
        raise SceneError(f"{name} = {value!r}: must be a whole number, 1 or more")
    return int(value)


def check_step(dt: float, steps: int) -> None:
    """Raises SceneError for a step that is not positive and finite, or a negative number of steps."""
    if not 0 < dt < np.inf:
        raise SceneError(f"dt = {dt}: must be positive")
    if steps < 0:
        raise SceneError(f"steps = {steps}: must be 0 or more")


DOUBLINGS = 10
"""How often a step doubles at the start of equal steps."""


def ramp(dt: float) -> list[float]:
    """The first of equal steps, divided into steps that begin with dt/1024 twice and then double; their sum is dt.

    A rod whose start contradicts its ends, or is rough, changes fast at first. One first step of first order would then
    spoil the second order of all that follow.
    """
    shortest = dt / 2**DOUBLINGS
    return [shortest, *(shortest * 2**k for k in range(DOUBLINGS))]

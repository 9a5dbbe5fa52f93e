"""Surfaces that move: formulas in t among their values, such as ``neck = "0.4 - 0.1*t"``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warp_rods import formula
from warp_rods.errors import SceneError
from warp_rods.formula import FormulaError
from warp_rods.membranes.level_set import Fault
from warp_rods.values import key_path

__all__ = ["NOT_NUMBERS", "MotionError", "is_moving", "values_at"]

NOT_NUMBERS = ("kind", "phi", "file", "axes")
"""Keys of a [surface] whose text is not a formula in t."""


class MotionError(SceneError):
    """A formula in t that has no value at some time; ``fault`` names the formula and the time."""

    def __init__(self, fault: Fault):
        super().__init__(key_path(("surface", *fault[0])) + fault[1])
        self.fault = fault


def is_moving(values: Mapping[str, Any]) -> bool:
    """Whether the values of a surface, including its lists and tables, contain a formula in t."""
    return any(_has_text(value) for key, value in values.items() if key not in NOT_NUMBERS)


def values_at(values: Mapping[str, Any], time: float) -> dict[str, Any]:
    """The values with formulas in t evaluated at this time; raises MotionError where one has no value."""
    return {key: value if key in NOT_NUMBERS else _at((key,), value, time) for key, value in values.items()}


def _has_text(value: Any) -> bool:
    if isinstance(value, Mapping):
        return any(map(_has_text, value.values()))
    if isinstance(value, tuple):
        return any(map(_has_text, value))
    return isinstance(value, str)


def _at(loc: tuple[str | int, ...], value: Any, time: float) -> Any:
    if isinstance(value, Mapping):
        return {name: _at((*loc, name), inner, time) for name, inner in value.items()}
    if isinstance(value, tuple):
        return tuple(_at((*loc, i), inner, time) for i, inner in enumerate(value))
    if not isinstance(value, str):
        return value
    try:
        return formula.function_of_time(value)(time)
    except FormulaError as error:
        raise MotionError((loc, f" at t = {time:g}: {error}")) from None

"""Numbers of a membrane that change: texts in t among its values, such as ``neck = "0.4 - 0.1*t"``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warp_rods import formula
from warp_rods.errors import SceneError

NOT_NUMBERS = ("kind", "phi", "file")
"""Keys of a [surface] whose text is no formula in t."""


def moving(values: Mapping[str, Any]) -> bool:
    """Whether a text in t is among these values of a surface, in its lists and tables too."""
    return any(_has_text(value) for key, value in values.items() if key not in NOT_NUMBERS)


def at(values: Mapping[str, Any], time: float) -> dict[str, Any]:
    """The values with each text in t as its number at a time; raises SceneError where one has none then."""
    return {key: value if key in NOT_NUMBERS else _at(key, value, time) for key, value in values.items()}


def fault(text: str) -> str | None:
    """What is wrong with a text in t, or that it has no value at t = 0; None where it is fine."""
    try:
        formula.in_time(text)(0.0)
    except formula.FormulaError as error:
        return str(error)
    return None


def _has_text(value: Any) -> bool:
    if isinstance(value, Mapping):
        return any(map(_has_text, value.values()))
    if isinstance(value, (list, tuple)):
        return any(map(_has_text, value))
    return isinstance(value, str)


def _at(key: str, value: Any, time: float) -> Any:
    if isinstance(value, Mapping):
        return {name: _at(f"{key}.{name}", inner, time) for name, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(_at(f"{key}[{i}]", inner, time) for i, inner in enumerate(value))
    if not isinstance(value, str):
        return value
    try:
        return formula.in_time(value)(time)
    except formula.FormulaError as error:
        raise SceneError(f"surface.{key} at t = {time:g}: {error}") from None

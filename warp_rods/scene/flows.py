"""Background flows: the table of their kinds, and the table [flow] of a scene.

To add a kind: a row of ``FLOWS`` with its keys and a function of their values, which returns a ``Profile``, a flow of
second degree in the place, or three formulas in x, y, z and t.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydantic import ConfigDict, Field

from warp_rods.formula import FormulaError, function_of_arrays, syntax_tree, with_numbers
from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.parameters import Parameters, known_names, known_numbers, use
from warp_rods.values import Positive, must_be, nearest, number, numbers, shown

__all__ = ["FLOWS", "FlowKey", "FlowKind", "FlowTable", "Profile", "formula_fault"]

PERPENDICULAR = 1e-9
"""A larger cosine of the angle between two directions is not regarded as round-off."""


@dataclass(frozen=True)
class Profile:
    """u = velocity + gradient y + axis (1 − y·form y), with y = x − centre."""

    velocity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    gradient: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))
    axis: np.ndarray = field(default_factory=lambda: np.zeros(3))
    form: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass(frozen=True)
class FlowKey:
    """A key of a flow: what it means and what is allowed, in words; its check, which raises ValueError; its default.

    The default is None for a key that must be given, and empty for one that may be left out.
    """

    meaning: str
    words: str
    check: Callable[[Any], Any]
    default: Any = None


def _direction(value: Any) -> Any:
    read = numbers(value, 3)
    if not any(read):
        raise ValueError("it has no direction")
    return read


def _three_formulas(value: Any) -> Any:
    if not isinstance(value, tuple) or len(value) != 3:
        raise ValueError
    for part in value:
        if text := formula_fault(part, ("x", "y", "z", "t")):
            raise ValueError(text)
    return value


def _names_in(text: str, variables: tuple[str, ...]) -> set[str]:
    """The names in a formula; raises FormulaError. Its parameters are numbers, so that they may be exponents."""
    try:
        return set(function_of_arrays(text, (*variables, *known_names())).names)  # type: ignore[attr-defined]
    except FormulaError:
        numbers = known_numbers()
        function_of_arrays(with_numbers(text, numbers), (*variables, *known_names()))
        return set(numbers) & {
            node.id for node in ast.walk(syntax_tree(text.strip(), "")) if isinstance(node, ast.Name)
        }


def formula_fault(value: Any, names: tuple[str, ...]) -> str:
    """What is wrong with a number or a formula in these variables and in parameters; empty where nothing is."""
    try:
        if isinstance(value, str):
            use(_names_in(value, names))
        else:
            number(value)
    except FormulaError as error:
        return f"{shown(value)}: {error}"
    except ValueError as error:
        return str(error) or f"{shown(value)} is neither a number nor a formula"
    return ""


SPEED = FlowKey("speed on the axis of the pipe", "a number, in length/time", number)
FORMULAS = FlowKey(
    "velocity of the fluid (length/time)",
    'three numbers or formulas in x, y, z and t, such as ["sin(y)", "0", "0"]',
    _three_formulas,
)
RADIUS = FlowKey(
    "radius of the pipe, at which the fluid rests (length)",
    "a positive number",
    lambda value: number(value, Positive),
)
VECTOR = FlowKey("velocity of the fluid (length/time)", "three numbers", lambda value: numbers(value, 3))


def _rate(meaning: str) -> FlowKey:
    return FlowKey(meaning, "a number, in 1/time", number)


def _point(meaning: str) -> FlowKey:
    return FlowKey(meaning, "a point [x, y, z]", lambda value: numbers(value, 3), (0.0, 0.0, 0.0))


def _along(meaning: str, *axis: float) -> FlowKey:
    return FlowKey(meaning, "a direction [x, y, z]", _direction, axis)


CENTRE = _point("a point at which the fluid rests (length)")


def unit(direction: Any) -> np.ndarray:
    """The unit vector along a direction."""
    return np.asarray(direction, dtype=float) / np.linalg.norm(direction)


@dataclass(frozen=True)
class FlowKind:
    """A kind of flow: its keys, and the flow that follows from their values.

    perpendicular: two keys whose directions must be.
    """

    keys: Mapping[str, FlowKey]
    flow: Callable[[Mapping[str, Any]], Profile | tuple[Any, Any, Any]]
    perpendicular: tuple[str, ...] = ()


def _extension(v: Mapping[str, Any]) -> Profile:
    along = np.outer(unit(v["axis"]), unit(v["axis"]))
    if v["across"] is None:
        return Profile(gradient=v["rate"] * (1.5 * along - 0.5 * np.eye(3)))
    return Profile(gradient=v["rate"] * (along - np.outer(unit(v["across"]), unit(v["across"]))))


def _poiseuille(v: Mapping[str, Any]) -> Profile:
    axis = unit(v["axis"])
    return Profile(axis=v["speed"] * axis, form=(np.eye(3) - np.outer(axis, axis)) / v["radius"] ** 2)


FLOWS: dict[str, FlowKind] = {
    "uniform": FlowKind({"velocity": VECTOR}, lambda v: Profile(velocity=np.array(v["velocity"]))),
    # u = rate (x·gradient) along ``direction``
    "shear": FlowKind(
        {
            "rate": _rate("shear rate, by which the speed increases along the gradient"),
            "direction": _along("direction of the flow", 1.0, 0.0, 0.0),
            "gradient": _along("direction in which the speed increases", 0.0, 1.0, 0.0),
            "centre": CENTRE,
        },
        lambda v: Profile(gradient=v["rate"] * np.outer(unit(v["direction"]), unit(v["gradient"]))),
        perpendicular=("direction", "gradient"),
    ),
    # stretching along ``axis`` at this rate; squeezing all round at half of it, or along ``across`` at the same rate
    "extension": FlowKind(
        {
            "rate": _rate("rate of stretching along the axis"),
            "axis": _along("direction of stretching", 1.0, 0.0, 0.0),
            "across": _along("direction of squeezing; all round, at half the rate, if left out"),
            "centre": CENTRE,
        },
        _extension,
        perpendicular=("axis", "across"),
    ),
    # a pipe: ``speed`` on its axis, through ``centre``, and at rest at the ``radius``
    "poiseuille": FlowKind(
        {
            "speed": SPEED,
            "radius": RADIUS,
            "axis": _along("direction of the pipe", 1.0, 0.0, 0.0),
            "centre": _point("a point on the axis of the pipe (length)"),
        },
        _poiseuille,
    ),
    "formula": FlowKind({"velocity": FORMULAS}, lambda v: v["velocity"]),
}
"""Kinds of background flow by name."""


class FlowTable(Table):
    """A background flow: its kind and the values of this kind, which are listed in ``FLOWS``."""

    model_config = ConfigDict(extra="allow")

    kind: str = Field(title="kind of background flow", description="one of " + ", ".join(FLOWS))
    parameters: Parameters | None = Field(
        default=None,
        title="names of numbers for the formulas of this table",
        description="a table of numbers by name, such as { k = 7.0 }, for formulas",
    )

    @property
    def formulas(self) -> Any:
        """The flow: a ``Profile``, or three formulas with the parameters in them."""
        found = FLOWS[self.kind].flow(self.values)
        return found if isinstance(found, Profile) else tuple(with_values(part, self.parameters) for part in found)

    @property
    def values(self) -> dict[str, Any]:
        """The values by name, defaults filled in; None for an ``across`` that is left out."""
        given = dict(self.model_extra or {})
        return {name: given.get(name) for name in FLOWS[self.kind].keys}

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        kind = FLOWS.get(str(data.get("kind")))
        keys = {} if kind is None else kind.keys
        given = {name: _checked(keys[name], value) if name in keys else value for name, value in data.items()}
        return {**{name: key.default for name, key in keys.items() if key.default}, **given}

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        kind = good.get("kind")
        if kind not in FLOWS:
            text = must_be(f"one of {', '.join(FLOWS)}", kind) + nearest(str(kind), FLOWS)
            return [fault(("kind",), raw, text)] if "kind" in good else []
        keys, faults = FLOWS[kind].keys, []
        for name in raw.keys() - {"kind", "parameters", *keys}:
            text = f": a flow of kind {kind} has no {name}{nearest(name, keys)}; it has {', '.join(keys)}"
            faults.append(fault((name,), raw[name], text))
        for name, key in keys.items():
            try:
                if name in raw or key.default is None:
                    key.check(raw.get(name))
            except ValueError as error:
                faults.append(fault((name,), raw.get(name), must_be(key.words, raw.get(name), str(error))))
        return faults or _angle_faults(FLOWS[kind].perpendicular, raw)


def with_values(part: Any, parameters: Mapping[str, float] | None) -> str:
    """A number or formula as a formula with the numbers of parameters."""
    return with_numbers(part, parameters or {}) if isinstance(part, str) else repr(part)


def _checked(key: FlowKey, value: Any) -> Any:
    """The value as it is checked, whole numbers as others; one with a fault as it is."""
    try:
        return key.check(value)
    except ValueError:
        return value


def _angle_faults(names: tuple[str, ...], raw: dict[str, Any]) -> Faults:
    if not names or not all(name in raw for name in names):
        return []
    first, second = (unit(raw[name]) for name in names)
    if abs(first @ second) <= PERPENDICULAR:
        return []
    text = f" = {shown(raw[names[1]])}: must be perpendicular to {names[0]} = {shown(raw[names[0]])}"
    return [fault((names[1],), raw[names[1]], text)]

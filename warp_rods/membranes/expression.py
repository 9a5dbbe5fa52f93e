"""The surface with a formula for φ: kind = "expression" in a scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from warp_rods import formula
from warp_rods.membranes.level_set import Described, Fault, LevelSet, Values
from warp_rods.values import must_be, number, numbers

__all__ = ["Expression"]

MOST_PARAMETERS = 8
PHI = 'text in quotes, such as "x**2 + y**2 + z**2 - R**2"'
BOX = "[[x0, x1], [y0, y1], [z0, z1]], numbers that increase in each pair"
PARAMETERS = f"a table of numbers by name, {MOST_PARAMETERS} at most"
"""What is allowed, in words."""


class Expression:
    """φ as a formula in x, y, z and parameters, differentiated symbolically and compiled."""

    described: ClassVar = {
        "phi": Described("formula of φ in x, y, z and parameters; outward where φ > 0", PHI),
        "box": Described("region in which the membrane is (length)", BOX),
        "parameters": Described("numbers that phi names; the membrane moves by those that are formulas", PARAMETERS),
    }
    keys = tuple(described)

    def read(self, raw: Values) -> tuple[dict[str, Any], list[Fault]]:
        """The values with defaults filled in, and their faults, as far as these follow from the text alone."""
        faults: list[Fault] = []
        box = _box(raw.get("box"), faults)
        parameters = _parameters(raw.get("parameters", {}), faults)
        phi = _phi(raw.get("phi"), parameters, faults)
        return {"phi": phi, "box": box, "parameters": parameters}, faults

    def level_set(self, values: Values) -> LevelSet:
        """The surface with these values; raises FormulaError for a φ that cannot be differentiated.

        Surfaces with the same formula share one field, whatever the values of their parameters.
        """
        from warp_rods.membranes.formula_fields import field

        low, high = np.array(values["box"]).T
        return LevelSet(field(values["phi"], _names(values)), self.numbers(values), (low, high), closed=None)

    def numbers(self, values: Values) -> np.ndarray:
        """The parameters of the field, in the order of their names."""
        return np.array([values["parameters"][name] for name in _names(values)])

    def rate(self, values: Values) -> Any:
        """The Warp function x, p, dp/dt -> ∂tφ, ∇∂tφ."""
        from warp_rods.membranes.formula_fields import rate

        return rate(values["phi"], _names(values))


def _names(values: Values) -> tuple[str, ...]:
    return tuple(sorted(values["parameters"]))


def _phi(value: Any, parameters: dict[str, Any] | None, faults: list[Fault]) -> str:
    if not isinstance(value, str):
        faults.append((("phi",), must_be(PHI, value)))
        return ""
    try:
        if parameters is not None:
            formula.check(value.strip(), sorted(parameters))
    except formula.FormulaError as error:
        faults.append((("phi",), f": {error}"))
    return value.strip()


def _box(value: Any, faults: list[Fault]) -> tuple[tuple[float, ...], ...]:
    try:
        pairs = tuple(numbers(pair, 2) for pair in value) if isinstance(value, tuple) else ()
    except ValueError:
        pairs = ()
    if len(pairs) != 3 or not all(low < high for low, high in pairs):
        faults.append((("box",), must_be(BOX, value)))
    return pairs


def _parameters(value: Any, faults: list[Fault]) -> dict[str, Any] | None:
    """Numbers or formulas in t by name; None where they are not a table, so that phi cannot be checked."""
    if not isinstance(value, Mapping) or len(value) > MOST_PARAMETERS:
        faults.append((("parameters",), must_be(PARAMETERS, value)))
        return None
    kept: dict[str, Any] = {}
    for name, given in value.items():
        if not formula.usable_name(name):
            text = (
                ": cannot be the name of a parameter: use letters, digits and _, and no name that has a meaning already"
            )
            faults.append((("parameters", name), text))
            continue
        try:
            kept[name] = _number_or_formula(given)
        except ValueError as error:
            kept[name] = 0.0  # so that this name is not reported as unknown in phi, too
            faults.append((("parameters", name), must_be("a number, or a formula in t", given, str(error))))
    return kept


def _number_or_formula(value: Any) -> float | str:
    """Raises ValueError, possibly with a hint."""
    if not isinstance(value, str):
        return number(value)
    formula.function_of_time(value)(0.0)
    return value.strip()

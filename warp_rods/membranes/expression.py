"""The membrane whose φ is a text: kind = "expression" of a scene."""

from __future__ import annotations

import functools
import hashlib
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from warp_rods import formula
from warp_rods.kernels.surface.geometry import written_field
from warp_rods.membranes import in_time
from warp_rods.membranes.field_source import field_source
from warp_rods.membranes.kinds import Shape, Values

MOST_PARAMETERS = 8

Faults = list[tuple[tuple[str | int, ...], str]]


class Expression:
    """φ as a formula in x, y, z and parameters, differentiated symbolically and compiled."""

    key = "phi"
    keys = ("phi", "box", "parameters")

    def read(self, raw: Values) -> tuple[dict[str, Any], Faults]:
        """The values with defaults filled in, and what is wrong with them."""
        faults: Faults = [
            ((name,), f": not a parameter of expression; it has {', '.join(self.keys)}")
            for name in raw
            if name not in self.keys
        ]
        box = _box(raw.get("box"), faults)
        parameters = _parameters(raw.get("parameters", {}), faults)
        phi = _phi(raw.get("phi"), tuple(sorted(parameters)), faults)
        return {"phi": phi, "box": box, "parameters": parameters}, faults

    def shape(self, values: Values) -> Shape:
        """The surface with these values; surfaces of one text share a field whatever their parameters."""
        names = tuple(sorted(values["parameters"]))
        low, high = np.array(values["box"]).T
        numbers = np.array([values["parameters"][name] for name in names])
        return Shape(field(values["phi"], names), numbers, (low, high), closed=None)


@functools.cache
def field(phi: str, names: tuple[str, ...]) -> Any:
    """The Warp function x, p -> φ, ∇φ, ∇∇φ of a text, p its parameters in the order of ``names``.

    Raises FormulaError for a text that is not allowed.
    """
    source = field_source(formula.read(phi, names))
    return written_field(f"field_{hashlib.sha256(source.encode()).hexdigest()[:16]}", source)


def _phi(value: Any, names: tuple[str, ...], faults: Faults) -> str:
    if not isinstance(value, str):
        faults.append((("phi",), ': must be text in quotes, such as "x**2 + y**2 + z**2 - R**2"'))
        return ""
    try:
        field(value.strip(), names)
    except formula.FormulaError as error:
        faults.append((("phi",), f": {error}"))
    return value.strip()


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _box(value: Any, faults: Faults) -> tuple[tuple[float, float], ...]:
    try:
        rows = tuple((low, high) for low, high in value)
    except (TypeError, ValueError):
        rows = ()
    if len(rows) != 3 or not all(_is_number(a) and _is_number(b) and a < b for a, b in rows):
        faults.append((("box",), ": must be [[x0, x1], [y0, y1], [z0, z1]], numbers that rise in each pair"))
        return ()
    return tuple((float(low), float(high)) for low, high in rows)


def _parameters(value: Any, faults: Faults) -> dict[str, Any]:
    """Those that can be used, numbers or texts in t; names are checked first, since phi is read with them."""
    if not isinstance(value, Mapping) or len(value) > MOST_PARAMETERS:
        faults.append((("parameters",), f": must be a table of numbers by name, {MOST_PARAMETERS} at most"))
        return {}
    kept: dict[str, Any] = {}
    for name, number in value.items():
        if not formula.usable_name(name):
            faults.append((("parameters", name), ": must be called otherwise: letters, digits and _, no name in use"))
        elif isinstance(number, str):
            kept[name] = number.strip()
            if wrong := in_time.fault(kept[name]):
                faults.append((("parameters", name), f": must be a number, or a text in t: {wrong}"))
        elif not _is_number(number):
            faults.append((("parameters", name), ": must be a number, or a text in t"))
        else:
            kept[name] = float(number) + 0.0
    return kept

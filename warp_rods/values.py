"""Values of a scene: conversion from Python and NumPy, number types, and their form in messages."""

from __future__ import annotations

import functools
import json
import os
import re
from collections.abc import Iterable, Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import AllowInfNan, BaseModel, Field, Strict, TypeAdapter, ValidationError

from warp_rods.errors import nearest

__all__ = [
    "LARGEST",
    "SMALLEST",
    "Number",
    "Positive",
    "ZeroOrMore",
    "hint",
    "key_path",
    "literal",
    "must_be",
    "nearest",
    "number",
    "numbers",
    "plain",
    "shortened",
    "shown",
]

LARGEST, SMALLEST = 1e30, 1e-40
"""Bounds of the size of numbers, and of positive ones: products of several of them are finite, and not zero. A soft
protein has a stiffness of 1e-29 in SI units."""
Number = Annotated[float, Strict(), AllowInfNan(False), Field(ge=-LARGEST, le=LARGEST)]
"""A finite number. Integers are numbers; booleans and text are not."""
Positive = Annotated[Number, Field(ge=SMALLEST)]
ZeroOrMore = Annotated[Number, Field(ge=0)]

QUOTED_NUMBER = re.compile(r"\s*[-+]?[0-9][-+0-9.eE_]*\s*")
BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
LONGEST_SHOWN = 60


def plain(value: Any) -> Any:
    """The value in plain types: lists and arrays as tuples, NumPy scalars as numbers, paths as text, tables as dicts.

    Keys with the value None are left out, and masked values become None. −0 becomes 0, so that equal scenes have equal
    hashes. Values of other types, such as dates, stay as they are.
    """
    if isinstance(value, (float, np.floating)):
        return float(value) + 0.0
    if isinstance(value, np.generic):
        return value.item() if isinstance(value, (np.integer, np.bool_, np.str_)) else value
    if isinstance(value, BaseModel):
        return plain(value.model_dump(exclude_none=True))
    if hasattr(value, "as_table"):
        return plain(value.as_table())
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, (list, tuple)):
        return tuple(plain(item) for item in value)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    return _from_array(value) if hasattr(value, "__array__") else value


def _from_array(value: Any) -> Any:
    array = value if isinstance(value, np.ndarray) else np.asarray(value)
    return value if array.dtype.kind in "mMV" else plain(array.tolist())


def number(value: Any, kind: Any = Number) -> float:
    """The value as a float; raises ValueError with a hint, possibly empty, where it is not of this kind."""
    try:
        return _adapter(kind).validate_python(value)
    except ValidationError as error:
        line = error.errors(include_url=False)[0]
        raise ValueError(hint(line["type"], line["input"])) from None


def numbers(value: Any, count: int, kind: Any = Number) -> tuple[float, ...]:
    """The value as a tuple of ``count`` floats; raises ValueError where it is not one."""
    if not isinstance(value, tuple) or len(value) != count:
        raise ValueError
    return tuple(number(part, kind) for part in value)


@functools.cache
def _adapter(kind: Any) -> TypeAdapter:
    return TypeAdapter(kind)


def hint(error: str, value: Any) -> str:
    """Advice for a value with this type of pydantic error, beyond what is allowed; may be empty."""
    if error == "finite_number" or (error == "float_type" and type(value) is int):
        return "it must be finite"
    if error in ("greater_than_equal", "less_than_equal") and _is_number(value):
        if abs(value) > LARGEST:
            return f"numbers are at most {LARGEST:g} in size: use other units"
        if 0 < value < SMALLEST:
            return f"positive numbers are at least {SMALLEST:g}: use other units"
    is_quoted = error in ("float_type", "int_type") and isinstance(value, str) and QUOTED_NUMBER.fullmatch(value)
    return "leave out the quotes" if is_quoted else ""


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def must_be(allowed: str, value: Any, note: str = "") -> str:
    """The text after the key path of a wrong value, or of a missing one (None)."""
    start = ": missing" if value is None else f" = {shown(value)}"
    return f"{start}{';' if value is None else ':'} must be {allowed}{note and '; ' + note}"


def shown(value: Any) -> str:
    """The value on one line in TOML notation, shortened."""
    return shortened(literal(value))


def shortened(text: str) -> str:
    """A text of at most ``LONGEST_SHOWN`` characters, with dots where more are left out."""
    return text if len(text) <= LONGEST_SHOWN else text[: LONGEST_SHOWN - 3] + "..."


def literal(value: Any) -> str:
    """The value on one line in TOML notation, or in that of Python where TOML has none."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(literal, value)) + "]"
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {literal(item)}" for key, item in value.items()) + " }"
    return repr(value)


def key_path(loc: Iterable[str | int]) -> str:
    """("filaments", 0, "length") as ``filaments[0].length``."""
    parts = [f"[{part}]" if isinstance(part, int) else "." + _key(part) for part in loc]
    return "".join(parts).removeprefix(".")


def _key(key: str) -> str:
    return key if BARE_KEY.fullmatch(key) else literal(key)

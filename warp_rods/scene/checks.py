"""How a scene's tables are checked so that one message names every fault: number rules, the base class."""

from __future__ import annotations

import difflib
import math
import re
import sys
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, PlainValidator, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from warp_rods.scene.toml import bare_or_quoted, literal

RULES: dict[str, Callable[[float], bool]] = {
    "any number": lambda x: True,
    "positive": lambda x: x > 0,
    "zero or more": lambda x: x >= 0,
}
"""What a finite number may be asked to be."""

Faults = list[InitErrorDetails]
Rows = tuple["float | tuple[float, ...]", ...]

QUOTED_NUMBER = re.compile(r"\s*[-+]?[0-9][-+0-9.eE_]*\s*")

MOST_VALUES_NAMED = 5
"""Of a list with many wrong values this many are named one by one, the others counted."""


def fault(loc: tuple, value: Any, text: str) -> InitErrorDetails:
    """A fault whose line reads: the key path of ``loc``, then ``text``."""
    return InitErrorDetails(type=PydanticCustomError("fault", "{text}", {"text": text}), loc=loc, input=value)


def wrong(loc: tuple, value: Any, note: str = "") -> InitErrorDetails:
    """A value that is not what its key's description asks for; its table writes the line."""
    return InitErrorDetails(type=PydanticCustomError("wrong", "{note}", {"note": note}), loc=loc, input=value)


def refuse(faults: Faults, title: str = "value") -> None:
    """Raises a ValidationError of these faults, if there are any."""
    if faults:
        raise ValidationError.from_exception_data(title, faults)


def shown(value: Any) -> str:
    """The value as the scene has it, shortened."""
    text = literal(value)
    return text if len(text) <= 60 else text[:57] + "..."


def nearest(word: Any, known: Iterable[str]) -> str:
    """A hint with the known word that looks most like this one, or nothing."""
    close = difflib.get_close_matches(str(word), list(known), n=1)
    return f" (did you mean {close[0]}?)" if close else ""


def key_path(loc: tuple) -> str:
    """("filaments", 0, "length") as ``filaments[0].length``."""
    parts = [f"[{part}]" if isinstance(part, int) else "." + bare_or_quoted(part) for part in loc]
    return "".join(parts).removeprefix(".")


def plain(value: Any) -> Any:
    """The same with tables as dicts with text keys and arrays as lists, as TOML would have given it."""
    if isinstance(value, BaseModel):
        return plain(value.model_dump(exclude_none=True))
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items() if item is not None}
    return [plain(item) for item in value] if isinstance(value, (list, tuple)) else value


def number(value: Any, rule: str, loc: tuple, faults: Faults) -> float:
    """The value as a float; where it is not finite or breaks the rule, adds a fault and returns NaN."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        # Adding zero turns −0 into 0, so that equal scenes have equal hashes.
        x = float(value) + 0.0 if abs(value) <= sys.float_info.max else math.nan
        if math.isfinite(x) and RULES[rule](x):
            return x
        note = "" if math.isfinite(x) else "it must be finite"
    else:
        note = "leave out the quotes" if isinstance(value, str) and QUOTED_NUMBER.fullmatch(value) else ""
    faults.append(wrong(loc, value, note))
    return math.nan


def row(value: Any, rules: tuple[str, ...], loc: tuple, faults: Faults) -> tuple[float, ...]:
    """A list of numbers, one a rule; adds faults as ``number`` does."""
    if not isinstance(value, (list, tuple)) or len(value) != len(rules):
        faults.append(wrong(loc, value))
        return ()
    return tuple(number(v, rules[i], (*loc, i), faults) for i, v in enumerate(value))


def _refuse_list(value: Any, faults: Faults) -> None:
    named, others = faults[:MOST_VALUES_NAMED], len(faults) - MOST_VALUES_NAMED
    refuse(named + ([wrong((), value, f"{others} more of its values are wrong")] if others > 0 else []))


def a_number(rule: str) -> PlainValidator:
    """Validator of one number."""

    def check(value: Any) -> float:
        faults: Faults = []
        x = number(value, rule, (), faults)
        refuse(faults)
        return x

    return PlainValidator(check)


def number_each(rule: str) -> PlainValidator:
    """Validator of a number, or a list with one for each rod."""

    def check(value: Any) -> float | tuple[float, ...]:
        faults: Faults = []
        if isinstance(value, (list, tuple)):
            read: Any = tuple(number(v, rule, (i,), faults) for i, v in enumerate(value))
        else:
            read = number(value, rule, (), faults)
        _refuse_list(value, faults)
        return read

    return PlainValidator(check)


def numbers(rule: str) -> PlainValidator:
    """Validator of a list of numbers."""

    def check(value: Any) -> tuple[float, ...]:
        faults: Faults = []
        if not isinstance(value, (list, tuple)):
            refuse([wrong((), value)])
        read = tuple(number(v, rule, (i,), faults) for i, v in enumerate(value))
        _refuse_list(value, faults)
        return read

    return PlainValidator(check)


def _all_rows(value: Any, rules: tuple[str, ...], faults: Faults) -> tuple[tuple[float, ...], ...]:
    return tuple(row(v, rules, (i,), faults) for i, v in enumerate(value))


def vector_each(*rules: str) -> PlainValidator:
    """Validator of a list of numbers, one a rule, or a list of such lists, one for each rod."""

    def check(value: Any) -> tuple:
        faults: Faults = []
        is_rows = isinstance(value, (list, tuple)) and any(isinstance(v, (list, tuple)) for v in value)
        read: tuple = _all_rows(value, rules, faults) if is_rows else row(value, rules, (), faults)
        _refuse_list(value, faults)
        return read

    return PlainValidator(check)


def point_each(may_be_zero: bool = True) -> PlainValidator:
    """Validator of a list of points or directions [x, y, z], one for each rod."""

    def check(value: Any) -> tuple[tuple[float, ...], ...]:
        faults: Faults = []
        if not isinstance(value, (list, tuple)):
            refuse([wrong((), value)])
        read = _all_rows(value, ("any number",) * 3, faults)
        if not may_be_zero:
            faults += [wrong((i,), v, "it has no direction") for i, v in enumerate(read) if v == (0.0,) * 3]
        _refuse_list(value, faults)
        return read

    return PlainValidator(check)


def rows_each() -> PlainValidator:
    """Validator of a number, or a list with a number or a list of numbers for each rod."""

    def read(value: Any, loc: tuple, faults: Faults) -> Any:
        if len(loc) < 2 and isinstance(value, (list, tuple)):
            return tuple(read(v, (*loc, i), faults) for i, v in enumerate(value))
        return number(value, "any number", loc, faults)

    def check(value: Any) -> float | Rows:
        faults: Faults = []
        rows = read(value, (), faults)
        _refuse_list(value, faults)
        return rows

    return PlainValidator(check)


class Table(BaseModel):
    """A table of a scene: frozen, no unknown keys; a field's description is what its key allows."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        """The table with those defaults filled in that depend on other keys."""
        return data

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        """Faults between keys: ``raw`` is the table as given, ``good`` what of it is right by itself."""
        return []

    @model_validator(mode="wrap")
    @classmethod
    def _every_fault(cls, data: Any, handler: Any) -> Any:
        raw, faults, made = plain(data), [], None
        if isinstance(raw, dict):
            raw = cls.filled(raw)
        try:
            made = handler(raw)
        except ValidationError as error:
            faults = [cls._own_words(line) for line in error.errors(include_url=False)]
        if isinstance(raw, dict):
            bad = {line["loc"][0] for line in faults}
            faults += cls.cross_faults(raw, {key: raw[key] for key in raw if key not in bad})
        refuse(faults, cls.__name__)
        return made

    @classmethod
    def _own_words(cls, line: Any) -> InitErrorDetails:
        """The line of an error in this table; errors of tables in it have been put into words by those."""
        kind, loc, value = line["type"], line["loc"], line["input"]
        if kind == "fault":
            return fault(loc, value, line["msg"])
        if not loc:
            return wrong(loc, value)
        known = cls.model_fields
        if kind == "extra_forbidden":
            return fault(loc, value, f": unknown key{nearest(loc[0], known)}; known here: {', '.join(known)}")
        allowed = known[loc[0]].description
        if kind == "missing":
            return fault(loc, value, f": missing; must be {allowed}")
        note = f"; {line['msg']}" if kind == "wrong" and line["msg"] else ""
        return fault(loc, value, f" = {shown(value)}: must be {allowed}{note}")

"""Named numbers in formulas, such as k in "7*sin(k*s - t)": the key ``parameters`` of a table with formulas.

Formulas are checked where they stand, perhaps in a table within the one that has the parameters: while this one is
read, its names are known everywhere within it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Annotated, Any

from pydantic import AfterValidator
from pydantic_core import PydanticCustomError

from warp_rods.formula import usable_name
from warp_rods.scene.per_rod import NumberEach
from warp_rods.values import Number, shown

__all__ = ["Parameters", "ParametersEach", "known_names", "known_numbers", "known_within", "names_of", "unused", "use"]

VARIABLES = ("s", "t")
"""Names that have a meaning in formulas, besides x, y, z and functions."""


@dataclass
class _Known:
    """The names of the table that is read, and those that have occurred in a formula."""

    names: tuple[str, ...] = ()
    numbers: dict[str, float] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)


_KNOWN: ContextVar[_Known] = ContextVar("parameters", default=_Known())  # noqa: B039 (that of no table is never used)


def _named(table: dict[str, Any]) -> dict[str, Any]:
    for name in table:
        if not usable_name(name) or name in VARIABLES:
            text = f"{shown(name)} cannot be a name here: use letters, digits and _, and no name of formulas"
            raise PydanticCustomError("note", "{text}", {"text": text})
    return table


Parameters = Annotated[dict[str, Number], AfterValidator(_named)]
"""A number by name."""
ParametersEach = Annotated[dict[str, NumberEach], AfterValidator(_named)]
"""A number by name, or a list with one for each rod."""


@contextmanager
def known_within(table: Any) -> Iterator[None]:
    """Let the parameters of a table be known while it is read."""
    names = names_of(table)
    given = table["parameters"] if names else {}
    numbers = {name: value for name, value in given.items() if isinstance(value, (int, float))}
    token = _KNOWN.set(_Known(names, numbers))
    try:
        yield
    finally:
        _KNOWN.reset(token)


def names_of(table: Any) -> tuple[str, ...]:
    """The names of the parameters of a table as given; none where they are no table."""
    given = table.get("parameters") if isinstance(table, Mapping) else None
    return tuple(given) if isinstance(given, Mapping) else ()


def known_names() -> tuple[str, ...]:
    """The names of the parameters of the table that is read."""
    return _KNOWN.get().names


def known_numbers() -> dict[str, float]:
    """Those parameters of the table that is read which are one number each."""
    return _KNOWN.get().numbers


def use(names: Any) -> None:
    """Note that names occur in a formula."""
    if known := _KNOWN.get().names:
        _KNOWN.get().used.update(set(names).intersection(known))


def unused() -> list[str]:
    """Names of parameters of the table that is read which occur in none of its formulas."""
    return [name for name in _KNOWN.get().names if name not in _KNOWN.get().used]

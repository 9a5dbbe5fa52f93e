"""Values of an ensemble: one for all rods, or a list with one for each rod."""

from __future__ import annotations

from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, Discriminator, Tag
from pydantic_core import PydanticCustomError

from warp_rods.values import Number, Positive, ZeroOrMore

__all__ = [
    "EACH", "ONE", "OR_EACH", "TABLE", "TAGS", "WORD", "WORDS", "Direction", "Each", "EachVector", "NumberEach",
    "PositiveEach", "Vector", "WordOrTable", "ZeroOrMoreEach", "is_list",
]  # fmt: skip

T = TypeVar("T")
W = TypeVar("W")

TAGS = ONE, EACH, WORD, TABLE, WORDS = "(one)", "(each)", "(word)", "(table)", "(words)"
"""Names of the alternatives of unions, which pydantic adds to the path of an error."""
OR_EACH = ", or a list with one for each rod"
"""End of the description of a key that may have either."""


def is_list(value: Any) -> bool:
    """Whether a value is a list (a tuple, once converted)."""
    return isinstance(value, tuple)


def _number_or_list(value: Any) -> str:
    return EACH if is_list(value) else ONE


def _row_or_rows(value: Any) -> str:
    return EACH if is_list(value) and any(map(is_list, value)) else ONE


def _word_or_table(value: Any) -> str:
    return WORD if isinstance(value, str) else TABLE


Each = Annotated[Annotated[T, Tag(ONE)] | Annotated[tuple[T, ...], Tag(EACH)], Discriminator(_number_or_list)]
"""A number of a kind, or a list with one for each rod."""
EachVector = Annotated[Annotated[T, Tag(ONE)] | Annotated[tuple[T, ...], Tag(EACH)], Discriminator(_row_or_rows)]
"""A list of numbers, or a list of such lists with one for each rod."""
WordOrTable = Annotated[Annotated[W, Tag(WORD)] | Annotated[T, Tag(TABLE)], Discriminator(_word_or_table)]
"""One of some words, or a table."""

NumberEach = Each[Number]
PositiveEach = Each[Positive]
ZeroOrMoreEach = Each[ZeroOrMore]
Vector = tuple[Number, Number, Number]


def _not_zero(value: tuple[float, ...]) -> tuple[float, ...]:
    if not any(value):
        raise PydanticCustomError("note", "it has no direction")
    return value


Direction = Annotated[Vector, AfterValidator(_not_zero)]

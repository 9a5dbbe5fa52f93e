"""Values along rods: a number for all rods or for each, a formula, one formula for each rod, or values at the nodes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from warp_rods.formula import FormulaError, function_of_arrays
from warp_rods.scene.checks import Table
from warp_rods.scene.parameters import known_names, use
from warp_rods.scene.per_rod import EACH, ONE, TABLE, WORD, WORDS, is_list
from warp_rods.values import Number, Positive

__all__ = [
    "OR_ALONG",
    "OR_IN_TIME",
    "AtNodes",
    "Formula",
    "NumberAlong",
    "PositiveAlong",
    "checked_formula",
    "given_along",
]

T = TypeVar("T")

OR_ALONG = ", a formula in s, or a list with one for each rod, or { nodes = [...] }"
OR_IN_TIME = ", a formula in s and t, or a list with one for each rod, or { nodes = [...] }"
"""End of the description of a key that may change along rods."""


def checked_formula(*names: str) -> Callable[[str], str]:
    """A check that a text is a formula in these variables, and in the parameters of the table that is read."""

    def check(text: str) -> str:
        try:
            use(function_of_arrays(text, (*names, *known_names())).names)  # type: ignore[attr-defined]
        except FormulaError as error:
            raise PydanticCustomError("note", "{text}", {"text": str(error)}) from None
        return text

    return check


Formula = Annotated[str, AfterValidator(checked_formula("s"))]
"""A formula in s."""
FormulaInTime = Annotated[str, AfterValidator(checked_formula("s", "t"))]
"""A formula in s and t."""


class AtNodes(Table):
    """Values at the nodes of all rods, from the first end to the last."""

    nodes: tuple[Number, ...] = Field(
        title="values from the first end to the last, the same for all rods",
        description="a list of numbers, one for each node",
    )


def _kind(value: Any) -> str:
    if isinstance(value, dict):
        return TABLE
    if isinstance(value, str):
        return WORD
    if is_list(value):
        return WORDS if any(isinstance(part, str) for part in value) else EACH
    return ONE


def _along(number: Any, formula: Any) -> Any:
    return Annotated[
        Annotated[number, Tag(ONE)]
        | Annotated[tuple[number, ...], Tag(EACH)]
        | Annotated[formula, Tag(WORD)]
        | Annotated[tuple[formula, ...], Tag(WORDS)]
        | Annotated[AtNodes, Tag(TABLE)],
        Discriminator(_kind),
    ]


PositiveAlong = _along(Positive, Formula)
NumberAlong = _along(Number, FormulaInTime)


def given_along(value: Any) -> Any:
    """A value of one of these types as the ensembles of rods take it."""
    return [list(value.nodes)] if isinstance(value, AtNodes) else value

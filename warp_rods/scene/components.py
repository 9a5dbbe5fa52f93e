"""Three components along filaments, each a number, a formula in s and t, or a number for each node; or three a rod."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Tag

from warp_rods.scene.along import AtNodes, FormulaInTime
from warp_rods.scene.per_rod import ONE, TABLE, WORD, EachVector, is_list
from warp_rods.values import Number, Positive, ZeroOrMore

__all__ = ["OR_COMPONENTS", "DragAlong", "StiffnessAlong", "StrainsAlong", "numbers_of", "rows_of"]

OR_COMPONENTS = ", or a list with one for each rod; in place of a number a formula in s and t, or { nodes = [...] }"
"""End of the description of a key with three components along filaments."""


def _kind(value: Any) -> str:
    return TABLE if isinstance(value, (dict, AtNodes)) else WORD if isinstance(value, str) else ONE


_Any = Annotated[
    Annotated[Number, Tag(ONE)] | Annotated[FormulaInTime, Tag(WORD)] | Annotated[AtNodes, Tag(TABLE)],
    Discriminator(_kind),
]
_Positive = Annotated[
    Annotated[Positive, Tag(ONE)] | Annotated[FormulaInTime, Tag(WORD)] | Annotated[AtNodes, Tag(TABLE)],
    Discriminator(_kind),
]
_NotNegative = Annotated[
    Annotated[ZeroOrMore, Tag(ONE)] | Annotated[FormulaInTime, Tag(WORD)] | Annotated[AtNodes, Tag(TABLE)],
    Discriminator(_kind),
]
StrainsAlong = EachVector[tuple[_Any, _Any, _Any]]
StiffnessAlong = EachVector[tuple[_Positive, _Positive, _Positive]]
DragAlong = EachVector[tuple[_Positive, _Positive, _NotNegative]]


def rows_of(value: Any) -> tuple[Any, ...]:
    """The components of each rod, or once those of all, as ensembles take them: lists of numbers for nodes."""
    rows = value if any(map(is_list, value)) else (value,)
    return tuple(tuple(list(part.nodes) if isinstance(part, AtNodes) else part for part in row) for row in rows)


def numbers_of(value: Any) -> bool:
    """Whether a value has numbers only."""
    return all(isinstance(part, (int, float)) for row in rows_of(value) for part in row)

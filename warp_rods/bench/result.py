"""What a benchmark is given, and what it returns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

Cell = str | float | None


def nothing(_note: str) -> None:
    """Tell nobody."""


@dataclass(frozen=True)
class Settings:
    """How to run a benchmark.

    quick: so small that its figures mean nothing, for tests. against: the folder of another version of this package to
    compare with. tell: shows what is going on.
    """

    quick: bool = False
    against: Path | None = None
    tell: Callable[[str], None] = nothing


@dataclass(frozen=True)
class Table:
    """Rows of texts and numbers; a number is shown with three digits, None as a dash."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]


@dataclass(frozen=True)
class Section:
    """What a benchmark found: tables, Matplotlib figures by name, and what must be known to read them."""

    tables: Sequence[Table]
    figures: Mapping[str, Any] = field(default_factory=dict)
    notes: Sequence[str] = ()


def shown(cell: Cell) -> str:
    """A cell as text."""
    if cell is None or cell != cell:
        return "–"
    if isinstance(cell, str):
        return cell
    return f"{cell:.3g}" if abs(cell) < 1000 else f"{cell:,.0f}"

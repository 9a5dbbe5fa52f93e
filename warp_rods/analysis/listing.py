"""A row of the table of measures, and the printed form of the table."""

from __future__ import annotations

import inspect
import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from itertools import zip_longest
from textwrap import wrap
from typing import Literal

import xarray as xr

from warp_rods.analysis.conditions import Condition
from warp_rods.notebook import html_table

MEMBRANE = "membrane"
"""Listed among the needs of a measure that takes the membrane as its second argument."""
Kind = Literal["rods", "swimmers", "filaments", "swarm"]
KINDS: dict[Kind, str] = {
    "rods": "rods of any kind",
    "swimmers": "swimmers",
    "filaments": "filaments",
    "swarm": "all rods together",
}
"""What a measure applies to, and its heading in the printed table."""
_COLUMNS = ("measure", "units", "description", "needs")
_GAP, _NARROWEST = "  ", 24


@dataclass(frozen=True)
class Measure:
    """A measure: ``function(dataset, **options)``, or ``function(dataset, surface, **options)``.

    ``of``: a key of ``KINDS``. ``units``: of the values, or of the first variable where ``function`` returns a Dataset.
    ``needs``: variables of the trajectory, and ``MEMBRANE``. ``conditions``: what else data need, with the default
    options; ``measures(data)`` lists the measure where all hold.
    """

    function: Callable[..., xr.DataArray | xr.Dataset]
    of: Kind
    units: str
    needs: tuple[str, ...]
    conditions: tuple[Condition, ...] = ()

    @property
    def description(self) -> str:
        """The first line of the docstring of the function, without the dimensions at its end."""
        first = (inspect.getdoc(self.function) or "").partition("\n")[0]
        return re.sub(r"( \([^()]*\))?\.?$", "", first)

    @property
    def needs_membrane(self) -> bool:
        return MEMBRANE in self.needs

    @property
    def options(self) -> tuple[str, ...]:
        """The names of the options that it takes."""
        own = list(inspect.signature(self.function).parameters)[2 if self.needs_membrane else 1 :]
        return (*own, "surface") if self.needs_membrane else tuple(own)

    def cells(self) -> tuple[str, str, str]:
        """The cells of its row in the printed table: units, description, needs."""
        return self.units, self.description, ", ".join([*self.needs, *(one.words for one in self.conditions)])


class Measures(dict[str, Measure]):
    """Measures by name; printed as a table, in a notebook too."""

    def __repr__(self) -> str:
        rows = [_COLUMNS, *((f"  {name}", *row.cells()) for name, row in self.items())]
        width = [max(len(row[column]) for row in rows) for column in range(len(_COLUMNS))]
        left = max(shutil.get_terminal_size((120, 24)).columns, 80) - width[0] - width[1] - 3 * len(_GAP)
        width[2] = min(width[2], max(left - _NARROWEST, left // 2))
        width[3] = left - width[2]
        lines, kind = _lines(rows[0], width), ""
        for row, measure in zip(rows[1:], self.values(), strict=True):
            lines += [KINDS[measure.of]] * (measure.of != kind) + _lines(row, width)
            kind = measure.of
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        rows = [("of", *_COLUMNS), *((row.of, name, *row.cells()) for name, row in self.items())]
        return html_table(rows[1:], rows[0])


def _lines(cells: tuple[str, ...], width: list[int]) -> list[str]:
    """One row of the printed table; long cells take several lines."""
    columns = [wrap(cell, at) if cell.strip() else [""] for cell, at in zip(cells, width, strict=True)]
    columns[0] = [cells[0]]
    lines = zip_longest(*columns, fillvalue="")
    return [_GAP.join(cell.ljust(at) for cell, at in zip(line, width, strict=True)).rstrip() for line in lines]

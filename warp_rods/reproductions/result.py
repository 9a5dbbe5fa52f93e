"""What a reproduction returns: a figure, its data, and a table that compares published values with ours."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr


@dataclass(frozen=True)
class Comparison:
    """One row of the table: a quantity, its published value, ours, and how the text was read.

    ``published`` is a number, a statement, or "" where the text gives nothing. ``reading`` states the interpretation
    where the text is silent or contradicts itself. ``statement_holds``: whether our result supports a published
    statement; None where there is no statement.
    """

    quantity: str
    published: float | str
    ours: float | str
    reading: str = ""
    statement_holds: bool | None = None

    @property
    def difference(self) -> str:
        """Relative difference of two numbers in per cent, absolute for a published 0; or whether a statement holds."""
        if isinstance(self.published, str) or isinstance(self.ours, str):
            return {True: "holds", False: "does not hold", None: ""}[self.statement_holds]
        if self.published == 0:
            return f"{self.ours:+.2g}"
        return f"{100 * (self.ours / self.published - 1):+.2g} %"


@dataclass(frozen=True)
class Result:
    """The result of a reproduction.

    figure: a Matplotlib figure. rows: the table. data: columns of equal length by name, or a Dataset. notes: lines on
    parameters and choices, in particular on what the text does not give.
    """

    figure: Any
    rows: list[Comparison]
    data: Mapping[str, np.ndarray] | xr.Dataset
    notes: tuple[str, ...] = ()

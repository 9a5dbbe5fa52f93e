"""What a reproduction gives: a figure, its data, and rows that set what was published beside what this code finds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr


@dataclass(frozen=True)
class Row:
    """One quantity: ``published``, ``ours``, and the ``reading`` taken where the text is silent or contradicts itself.

    Numbers are compared as numbers. A statement is a text on both sides, and ``holds`` says whether ours bears it out;
    None where there is nothing to compare with. ``published`` is "" where the text gives nothing.
    """

    quantity: str
    published: float | str
    ours: float | str
    reading: str = ""
    holds: bool | None = None

    @property
    def difference(self) -> str:
        """Relative where both are numbers, in per cent; absolute to a published 0; else whether the statement holds."""
        if isinstance(self.published, str) or isinstance(self.ours, str):
            return {True: "holds", False: "does not hold", None: ""}[self.holds]
        if self.published == 0:
            return f"{self.ours:+.2g}"
        return f"{100 * (self.ours / self.published - 1):+.2g} %"


@dataclass(frozen=True)
class Result:
    """``figure`` is a Matplotlib figure; ``data`` columns of one length, or a Dataset of arrays with dims.

    ``notes``: lines on how it was made: the scene, and what was chosen because the text does not say.
    """

    figure: Any
    rows: list[Row]
    data: Mapping[str, np.ndarray] | xr.Dataset
    notes: tuple[str, ...] = ()

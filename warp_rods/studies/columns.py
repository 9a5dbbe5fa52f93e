"""The variables of the store of a study: their dimensions besides those of the grid, which all points share."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.analysis.registry import FAILED
from warp_rods.errors import SceneError

__all__ = ["MEASURE_RUNS", "SAME", "Column", "columns_of"]

SAME = "and all points of a study have the same"
MEASURE_RUNS = 'leave it out, give keep = "trajectory" and measure the runs, or give another measure'
"""What to try with a measure whose dimensions depend on the point."""


@dataclass(frozen=True)
class Column:
    """A variable of the store at each point: its further dimensions with their labels, and whether it is text."""

    name: str
    dims: tuple[str, ...] = ()
    shape: tuple[int, ...] = ()
    labels: Mapping[str, list] = field(default_factory=dict)
    text: bool = False
    attributes: Mapping[str, Any] = field(default_factory=dict)

    def misfit(self, found: xr.DataArray) -> str:
        """How values [point, …] differ from it in their further dimensions; empty where they do not."""
        (other,) = columns_of({self.name: found}, {self.name: False})
        if (other.dims, other.shape) != (self.dims, self.shape):
            return f"{_sizes(other)} in place of {_sizes(self)}"
        dims = [dim for dim in self.dims if other.labels.get(dim) != self.labels.get(dim)]
        return f"other values of {', '.join(dims)}" if dims else ""

    def filled(self, found: xr.DataArray | None, dead: np.ndarray) -> np.ndarray:
        """Values [point, …], with NaN or "failed" at ``dead`` points [point]; raises ValueError where they do not fit.

        found: None where no rod is left that could be measured.
        """
        if found is not None and (why := self.misfit(found)):
            raise ValueError(f"{self.name}: this point has {why}, {SAME}; {MEASURE_RUNS}")
        nothing, dtype = (FAILED, object) if self.text else (np.nan, float)
        values = np.full((len(dead), *self.shape), nothing, dtype=dtype)
        if found is not None:
            values[~dead] = found.to_numpy()[~dead]
        return values


def _sizes(column: Column) -> str:
    return " × ".join(f"{size} {dim}" for dim, size in zip(column.dims, column.shape, strict=True)) or "a number"


def columns_of(found: Mapping[str, xr.DataArray], assumes: Mapping[str, bool]) -> list[Column]:
    """The variables of the store for measures at points [point, …]; ``assumes``: which assume a settled motion.

    Raises SceneError where two measures have the same dimension with other labels.
    """
    columns = []
    for name, values in found.items():
        dims = tuple(map(str, values.dims[1:]))
        labels = {dim: values[dim].to_numpy().tolist() for dim in dims if dim in values.coords}
        attributes = dict(values.attrs) | ({"ancillary_variables": "settled"} if assumes[name] else {})
        attributes.pop("left_out", None)
        columns.append(Column(name, dims, values.shape[1:], labels, values.dtype.kind in "UO", attributes))
    for one, other in itertools.combinations(columns, 2):
        _refuse_other_labels(one, other)
    return columns


def _refuse_other_labels(one: Column, other: Column) -> None:
    sizes = [dict(zip(column.dims, column.shape, strict=True)) for column in (one, other)]
    for dim in set(one.dims) & set(other.dims):
        if sizes[0][dim] != sizes[1][dim] or one.labels.get(dim) != other.labels.get(dim):
            raise SceneError(
                f"sweep.measure: {one.name} and {other.name} have other values of {dim}: measure them in two studies"
            )

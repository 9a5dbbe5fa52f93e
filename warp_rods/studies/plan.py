"""The plan of a study: its points, the scene of each, what is measured, and in which tasks."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.analysis.registry import FAILED
from warp_rods.errors import SceneError
from warp_rods.scene.scene import Scene
from warp_rods.scene.sweep import ENSEMBLES, Path, SweepTable, located, replaced
from warp_rods.studies.axes import Axis, axes_of
from warp_rods.studies.summaries import OF_SETTLED, Summary, summary_of
from warp_rods.values import plain, shown

__all__ = ["Column", "Plan", "Wanted", "columns_of"]

MOST_CHECKED = 200
"""Values of an axis that are checked before a study begins; an impossible one among others fails by itself."""
SAME = "and all points of a study have the same"
LIST_THEM = "; list the values, such as [17, 25, 33], or give a linear range whose values are all whole numbers"
MEASURE_RUNS = 'leave it out, give keep = "trajectory" and measure the runs, or give another measure'
"""What to try with a measure whose dimensions depend on the point."""
Index = tuple[int, ...]
"""The place of a point in the grid."""


@dataclass(frozen=True)
class Wanted:
    """A measure of one ensemble, or of a whole run where ``ensemble`` is empty; ``prefix`` of its variables."""

    name: str
    summary: Summary
    ensemble: str
    prefix: str

    @property
    def variables(self) -> set[str]:
        """Variables of the trajectory that it needs."""
        return self.summary.needs


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


@dataclass(frozen=True)
class Plan:
    """A study of a scene with a sweep.

    order: of the axes, where it is not that of the scene. columns: of its store; none before there is one.
    """

    scene: Scene
    order: tuple[str, ...] = ()
    columns: tuple[Column, ...] = ()

    @cached_property
    def sweep(self) -> SweepTable:
        """The table [sweep]."""
        if self.scene.sweep is None:
            example = '[sweep]\n  "swimmers.cell.bend" = { from = 1e-4, to = 1e-2, num = 20, scale = "log" }'
            raise SceneError(f'sweep: missing; a study needs a table such as\n  {example}\n  measure = ["speed"]')
        return self.scene.sweep

    @cached_property
    def axes(self) -> tuple[Axis, ...]:
        """The swept keys and the seeds."""
        _ = self.sweep
        axes = axes_of(self.scene)
        return tuple(sorted(axes, key=lambda axis: self.order.index(axis.key))) if self.order else axes

    @cached_property
    def tables(self) -> dict[str, Any]:
        """The tables of the scene without the sweep."""
        given = plain(self.scene.model_dump(exclude_none=True))
        return {key: value for key, value in given.items() if key != "sweep" and value != ()}

    @cached_property
    def paths(self) -> tuple[Path, ...]:
        """Where the swept keys are in the tables."""
        found = []
        for axis in self.axes[:-1]:
            try:
                found.append(located(self.tables, axis.key))
            except KeyError as why:
                raise SceneError(f'sweep."{axis.key}": {why.args[0]}') from None
        return tuple(found)

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of values on each axis."""
        return tuple(map(len, self.axes))

    @property
    def levels(self) -> int:
        """How often the grid is refined."""
        return self.sweep.refine

    @property
    def first_points(self) -> int:
        """The number of points before refinement."""
        return int(np.prod([axis.first for axis in self.axes]))

    def first(self) -> np.ndarray:
        """Which points of the grid are computed before refinement, as a mask."""
        return self.at_stride(1)

    def at_stride(self, finer: int) -> np.ndarray:
        """The points of the grid whose ranges have been divided into so many parts, as a mask."""
        mask = np.zeros(self.shape, dtype=bool)
        mask[tuple(slice(None, None, max(axis.stride // finer, 1)) for axis in self.axes)] = True
        return mask

    @property
    def size(self) -> str:
        """The number of points, and of values on each axis."""
        sizes = " × ".join(f"{axis.first} {axis.key}" for axis in self.axes)
        return f"{self.first_points} points ({sizes}){f', refined {self.levels} times' if self.levels else ''}"

    # --- scenes ------------------------------------------------------------------------------------------------------

    def tables_at(self, point: Index) -> dict[str, Any]:
        """The tables of the scene of a point."""
        tables: Any = self.tables
        for axis, path, i in zip(self.axes, self.paths, point, strict=False):
            tables = replaced(tables, path, axis.values[i])
        return {**tables, "seed": self.axes[-1].values[point[-1]]}

    def scene_at(self, point: Index) -> Scene:
        """The scene of a point, which can be run by itself; raises SceneError with the swept values."""
        try:
            return Scene.parse(self.tables_at(point))
        except SceneError as error:
            raise SceneError(f"at {self.words(point)}: {error}") from None

    def words(self, point: Index) -> str:
        """The values at a point."""
        return ", ".join(f"{axis.key} = {shown(axis.values[i])}" for axis, i in zip(self.axes, point, strict=True))

    def check(self) -> None:
        """Raises SceneError where a value of an axis, with the first ones of the others, is not possible."""
        lines: list[str] = []
        for number, axis in enumerate(self.axes[:-1]):
            for i in np.unique(np.linspace(0, len(axis) - 1, min(axis.first, MOST_CHECKED)).astype(int)).tolist():
                point = tuple(i if k == number else 0 for k in range(len(self.axes)))
                try:
                    Scene.parse(self.tables_at(point))
                except SceneError as error:
                    advice = LIST_THEM if axis.scale != "list" and "whole number" in str(error) else ""
                    lines.append(f'sweep."{axis.key}" = {shown(axis.values[i])}: {error}{advice}')
                    break
        _ = self.wanted
        if lines:
            raise SceneError("\n".join(lines))

    # --- measures ----------------------------------------------------------------------------------------------------

    @cached_property
    def wanted(self) -> tuple[Wanted, ...]:
        """The measures by ensemble; raises SceneError for an unknown one, and one that applies to no ensemble."""
        found: list[Wanted] = []
        for i, name in enumerate(self.sweep.measure):
            try:
                summary = summary_of(name)
            except ValueError as error:
                raise SceneError(f"sweep.measure[{i}] = {shown(name)}: {error}") from None
            mine = self._of(name, summary)
            if not mine:
                what = f"is a measure of {summary.measure.of}, and the scene has none"
                raise SceneError(f"sweep.measure[{i}] = {shown(name)}: {what}")
            found += mine
        return tuple(found)

    def _of(self, name: str, summary: Summary) -> list[Wanted]:
        kinds = [(kind, table.name) for kind in ENSEMBLES for table in getattr(self.scene, kind)]
        if summary.measure.of == "swarm":
            return [Wanted(name, summary, kinds[0][1] if len(kinds) == 1 else "", "")]
        mine = [table for kind, table in kinds if summary.measure.of in ("rods", kind)]
        return [Wanted(name, summary, table, f"{table}." if len(kinds) > 1 else "") for table in mine]

    @cached_property
    def needs(self) -> set[str]:
        """Variables of the trajectory that the measures need."""
        kinds = [kind for kind in ENSEMBLES if getattr(self.scene, kind)]
        return {"status"}.union(*(w.variables for w in self.wanted), *(OF_SETTLED[kind] for kind in kinds))


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


def mask_of(points: Sequence[Index], shape: Sequence[int]) -> np.ndarray:
    """A mask of the grid with these points."""
    mask = np.zeros(tuple(shape), dtype=bool)
    if len(points):
        mask[tuple(np.array(points).T)] = True
    return mask

"""The plan of a study: its points, the scene of each, what is measured, and in which tasks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.scene.scene import Scene
from warp_rods.scene.sweep import ENSEMBLES, Path, SweepTable, located, replaced
from warp_rods.studies.axes import Axis, axes_of
from warp_rods.studies.columns import Column
from warp_rods.studies.summaries import OF_SETTLED, Summary, summary_of
from warp_rods.values import plain, shown

__all__ = ["Index", "Plan", "Wanted"]

MOST_CHECKED = 200
"""Values of an axis that are checked before a study begins; an impossible one among others fails by itself."""
LIST_THEM = "; list the values, such as [17, 25, 33], or give a linear range whose values are all whole numbers"
USED = frozenset({"status", "length", "power", "steric_energy", "arc_length", "activity"})
"""Variables that measures take into account where an ensemble has them, though they do without."""
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
        axes = tuple(map(self._in_scene_units, axes_of(self.scene)))
        return tuple(sorted(axes, key=lambda axis: self.order.index(axis.key))) if self.order else axes

    def _in_scene_units(self, axis: Axis) -> Axis:
        """An axis on which quantities, as "500 nm", are numbers; raises SceneError where two of them are the same."""
        if not any(isinstance(value, str) for value in axis.values):
            return axis
        values = tuple(self._number(axis.key, value) if isinstance(value, str) else value for value in axis.values)
        for i, value in enumerate(values):
            if value in values[:i]:
                same = ", ".join(shown(axis.values[k]) for k in (values.index(value), i))
                raise SceneError(f'sweep."{axis.key}": {same} are the same: each value must be there once')
        return replace(axis, values=values)

    def _number(self, key: str, value: str) -> Any:
        """What a value in quotes is in units of the scene; itself where it is no quantity, or not possible."""
        try:
            path = located(self.tables, key)
            found: Any = plain(Scene.parse(replaced(self.tables, path, value)).model_dump())
        except (KeyError, SceneError):
            return value
        for step in path:
            found = found[step]
        return found if isinstance(found, (int, float)) and not isinstance(found, bool) else value

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
        *axes, seeds = self.axes
        sizes = [f"{axis.first} {axis.key}" for axis in axes] + [f"{len(seeds)} seed{'s' * (len(seeds) > 1)}"]
        return f"{self.first_points} points ({' × '.join(sizes)}){f', {self.refined}' if self.levels else ''}"

    @property
    def refined(self) -> str:
        """How often the grid is refined, in words."""
        return f"refined {({1: 'once', 2: 'twice'}).get(self.levels, f'{self.levels} times')}"

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
                    advice = self._advice(number, str(error))
                    lines.append(f'sweep."{axis.key}" = {shown(axis.values[i])}: {error}{advice}')
                    break
        _ = self.wanted
        if lines:
            raise SceneError("\n".join(lines))

    def _advice(self, number: int, error: str) -> str:
        """What to try where a value of an axis is not possible."""
        axis = self.axes[number]
        here: Any = self.tables
        if axis.scale != "list" and "whole number" in error:
            return LIST_THEM
        for step in self.paths[number]:
            here = here.get(step) if isinstance(here, dict) else here[step]
        is_one = axis.numeric and isinstance(here, tuple) and len(here) > 1
        return f"\n  one of its numbers is swept by its place, from 0: did you mean {axis.key}.1?" if is_one else ""

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
    def needs(self) -> frozenset[str]:
        """Variables of the trajectory that the measures need, or take into account where they are there."""
        kinds = [kind for kind in ENSEMBLES if getattr(self.scene, kind)]
        return USED.union(*(w.variables for w in self.wanted), *(OF_SETTLED[kind] for kind in kinds))

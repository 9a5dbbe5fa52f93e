"""The table [[filaments]] of a scene."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from warp_rods.errors import SceneError
from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.components import OR_COMPONENTS, DragAlong, StiffnessAlong, StrainsAlong
from warp_rods.scene.ensemble import AUTO, MOST_NODES, EnsembleTable, OrAuto, length_faults, lookup
from warp_rods.scene.parameters import ParametersEach, names_of
from warp_rods.scene.per_rod import (
    OR_EACH,
    Direction,
    Each,
    EachVector,
    NumberEach,
    PositiveEach,
    Vector,
    WordOrTable,
    ZeroOrMoreEach,
    is_list,
)
from warp_rods.scene.shapes import FilamentShape, FormulaText, each_of_start
from warp_rods.values import Positive, ZeroOrMore, shown

__all__ = ["FilamentsTable", "GrowthTable", "Placement"]


class Placement(Table):
    """Initial positions of filaments: points, directions [rod, 3], geodesic curvature [rod, node] in 1/length."""

    at: Literal["middle", "start"] = Field(
        default="middle",
        title="where on the filament its position is",
        description='"middle" or "start": which point of the rod is placed',
    )
    position: tuple[Vector, ...] = Field(
        title="places of the filaments, put onto the membrane (length)",
        description="a list of points [x, y, z], one for each rod",
    )
    direction: tuple[Direction, ...] = Field(
        title="directions of the tangent there", description="a list of directions [dx, dy, dz], one for each rod"
    )
    geodesic_curvature: WordOrTable[FormulaText, Each[NumberEach]] = Field(
        default=0.0,
        title="geodesic curvature Ω along the filament at the start (1/length)",
        description="a number, a formula of s, or a list that has for each rod a number or a list with one for each "
        "node",
    )


MOST_STIFFER = 1e10
"""The largest ratio of two stiffnesses of a filament."""
NO_TIP = ': filaments grow at free tips, and ends = ["clamped", "clamped"] has none: free one end, or leave growth out'
"""The fault of a growth without a free tip."""


class GrowthTable(Table):
    """Growth at the tips, at a rate (length per time) until a final length, or to given lengths at given times."""

    rate: PositiveEach | None = Field(
        default=None, title="rate dL/dt at which the tips grow (length/time)", description="a positive number" + OR_EACH
    )
    until: PositiveEach | None = Field(
        default=None, title="length L at which growth ends", description="a positive number" + OR_EACH
    )
    start: ZeroOrMoreEach | None = Field(
        default=None,
        title="time at which growth begins; 0 if left out",
        description="0 or a positive number" + OR_EACH,
    )
    time: EachVector[tuple[ZeroOrMore, ...]] | None = Field(
        default=None,
        title="times at which the length is given, in place of rate and until",
        description="a list of increasing times, together with length" + OR_EACH,
    )
    length: EachVector[tuple[Positive, ...]] | None = Field(
        default=None,
        title="length L at each of the times",
        description="a list of lengths that do not decrease, one for each time in time" + OR_EACH,
    )
    spacing: Positive | None = Field(
        default=None,
        title="largest spacing Δs of the nodes (length)",
        description="a positive number: the number of nodes is doubled before Δs exceeds it",
    )

    @property
    def largest_spacing(self) -> float:
        """``spacing``, or infinity."""
        return math.inf if self.spacing is None else self.spacing

    @classmethod
    def none(cls) -> GrowthTable:
        """No growth."""
        return cls.model_construct()

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        if raw.keys() & cls.model_fields.keys() - {"spacing", "start"} not in ({"rate", "until"}, {"time", "length"}):
            return [fault((), raw, ": must be { rate, until } or { time, length }; start and spacing may be added")]
        if "time" not in good or "length" not in good:
            return []
        time, length = good["time"], good["length"]
        found = []
        if not _rises(time, lambda a, b: a < b):
            found.append(fault(("time",), time, f" = {shown(time)}: must be increasing times"))
        if not _rises(length, lambda a, b: a <= b):
            text = f" = {shown(length)}: must be lengths that do not decrease"
            found.append(fault(("length",), length, text))
        if not found and len({len(row) for row in (*_rows(time), *_rows(length))}) > 1:
            found.append(fault(("length",), length, f" = {shown(length)}: needs one length for each time in time"))
        return found


def _rows(values: tuple) -> tuple[tuple[Any, ...], ...]:
    """The lists of numbers, of which there may be one for each rod."""
    return values if values and is_list(values[0]) else (values,)


def _rises(values: tuple, ordered: Callable[[float, float], bool]) -> bool:
    """Whether there are numbers, and they are in this order, in each list."""
    return all(len(row) > 0 and all(itertools.starmap(ordered, itertools.pairwise(row))) for row in _rows(values))


class FilamentsTable(EnsembleTable):
    """An ensemble of filaments bound to the surface (chapter 5)."""

    FEWEST_NODES: ClassVar[int] = 9

    nodes: OrAuto[Annotated[int, Field(ge=FEWEST_NODES, le=MOST_NODES)]] = Field(
        title='number of nodes along each rod; "auto" for as many as 1 % needs',
        description='a whole number, 9 or more, at most 100 000, or "auto"',
    )
    length: PositiveEach | None = Field(
        default=None,
        title="length L at the start; that of the shape if left out",
        description="a positive number" + OR_EACH,
    )
    stiffness: StiffnessAlong = Field(
        title="stiffnesses B1, B2, B3 (force·length²)",
        description="3 positive numbers (twist, normal bending, geodesic bending)" + OR_COMPONENTS,
    )
    intrinsic: StrainsAlong = Field(
        default=(0.0, 0.0, 0.0),
        title="preferred strains σ1, σ2, σ3 (1/length); σ2 > 0 prefers convex membrane",
        description="3 numbers (twist, normal curvature, geodesic curvature)" + OR_COMPONENTS,
    )
    drag: DragAlong = Field(
        title="drags ζ∥, ζ⊥ (force·time/length²) and ζr (force·time)",
        description="3 numbers (along > 0, across > 0, rotational 0 or more)" + OR_COMPONENTS,
    )
    parameters: ParametersEach | None = Field(
        default=None,
        title="names of numbers for the formulas of this table",
        description="a table of numbers by name, such as { k = 7.0 }, for formulas" + OR_EACH,
    )
    ends: tuple[Literal["free", "clamped"], Literal["free", "clamped"]] = Field(
        default=("free", "free"),
        title="first and last end; a clamped one is a nucleation site",
        description='a pair such as ["free", "free"], each "free" or "clamped"',
    )
    placement: WordOrTable[Literal["random"], Placement] | None = Field(
        default=None,
        title="where filaments start; random if left out, unless a shape says it",
        description='"random" or a table { at, position, direction, geodesic_curvature }',
    )
    shape: FilamentShape | None = Field(
        default=None,
        title="centre lines at the start, measured or from a run",
        description="a table { points, … } or { run, … }, which also says where they are",
    )
    growth: GrowthTable | None = Field(
        default=None,
        title="growth at the free tips; none if left out",
        description="a table { rate, until } or { time, length }",
    )
    bodies: tuple[Annotated[int, Field(ge=0)], ...] | None = Field(
        default=None,
        min_length=1,
        title="which bodies carry filaments with random placement; all if left out",
        description="a list of whole numbers, 0 or more: bodies of the membrane, as warp-rods check lists them",
    )

    @property
    def known_length(self) -> float | tuple[float, ...]:
        """``length``, known once the scene is laid out; raises SceneError where it is still to be read from a file."""
        if self.length is None:
            raise SceneError("length: must be a number here; that of the shape is known once the scene is laid out")
        return self.length

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        """The table with random placement where neither a placement nor a shape says where filaments are."""
        return data if "shape" in data else {"placement": "random", **data}

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        placement = tuple("placement." + key for key in ("position", "direction", "geodesic_curvature"))
        named = tuple(f"parameters.{name}" for name in names_of(raw))
        return [
            *length_faults(
                raw,
                good,
                ("length", "growth.rate", "growth.until", "growth.start", *placement, *named),
                vectors=("stiffness", "intrinsic", "drag", "growth.time", "growth.length"),
            ),
            *_node_faults(raw, good),
            *_stiffness_faults(good),
            *_along_faults(good),
            *_tip_faults(raw, good),
            *_body_faults(good),
            *_start_faults(raw, good),
            *each_of_start(raw, good),
        ]


def _stiffness_faults(good: dict[str, Any]) -> Faults:
    """Stiffnesses so different that round-off of the larger hides the smaller, and no step is short enough."""
    for row in _rows(good.get("stiffness", ())):
        numbers = [n for part in row for n in _numbers(part)]
        if numbers and max(numbers) > MOST_STIFFER * min(numbers):
            ratio = max(numbers) / min(numbers)
            text = f" = {shown(row)}: one is {ratio:.3g} times another; at most {MOST_STIFFER:g} times"
            return [fault(("stiffness",), row, text)]
    return []


def _numbers(component: Any) -> tuple[float, ...]:
    """The numbers of a component, as given: a number, a formula, or a table { nodes }."""
    if isinstance(component, dict):
        return component["nodes"]
    return () if isinstance(component, str) else (component,)


def _along_faults(good: dict[str, Any]) -> Faults:
    """Components that are given at nodes, but not at all."""
    nodes, found = good.get("nodes"), []
    for name in ("stiffness", "intrinsic", "drag"):
        given = {len(part["nodes"]) for row in _rows(good.get(name, ())) for part in row if isinstance(part, dict)}
        if nodes == AUTO and given:
            text = f': values at nodes need their number in place of nodes = "{AUTO}"'
            found.append(fault((name,), good[name], text))
        elif nodes is not None and given - {nodes}:
            count = min(given - {nodes})
            found.append(fault((name,), good[name], f": has {count} values at nodes; needs one for each of {nodes}"))
    return found


def _tip_faults(raw: dict[str, Any], good: dict[str, Any]) -> Faults:
    """Growth of filaments that have no free tip."""
    if good.get("ends") != ("clamped", "clamped") or raw.get("growth") is None:
        return []
    return [fault(("growth",), raw["growth"], NO_TIP)]


def _body_faults(good: dict[str, Any]) -> Faults:
    if good.get("bodies") is None or ("shape" not in good and isinstance(good.get("placement", "random"), str)):
        return []
    text = f" = {shown(good['bodies'])}: is for random placement; given positions are on the body nearest to them"
    return [fault(("bodies",), good["bodies"], text)]


def _start_faults(raw: dict[str, Any], good: dict[str, Any]) -> Faults:
    """Filaments without a length, and those whose place is given twice."""
    if "shape" not in raw:
        missing = ": missing; must be a positive number, or a list with one for each rod"
        return [fault(("length",), raw, missing)] if "length" not in raw else []
    if "length" in good and isinstance(good.get("shape"), dict) and "run" in good["shape"]:
        text = f" = {shown(good['length'])}: filaments of a run have their length; leave it out"
        return [fault(("length",), good["length"], text)]
    if "placement" in good:
        text = f" = {shown(good['placement'])}: shape says where the filaments are: leave one of them out"
        return [fault(("placement",), good["placement"], text)]
    return []


def _node_faults(raw: dict[str, Any], good: dict[str, Any]) -> Faults:
    rows = lookup(raw, ("placement", "geodesic_curvature"))
    nodes = good.get("nodes")
    if nodes is None or not is_list(rows):
        return []
    needs = f"needs one value for each of {nodes} nodes"
    if nodes == AUTO:
        needs = f'a value for each node needs their number in place of nodes = "{AUTO}"'
    return [
        fault(("placement", "geodesic_curvature", i), values, f" = {shown(values)}: {needs}, has {len(values)}")
        for i, values in enumerate(rows)
        if is_list(values) and len(values) != nodes
    ]

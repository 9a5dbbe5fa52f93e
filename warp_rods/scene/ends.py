"""The ends of free rods in a scene."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag

from warp_rods.centrelines.table import read_motion
from warp_rods.centrelines.track import TrackError
from warp_rods.scene.along import checked_formula
from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.per_rod import EACH, OR_EACH, TABLE, NumberEach, Vector, WordOrTable
from warp_rods.values import Number, plain, shown

__all__ = ["OF_KIND", "EndOrKind", "EndTable", "MotionTable"]

Kind = Literal["free", "hinged", "clamped"]
OF_KIND = {
    "free": ("thrust", "torque", "force", "couple"),
    "hinged": ("torque", "couple", "motion"),
    "clamped": ("turning", "motion", "rotation"),
}
"""What an end of each kind may have."""


NumberOrFormula = Number | Annotated[str, AfterValidator(checked_formula("t"))]
Motion = tuple[NumberOrFormula, NumberOrFormula, NumberOrFormula]


FEWEST_TIMES, MOST_TIMES = 4, 100_000
CLOSED = 1e-9
"""The share of the largest coordinate by which the ends of a periodic table may differ: round-off."""


class MotionTable(Table):
    """How an end moves: times, and a vector at each, with a smooth curve between them. A file is read at once."""

    file: str | None = Field(
        default=None,
        title="table of the motion, in units of the scene",
        description="the path of a file with columns t, x, y, z (.csv, .tsv, .txt, .dat, .npy), in quotes",
    )
    times: tuple[Number, ...] | None = Field(
        default=None,
        min_length=FEWEST_TIMES,
        max_length=MOST_TIMES,
        title="times of the points, with a smooth curve between them",
        description="a list of 4 or more increasing times, the first at or before 0",
    )
    points: tuple[Vector, ...] | None = Field(
        default=None,
        title="displacement of the end (length) or its rotation vector (radians)",
        description="a list of points [x, y, z], one for each time",
    )
    periodic: bool = Field(
        default=False,
        title="what follows the last of the times",
        description="true or false: whether the motion is repeated",
    )

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        """The table with the numbers of its file, which is not needed any more."""
        if not isinstance(data.get("file"), str) or data.keys() & {"times", "points"}:
            return data
        try:
            found = read_motion(Path(data["file"]))
        except (OSError, TrackError, ValueError):
            return data
        return {**{key: value for key, value in data.items() if key != "file"}, **plain(found)}

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        if "file" in raw:
            return _file_faults(raw)
        if missing := {"times", "points"} - raw.keys():
            return [fault((), raw, f": {' and '.join(sorted(missing))}: missing; give times and points, or a file")]
        if not {"times", "points"} <= good.keys():
            return []
        times, points = np.array(good["times"]), good["points"]
        if len(points) != len(times):
            return [fault(("points",), points, f": has {len(points)} points; needs one for each of {len(times)} times")]
        if not (np.diff(times) > 0).all() or times[0] > 0:
            words = cls.model_fields["times"].description
            return [fault(("times",), times, f" = {shown(good['times'])}: must be {words}")]
        if (
            good.get("periodic")
            and abs(np.subtract(points[0], points[-1])).max() > CLOSED * abs(np.array(points)).max()
        ):
            text = f": the first and the last must be equal where periodic = true, and are {points[0]} and {points[-1]}"
            return [fault(("points",), points, text)]
        return []


def _file_faults(raw: dict[str, Any]) -> Faults:
    """What is wrong with a file whose numbers could not be read."""
    path = raw["file"]
    if both := sorted(raw.keys() & {"times", "points"}):
        return [fault(("file",), path, f" = {shown(path)}: has what {' and '.join(both)} say: leave one of them out")]
    if not isinstance(path, str):
        return []
    try:
        read_motion(Path(path))
    except FileNotFoundError:
        where = "(relative paths in a scene file start at the folder of the scene)"
        return [fault(("file",), path, f": there is no file {path} {where}")]
    except OSError as error:
        return [fault(("file",), path, f" = {shown(path)}: cannot be read: {error.strerror or error}")]
    except (TrackError, ValueError) as error:
        return [fault(("file",), path, f": {path} {error}")]
    return []


def _motion(value: Any) -> str:
    return TABLE if isinstance(value, (dict, MotionTable)) else EACH


MotionOrTable = Annotated[Annotated[Motion, Tag(EACH)] | Annotated[MotionTable, Tag(TABLE)], Discriminator(_motion)]
OR_TABLE = ", or a table { times, points } or { file }"


class EndTable(Table):
    """One end of free rods: what holds it, and what moves or loads it."""

    kind: Kind = Field(
        default="free",
        title="whether nothing is held, the place, or the place and the direction",
        description='"free", "hinged" or "clamped"',
    )
    thrust: NumberEach | None = Field(
        default=None,
        title="load on a free end that turns with the rod (f*L)",
        description="a number" + OR_EACH + ": a force along the tangent",
    )
    torque: NumberEach | None = Field(
        default=None,
        title="load on a free or hinged end that turns with the rod (f*L²)",
        description="a number" + OR_EACH + ": a couple about the tangent",
    )
    turning: NumberEach | None = Field(
        default=None,
        title="rate at which a clamped end is turned (f*/ζ∥L)",
        description="a number" + OR_EACH + ": a rate about the tangent",
    )
    force: Vector | None = Field(
        default=None, title="load on a free end (f*L)", description="a force [x, y, z] in space"
    )
    couple: Vector | None = Field(
        default=None, title="load on a free or hinged end (f*L²)", description="a couple [x, y, z] in space"
    )
    motion: MotionOrTable | None = Field(
        default=None,
        title="where a held end is, counted from its place at t = 0 (L)",
        description="a displacement of three numbers or formulas in t" + OR_TABLE,
    )
    rotation: MotionOrTable | None = Field(
        default=None,
        title="how a clamped end is turned, counted from t = 0 (radians)",
        description="a rotation vector of three numbers or formulas in t" + OR_TABLE,
    )

    @property
    def until(self) -> float:
        """The time until which tables of its motion go; infinite where there is none."""
        tables = [part for part in (self.motion, self.rotation) if isinstance(part, MotionTable)]
        return min([t.times[-1] for t in tables if t.times and not t.periodic], default=math.inf)

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        kind = good.get("kind", "free" if "kind" not in raw else None)
        return [
            fault((key,), raw[key], f": a {kind} end has no {key}; it may have {', '.join(OF_KIND[kind])}")
            for key in good
            if kind in OF_KIND and key != "kind" and key not in OF_KIND[kind]
        ]


EndOrKind = WordOrTable[Kind, EndTable]


def given_end(end: Kind | EndTable) -> Any:
    """An end as the ensembles of rods take it."""
    return end.model_dump(exclude_none=True) if isinstance(end, EndTable) else end

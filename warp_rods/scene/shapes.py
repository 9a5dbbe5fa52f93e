"""The table ``shape`` of an ensemble: what its rods look like at the start. One row of ``SHAPES`` for each kind."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from warp_rods.centrelines.curve import DEFAULT, check_smoothing
from warp_rods.centrelines.readers import READERS, suffix_of
from warp_rods.errors import SceneError
from warp_rods.formula import FormulaError, function_of_arc_length
from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.ensemble import MOST_NODES, length_faults
from warp_rods.scene.parameters import known_names, use
from warp_rods.scene.per_rod import OR_EACH, Each, NumberEach, WordOrTable, ZeroOrMoreEach, is_list
from warp_rods.values import Number, Positive, shown

__all__ = ["FILAMENT_SHAPES", "KEPT", "SHAPES", "FilamentShape", "FormulaText", "Kind", "ShapeTable", "kind_of"]

KEPT = ".npz"
"""The suffix of starts that a run or ``wr.steady`` kept."""


@dataclass(frozen=True)
class Kind:
    """A kind of shape: what it is, its keys with defaults (None: left out), and those by which it is recognised."""

    words: str
    keys: Mapping[str, Any]
    marks: tuple[str, ...] = ()
    own_rods: bool = field(default=False)
    """Whether it is read from a file, so that the shape has its own place."""


_POINTS = {"smoothing": DEFAULT, "reverse": False, "frame": None, "time": None, "worm": None, "branch": None}
_RUN = {"frame": None, "time": None, "ensemble": None, "rod": None}
SHAPES: dict[str, Kind] = {
    "mode": Kind("a beam mode times an amplitude", {"amplitude": 1.0, "mode": 0}),
    "writhe": Kind("coiled, (C.63) to (C.66)", {"amplitude": 1.0, "balanced": True}),
    "straight": Kind("straight", {"amplitude": 1.0}),
    "formula": Kind(
        "strains as formulas of s times an amplitude",
        {"amplitude": 1.0, "bend": None, "bend1": None, "bend2": None, "twist": None},
        marks=("bend", "bend1", "bend2", "twist"),
    ),
    "points": Kind("a measured centre line", {"points": None, **_POINTS}, marks=("points",), own_rods=True),
    "run": Kind("rods of a run at a frame", {"run": None, **_RUN}, marks=("run",), own_rods=True),
}
"""Kinds of shape of swimmers, by ``kind``. Their functions are in ``rods/free/shapes.py`` and ``simulation/starts``."""
FILAMENT_SHAPES: dict[str, Kind] = {
    name: Kind(SHAPES[name].words, {**SHAPES[name].keys, **more}, SHAPES[name].marks, True)
    for name, more in {"points": {"scale": None}, "run": {}}.items()
}
"""Kinds of shape of filaments, which also say where they are."""


def kind_of(data: Mapping[str, Any], kinds: Mapping[str, Kind]) -> Any:
    """The kind of a table: as given, or by the keys that only one kind has; else the first one."""
    given = data.get("kind")
    return given or next((name for name, row in kinds.items() if data.keys() & set(row.marks)), next(iter(kinds)))


def _formula(text: str) -> str:
    try:
        use(function_of_arc_length(text, known_names()).names)  # type: ignore[attr-defined]
    except FormulaError as error:
        raise PydanticCustomError("note", "{text}", {"text": str(error)}) from None
    return text


def _smoothing(value: Any) -> Any:
    try:
        check_smoothing(value)
    except SceneError:
        raise ValueError("smoothing") from None
    return value


FormulaText = Annotated[str, AfterValidator(_formula)]
Formula = WordOrTable[FormulaText, Number]
Smoothing = Annotated[WordOrTable[str, Number], AfterValidator(_smoothing)]
Whole = Each[Annotated[int, Field(ge=0)]]
FORMULA = 'a formula of s in quotes, such as "3*sin(2*pi*s)", or a number'


class Start(Table):
    """What shapes of all rods have: those of a measured centre line, or of a run."""

    KINDS: ClassVar[Mapping[str, Kind]]

    points: Each[str] | None = Field(
        default=None,
        title="measured centre line, whose points are in order along it",
        description=f"the path of a file of points ({', '.join(READERS)}), in quotes{OR_EACH}",
    )
    smoothing: Smoothing | None = Field(
        default=None,
        title='smoothing of the centre line (length); "4 points" if left out',
        description='a number, 0 or more: the wavelength that is halved; or a number of points, such as "4 points"',
    )
    reverse: bool | None = Field(
        default=None,
        title="direction in which the points are taken",
        description="true or false: whether the rod begins at the last point",
    )
    frame: Each[int] | None = Field(
        default=None,
        title="which line of a file, or frame of a run; the last of a run if left out",
        description="a whole number: which frame, from the end where it is negative" + OR_EACH,
    )
    time: NumberEach | None = Field(
        default=None,
        title="time at which the line or frame is chosen, in place of frame",
        description="a number: the time of the frame" + OR_EACH,
    )
    worm: Each[WordOrTable[str, int]] | None = Field(
        default=None, title="worm of a file of midlines (WCON)", description="the id of a worm" + OR_EACH
    )
    branch: Whole | None = Field(
        default=None,
        title="path in a traced tree (SWC)",
        description="a whole number: the id of the tip of a path" + OR_EACH,
    )
    run: str | None = Field(
        default=None,
        title="run whose rods are taken at a frame, with twist and activity",
        description="the path of a run folder, in quotes",
    )
    ensemble: str | None = Field(
        default=None,
        title="where the rods of a run are; the one of this name, or the only one, if left out",
        description="the name of an ensemble of the run, in quotes",
    )
    rod: Whole | None = Field(
        default=None,
        title="rod of the run; each takes the one of its own number if left out",
        description="a whole number, 0 or more: which rod of the run" + OR_EACH,
    )

    @property
    def from_file(self) -> bool:
        """Whether a file has the shape, and the place where none is given."""
        return self.points is not None or self.run is not None

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        kind = kind_of(data, cls.KINDS)
        if not isinstance(kind, str) or kind not in cls.KINDS:
            return data
        defaults = {key: value for key, value in cls.KINDS[kind].keys.items() if value is not None}
        return {"kind": kind, **defaults, **data}

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        kind = good.get("kind")
        if not isinstance(kind, str) or kind not in cls.KINDS:
            return []
        row = cls.KINDS[kind]
        faults = [
            fault((key,), raw[key], f": a shape of kind {kind} has no {key}; leave it out")
            for key in good
            if key in cls.model_fields and key not in (*row.keys, "kind", "perturbation")
        ]
        if row.marks and not raw.keys() & set(row.marks):
            faults.append(fault((), raw, f": a shape of kind {kind} needs {' or '.join(row.marks)}"))
        return faults + _file_faults(good) + _choice_faults(good)


def _file_faults(good: dict[str, Any]) -> Faults:
    """Files and folders that are not there, or whose suffix is unknown."""
    faults: Faults = []
    paths = good.get("points") or ()
    where = "(relative paths in a scene file start at the folder of the scene)"
    for index, path in enumerate(paths if is_list(paths) else [paths]):
        loc = ("points", index) if is_list(paths) else ("points",)
        if suffix_of(Path(path)) is None and Path(path).suffix != KEPT:
            faults.append(fault(loc, path, f" = {shown(path)}: must end in one of {', '.join(READERS)}"))
        elif not Path(path).is_file():
            faults.append(fault(loc, path, f": there is no file {path} {where}"))
    run = good.get("run")
    if run is not None and not (Path(run).is_file() if Path(run).suffix == KEPT else Path(run).is_dir()):
        faults.append(fault(("run",), run, f": there is no run folder {run} {where}"))
    return faults


def _choice_faults(good: dict[str, Any]) -> Faults:
    """Two keys that mean the same."""
    pairs = {("frame", "time"): "the frame", ("bend", "bend2"): "bending in the plane of the modes, Ω₂"}
    return [
        fault((second,), good[second], f": {first} and {second} both give {what}; leave one of them out")
        for (first, second), what in pairs.items()
        if first in good and second in good
    ]


EACH_OF_START = tuple(f"shape.{key}" for key in ("points", "frame", "time", "worm", "branch", "rod"))
"""Keys that may have one value per rod."""


class ShapeTable(Start):
    """The shape of swimmers at the start: a beam mode, the writhe, straight, formulas, measured, or of a run."""

    KINDS: ClassVar[Mapping[str, Kind]] = SHAPES

    kind: Literal["mode", "writhe", "straight", "formula", "points", "run"] = Field(
        default="mode",
        title="what the shape at the start is made of",
        description="one of " + ", ".join(f'"{name}"' for name in SHAPES),
    )
    mode: int | None = Field(
        default=None,
        ge=0,
        le=MOST_NODES // 2,
        title="number of the beam mode; 0, the lowest, if left out",
        description="a whole number, 0 or more, at most 50 000",
    )
    amplitude: NumberEach | None = Field(
        default=None,
        title="amplitude A of the beam mode or writhe, or factor of the formulas; 1 if left out",
        description="a number" + OR_EACH,
    )
    bend: Formula | None = Field(
        default=None, title="bending at the start (1/L)", description=FORMULA + ": another name of bend2"
    )
    bend1: Formula | None = Field(
        default=None,
        title="bending about the second director at the start (1/L)",
        description=FORMULA + ": Ω₁, bending across the plane of the modes",
    )
    bend2: Formula | None = Field(
        default=None,
        title="bending about the third director at the start (1/L)",
        description=FORMULA + ": Ω₂, bending in the plane of the modes",
    )
    twist: Formula | None = Field(default=None, title="twist at the start (1/L)", description=FORMULA + ": Ω₀")
    perturbation: ZeroOrMoreEach | None = Field(
        default=None,
        title="random bending added at the start, in the first six beam modes",
        description="0 or a positive number" + OR_EACH + ": the size of a random bending, by the seed of the scene",
    )
    balanced: bool | None = Field(
        default=None,
        title="what twist a coiled rod has at the start",
        description="true or false: whether the twist of a writhe balances the active torque, or is (C.63) as printed",
    )


class FilamentShape(Start):
    """The shape and place of filaments at the start: a measured centre line on the membrane, or filaments of a run."""

    KINDS: ClassVar[Mapping[str, Kind]] = FILAMENT_SHAPES

    kind: Literal["points", "run"] = Field(
        title="what the shape at the start is made of", description='"points" or "run"'
    )
    scale: Positive | None = Field(
        default=None,
        title="unit of the points (length); that of the file if left out",
        description="a positive number: what one unit of the points is, in units of the scene",
    )


def each_of_start(raw: dict[str, Any], good: dict[str, Any]) -> Faults:
    """Faults of lists in a shape without one entry for each rod."""
    return length_faults(raw, good, EACH_OF_START)

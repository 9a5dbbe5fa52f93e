"""The table [sweep] of a scene: which of its values are swept, how often each point is repeated, what is measured."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Discriminator, Field, Tag

from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.per_rod import EACH, ONE, is_list
from warp_rods.values import Number, Positive, nearest, number, shown

__all__ = ["ENSEMBLES", "SCALES", "SweepTable", "located", "replaced", "sweep_faults"]

ENSEMBLES = ("filaments", "swimmers", "cosserat")
"""The tables of ensembles, whose keys in a sweep begin with the kind and the name: ``swimmers.cell.bend``."""
NOT_SWEPT = {"seed": "give seeds", "sweep": "", "output": "", "title": "", "units": "", "on_failure": ""}
"""Keys of a scene that are not swept, and what to try."""
NAME = "name"
"""Of an ensemble: a label, by which the keys of a sweep call it."""
SCALES = ("linear", "log")
MOST_VALUES = 100_000
"""Values of a key, at most."""
MOST_PLACES = 2e7
"""Places of the grid at most: the state of each is looked at when a study goes on."""
WHAT = 'a list of values, or { from = 1e-4, to = 1e-2, num = 20, scale = "log" }'

Path = tuple[str | int, ...]
Seed = Annotated[int, Field(ge=0, lt=2**63)]


class SweepTable(Table):
    """The swept keys, each with a list of values or a range, and what is done at each point.

    A range is { from, to, num } with equal distances, or with scale = "log" equal ratios.
    """

    model_config = ConfigDict(extra="allow")

    seeds: Annotated[
        Annotated[int, Field(ge=1, le=MOST_VALUES), Tag(ONE)]
        | Annotated[tuple[Seed, ...], Field(min_length=1), Tag(EACH)],
        Discriminator(lambda value: EACH if is_list(value) else ONE),
    ] = Field(
        default=1,
        title="random starts of each point, how many or which",
        description="a whole number of seeds, 1 or more, or a list of seeds",
    )
    measure: Annotated[tuple[str, ...], Field(min_length=1)] = Field(
        title="what is measured at each point of the study",
        description='a list of names of measures in quotes, such as ["speed", "class"]',
    )
    keep: Literal["summary", "trajectory"] = Field(
        default="summary",
        title="whether a point leaves its measures only, or is a run with a folder",
        description='"summary" or "trajectory"',
    )
    refine: Annotated[int, Field(ge=0, le=8)] = Field(
        default=0,
        title="rounds of refinement, in which points are added",
        description="a whole number from 0 to 8: how often ranges are halved where neighbours differ",
    )

    @property
    def axes(self) -> dict[str, Any]:
        """The swept keys, each with a tuple of values or a range."""
        return dict(self.model_extra or {})

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        axes = {key: value for key, value in raw.items() if key not in cls.model_fields}
        faults = [fault((key,), value, text) for key, value in axes.items() if (text := _fault_of(key, value))]
        if not axes and raw.get("seeds", 1) in (1, None):
            faults.append(fault((), raw, f': nothing is swept: add a key such as "swimmers.cell.bend" with {WHAT}'))
        if good.get("refine") and not any(isinstance(value, dict) for value in axes.values()):
            text = f" = {good['refine']}: only ranges are refined, and every key has a list: give {{ from, to, num }}"
            faults.append(fault(("refine",), good["refine"], text))
        seeds = good.get("seeds", 1)
        if is_list(seeds) and len(set(seeds)) < len(seeds):
            faults.append(fault(("seeds",), seeds, f" = {shown(seeds)}: each seed must be there once"))
        measures = good.get("measure", ())
        for i, name in enumerate(measures):
            if name in measures[:i]:
                faults.append(fault(("measure", i), name, f" = {shown(name)}: is there twice: name each measure once"))
        if not faults and (size := _places(axes, seeds, good.get("refine", 0))) > MOST_PLACES:
            text = f": a grid with {size:.3g} places, refined ones included, at most {MOST_PLACES:.3g}"
            faults.append(fault((), raw, f"{text}: give fewer values, or refine less often"))
        return faults


def _places(axes: Mapping[str, Any], seeds: Any, refine: Any) -> float:
    """The number of places of the grid, those of points that a refinement may add included."""
    sizes = [(value["num"] - 1) * 2**refine + 1 if isinstance(value, dict) else len(value) for value in axes.values()]
    return math.prod(map(float, sizes)) * (len(seeds) if is_list(seeds) else seeds or 1)


def _fault_of(key: str, value: Any) -> str:
    """What is wrong with the values of a swept key; empty where nothing is."""
    if "." not in key:
        known = list(SweepTable.model_fields)
        return f": unknown key{nearest(key, known)}; known here: {', '.join(known)}, and keys of the scene with dots"
    if is_list(value):
        if not 1 <= len(value) <= MOST_VALUES:
            return f" = {shown(value)}: must be {WHAT}, with 1 to {MOST_VALUES} values"
        twice = _repeated(value)
        return twice and f" = {shown(value)}: each value must be there once, and {twice} is there again"
    return _fault_of_range(value) if isinstance(value, dict) else f" = {shown(value)}: must be {WHAT}"


def _repeated(values: tuple[Any, ...]) -> str:
    """The first value that equals one before it, in words; empty where none does."""
    seen = set()
    for value in values:
        if (key := _hashable(value)) in seen:
            return shown(value)
        seen.add(key)
    return ""


def _hashable(value: Any) -> Any:
    """The same for equal values: 1 and 1.0, but not 1 and true."""
    if isinstance(value, Mapping):
        return frozenset((key, _hashable(part)) for key, part in value.items())
    return tuple(map(_hashable, value)) if is_list(value) else (isinstance(value, bool), value)


def _fault_of_range(value: Mapping[str, Any]) -> str:
    """What is wrong with a range; empty where nothing is."""
    log = value.get("scale", "linear") == "log"
    try:
        ends = [number(value[name], Positive if log else Number) for name in ("from", "to")]
        whole = isinstance(value["num"], int) and not isinstance(value["num"], bool)
        right = whole and 2 <= value["num"] <= MOST_VALUES and ends[0] != ends[1]
    except (KeyError, ValueError):
        right = False
    if right and value.keys() <= {"from", "to", "num", "scale"} and value.get("scale", "linear") in SCALES:
        return ""
    ends_of = f"from and to two different {'positive ' if log else ''}numbers in units of the scene"
    rules = f"{ends_of}, num a whole number from 2 to {MOST_VALUES}"
    return f' = {shown(dict(value))}: must be {WHAT}: {rules}, scale "linear" or "log"'


def sweep_faults(raw: Mapping[str, Any]) -> Faults:
    """Keys of the sweep of a scene (its tables as given) that are not in the scene."""
    table = raw.get("sweep")
    keys = (
        [key for key in table if key not in SweepTable.model_fields and "." in key] if isinstance(table, dict) else []
    )
    found = []
    for key in keys:
        try:
            located(raw, key, filled=False)
        except KeyError as why:
            found.append(fault(("sweep", key), key, f": {why.args[0]}"))
    return found


def located(tables: Mapping[str, Any], key: str, filled: bool = True) -> Path:
    """The path of a swept key in the tables of a scene; raises KeyError, which says what is wrong.

    An ensemble is called by its name, an entry of a list by its number: ``filaments.sensors.intrinsic.1``. filled:
    whether the tables have their defaults; otherwise keys in a table that is left out are not looked at.
    """
    parts = key.split(".")
    head, path, here = parts[0], list[str | int](), tables
    if head in NOT_SWEPT:
        raise KeyError(f"{head} cannot be swept{'; ' * bool(NOT_SWEPT[head])}{NOT_SWEPT[head]}")
    if head in ENSEMBLES:
        path = [head, _number_of(tables, head, parts[1])]
        here, parts = tables[head][path[1]], parts[2:]
        if not parts:
            raise KeyError("is the name of an ensemble: add a key of it, such as .bend")
        if parts == [NAME]:
            raise KeyError("the name of an ensemble cannot be swept; it changes nothing but labels")
    for depth, part in enumerate(parts):
        step, last = _step(here, part), depth == len(parts) - 1
        inside = step in here if isinstance(here, dict) else isinstance(step, int) and step < len(here)
        if not inside and not filled and path and isinstance(here, dict):
            return tuple(path)
        if not inside and not (last and isinstance(here, dict)):
            known = ", ".join(here) if isinstance(here, dict) else f"0 to {len(here) - 1}"
            raise KeyError(
                f"there is no {part} in {'.'.join(key.split('.')[: -len(parts) + depth]) or 'the scene'}: {known}"
            )
        path.append(step)
        if not last:
            here = here[step]  # type: ignore[index]
            if not isinstance(here, (dict, tuple)):
                raise KeyError(f"{part} = {shown(here)} has no parts: the key ends there")
    return tuple(path)


def _number_of(tables: Mapping[str, Any], kind: str, name: str) -> int:
    """The number of the ensemble of a kind with this name; raises KeyError."""
    names = [str(table.get(NAME)) for table in tables.get(kind) or () if isinstance(table, dict)]
    if name not in names:
        what = f"there are {', '.join(names)}" if names else f"the scene has no [[{kind}]]"
        raise KeyError(f"no ensemble {name!r} in {kind}{nearest(name, names)}: {what}")
    return names.index(name)


def _step(here: Any, part: str) -> str | int:
    return int(part) if isinstance(here, tuple) and part.isdecimal() else part


def replaced(tables: Any, path: Path, value: Any) -> Any:
    """The tables of a scene with another value at a path; they share what is not changed."""
    if not path:
        return value
    step, *rest = path
    if isinstance(tables, dict):
        return {**tables, step: replaced(tables.get(step), tuple(rest), value)}
    parts = list(tables)
    parts[step] = replaced(parts[step], tuple(rest), value)  # type: ignore[index]
    return tuple(parts)

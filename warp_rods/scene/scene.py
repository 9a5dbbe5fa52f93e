"""The scene: what a run simulates, read from TOML or defined in Python, and checked."""

from __future__ import annotations

import hashlib
import io
import json
import math
import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import tomli_w
from pydantic import Field, ValidationError

from warp_rods.errors import SceneError
from warp_rods.kernels.contact.cutoff import CUTOFF
from warp_rods.membranes.catalogue import KINDS, motion_faults
from warp_rods.notebook import html_table
from warp_rods.scene.box import ROOMS, Box
from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.cosserat import CosseratTable
from warp_rods.scene.dimensions import UnitFault, in_scene_units
from warp_rods.scene.ends import EndTable
from warp_rods.scene.filaments import FilamentsTable
from warp_rods.scene.flows import FlowTable
from warp_rods.scene.outside import ForceTable, Gravity
from warp_rods.scene.sweep import ENSEMBLES, SweepTable, sweep_faults
from warp_rods.scene.swimmers import SwimmersTable
from warp_rods.scene.tables import Output, Steric, SurfaceTable, Time
from warp_rods.scene.units import Units
from warp_rods.values import key_path, plain, shown

LARGEST_FILE = 100_000_000
"""Bytes of a scene in TOML, at most."""


class Scene(Table):
    """What a run simulates: frozen tables, given as dicts or objects. Raises SceneError with a line for each fault."""

    title: str = Field(
        default="", title="what the run is called in its pictures and files", description="text in quotes"
    )
    seed: int = Field(
        default=0,
        ge=0,
        lt=2**63,
        title="seed of all that is random, such as placement and behaviour",
        description="a whole number from 0 to 2^63 − 1",
    )
    on_failure: Literal["stop", "continue"] | None = Field(
        default=None,
        title="whether the run ends or goes on when a rod is lost; it goes on if left out",
        description='"stop", "continue" or left out',
    )
    surface: SurfaceTable | None = Field(
        default=None, title="membrane φ = 0 on which filaments lie", description="a table, [surface]"
    )
    filaments: tuple[FilamentsTable, ...] = Field(
        default=(), title="ensembles of rods bound to the membrane", description="tables, each under [[filaments]]"
    )
    swimmers: tuple[SwimmersTable, ...] = Field(
        default=(),
        title="ensembles of free active rods, dimensionless by L, f* and ζ∥",
        description="tables, each under [[swimmers]]",
    )
    cosserat: tuple[CosseratTable, ...] = Field(
        default=(),
        title="ensembles of rods that stretch and shear, dimensionless as swimmers",
        description="tables, each under [[cosserat]]",
    )
    box: Box | None = Field(
        default=None, title="region of the swimmers; free space if left out", description="a table, [box]"
    )
    steric: Steric | None = Field(
        default=None,
        title="repulsion between rods; they pass through each other if left out",
        description="a table, [steric]",
    )
    flow: FlowTable | None = Field(
        default=None,
        title="background flow for swimmers and filaments; fluid at rest if left out",
        description="a table, [flow]",
    )
    gravity: Gravity | None = Field(
        default=None,
        title="weight of swimmers and filaments less buoyancy; none if left out",
        description="a table, [gravity]",
    )
    forces: tuple[ForceTable, ...] = Field(
        default=(),
        title="forces and couples from outside on swimmers and filaments",
        description="tables, each under [[forces]]",
    )
    time: Time = Field(
        title="when the run ends, how its steps are chosen, how often it is saved",
        description="a table, [time], with an end",
    )
    units: Units | None = Field(
        default=None,
        title="what one unit of length, time and force of the scene is",
        description='a table, [units]; in these units "500 nm" is a number',
    )
    output: Output | None = Field(
        default=None, title="what is saved of a run, and made of it at its end", description="a table, [output]"
    )
    sweep: SweepTable | None = Field(
        default=None,
        title="parameter study over keys of this scene; one run if left out",
        description="a table, [sweep]",
    )

    def __init__(self, /, **tables: Any):
        read, faults = in_scene_units(plain(tables))
        try:
            super().__init__(**read)
        except ValidationError as error:
            raise SceneError(_message(error.errors(include_url=False), faults)) from None
        if faults := [*faults, *_late(self)]:
            raise SceneError(_message([], faults))

    @classmethod
    def load(cls, path: str | Path) -> Scene:
        """The scene in a TOML file; raises SceneError for a faulty scene and for a file that cannot be read."""
        if not isinstance(path, (str, os.PathLike)):
            raise SceneError(f"path = {shown(path)}: must be the path of a scene file")
        try:
            with Path(path).open("rb") as file:  # a device has no size to look at, and may have no end
                data = file.read(LARGEST_FILE + 1)
            if len(data) > LARGEST_FILE:
                raise SceneError(f"{path}: must have at most {LARGEST_FILE / 1e6:g} MB")
            text = io.StringIO(data.decode("utf-8-sig"), newline=None).read()
        except FileNotFoundError:
            raise SceneError(f"{path}: there is no such file") from None
        except (OSError, UnicodeError) as error:
            raise SceneError(f"{path}: cannot be read as text: {error}") from None
        try:
            return cls.parse(text, Path(path).resolve().parent)
        except SceneError as error:
            raise SceneError(f"{path}: {error}") from None

    @classmethod
    def parse(cls, scene: str | Mapping[str, Any], folder: str | Path = "") -> Scene:
        """The scene in this TOML text (relative paths: to ``folder``), or in a mapping; raises SceneError."""
        if isinstance(scene, Mapping):
            return cls(**plain(scene))
        if not isinstance(scene, str):
            raise SceneError(f"scene = {shown(scene)}: must be TOML text or a mapping of its tables")
        try:
            tables = tomllib.loads(scene)
        except (ValueError, RecursionError) as error:  # a number of 5000 digits raises another ValueError
            raise SceneError(f"this is not TOML: {error}") from None
        with_whole_paths(tables, Path(folder))
        try:
            return cls(**tables)
        except RecursionError:
            raise SceneError("tables or lists are nested too deeply: those of a scene have a few levels") from None

    def __repr__(self) -> str:
        ensembles = [
            f"{table.name} ({table.count} {_called(kind, table.count)})"
            for kind in ENSEMBLES
            for table in getattr(self, kind)
        ]
        title = f" {shown(self.title)}" if self.title else ""
        parts = [f"<Scene{title}: {', '.join(ensembles)}"]
        parts += [f"surface {self.surface.kind}"] if self.surface else []
        parts += [f"box {self.box.kind}"] if self.box else []
        return "; ".join([*parts, *(["steric"] if self.steric else []), f"until t = {self.time.end:g}>"])

    __str__ = __repr__

    def _repr_html_(self) -> str:
        rods = [
            (table.name, _called(kind, 2), table.count, table.nodes)  # type: ignore[attr-defined]
            for kind in ENSEMBLES
            for table in getattr(self, kind)
        ]
        others = {"surface": self.surface, "box": self.box, "flow": self.flow}
        rows = [(key, table.kind, "", "") for key, table in others.items() if table is not None]
        until = ("time", f"until t = {self.time.end:g}", f"frames {self.time.save_every:g} apart", "")
        return html_table([*rods, *rows, until], ("ensemble", "kind", "rods", "nodes"), self.title or "Scene")

    def to_toml(self) -> str:
        """The scene as TOML text with the defaults of its tables but None; ``parse`` returns an equal scene."""
        return tomli_w.dumps(self._tables())

    def hash(self) -> str:
        """SHA-256 (hex) of the content including defaults, independent of order and formatting of the file."""
        return hashlib.sha256(json.dumps(self._tables(), sort_keys=True).encode()).hexdigest()

    def _tables(self) -> dict[str, Any]:
        return {key: value for key, value in self.model_dump(exclude_none=True).items() if value != ()}

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        """The scene with random placement of swimmers in a box where it gives none."""
        swimmers = data.get("swimmers")
        if "box" not in data or not isinstance(swimmers, tuple):
            return data
        placed = tuple({"placement": "random", **table} if isinstance(table, dict) else table for table in swimmers)
        return {**data, "swimmers": placed}

    @property
    def period(self) -> tuple[float, float, float]:
        """The period of the box along each axis, 0 where there is none; length."""
        # A fraction is that of the volume, or of the area of a slab, which cells as wide as the steric core fill.
        if self.box is None:
            return (0.0, 0.0, 0.0)
        if self.box.ends == "periodic":
            return tuple((self.box.length or 0.0) * (axis == self.box.along) for axis in range(3))  # type: ignore
        size = self.box.size
        if size is None and self.box.fraction is not None:
            assert self.steric is not None  # checked before
            cells = sum(table.count for table in self.swimmers)
            size = _filled(self.box.kind, self.box.fraction, cells, self.steric.core)
        return (*(size or (0.0, 0.0)), 0.0)[:3]  # type: ignore[return-value]

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        faults = [*_name_faults(raw), *_box_faults(raw, good), *_symmetry_faults(good), *_aim_faults(raw, good)]
        faults += sweep_faults(raw)
        if not any(raw.get(kind) for kind in ENSEMBLES):
            text = ": missing; a scene has at least one [[filaments]], [[swimmers]] or [[cosserat]]"
            faults.append(fault(("filaments",), raw, text))
        if raw.get("filaments") and "surface" not in raw:
            text = f": missing; filaments need one: add [surface] with a kind, one of {', '.join(KINDS)}"
            faults.append(fault(("surface",), raw, text))
        if "surface" in good and "time" in good:
            values = {key: value for key, value in good["surface"].items() if key != "kind"}
            found = motion_faults(good["surface"]["kind"], values, good["time"]["end"])
            faults += [fault(("surface", *loc), raw, text) for loc, text in found]
        return faults


def with_whole_paths(tables: dict[str, Any], folder: Path) -> bool:
    """Put ``folder`` before the relative paths in the tables of a scene; returns whether there were some."""
    found = False
    for table, key in _readers(tables):
        value = table[key]
        paths = value if isinstance(value, list) else [value]
        whole = [str(folder / path) if isinstance(path, str) else path for path in paths]
        if whole != paths:
            table[key], found = whole if isinstance(value, list) else whole[0], True
    return found


def text_with_whole_paths(text: str, folder: Path) -> str:
    """The TOML of a scene with ``folder`` before its relative paths; as it is where there are none."""
    try:
        tables = tomllib.loads(text)
    except ValueError:
        return text
    return tomli_w.dumps(tables) if with_whole_paths(tables, folder) else text


def paths_read(tables: dict[str, Any]) -> list[str]:
    """The files and folders that a scene with these tables reads, as they are given."""
    values = [table[key] for table, key in _readers(tables)]
    each = [path for value in values for path in (value if isinstance(value, (list, tuple)) else [value])]
    return list(dict.fromkeys(path for path in each if isinstance(path, str)))


def _readers(tables: dict[str, Any]) -> list[tuple[dict[str, Any], str]]:
    """The tables of a scene that give a path, or a list of paths, with its key."""
    box = tables.get("box")
    surfaces = (tables.get("surface"), box.get("surface") if isinstance(box, dict) else None)
    ensembles = [tables.get(key) for key in ("filaments", "swimmers")]
    lists = (list, tuple)
    rods = [table for each in ensembles if isinstance(each, lists) for table in each if isinstance(table, dict)]
    owners = [(table, "file") for table in surfaces] + [
        (t.get("shape"), key) for t in rods for key in ("points", "run")
    ]
    ends = [end for t in rods if isinstance(pair := t.get("ends"), lists) for end in pair]
    owners += [(end.get(key), "file") for end in ends if isinstance(end, dict) for key in ("motion", "rotation")]
    return [(table, key) for table, key in owners if isinstance(table, dict) and key in table]


def _called(kind: str, count: int) -> str:
    """The rods of a table in words."""
    word = {"cosserat": "Cosserat rods"}.get(kind, kind)
    return word if count > 1 else word.removesuffix("s")


def _filled(kind: str, fraction: float, cells: int, width: float) -> tuple[float, ...]:
    """The periods of a box such that cells of length 1 and this width fill a fraction of it."""
    filled = cells * width * (1.0 if kind == "slab" else math.pi / 4 * width)
    sides = ROOMS[kind].sides
    return ((filled / fraction) ** (1 / sides),) * sides


def _box_faults(raw: dict[str, Any], good: dict[str, Any]) -> Faults:
    """Faults that concern the box together with its swimmers and their steric repulsion."""
    faults: Faults = []
    tables = good.get("swimmers") or ()
    if "box" not in raw:
        return [
            fault(("swimmers", i, "placement"), table, f" = {shown(table['placement'])}: needs a [box] to fill")
            for i, table in enumerate(tables)
            if isinstance(table.get("placement"), str)
        ]
    box, steric = good.get("box"), good.get("steric")
    if not raw.get("swimmers"):
        faults.append(fault(("box",), raw["box"], ": there are no [[swimmers]] in it"))
    if box and "fraction" in box and "steric" not in raw:
        text = f" = {box['fraction']:g}: refers to cells as wide as the steric core: add [steric], or give size"
        faults.append(fault(("box", "fraction"), box, text))
    return faults + (_width_faults(box, steric, tables) if box and steric else [])


def _symmetry_faults(good: dict[str, Any]) -> Faults:
    """Symmetric swimmers together with forces that could break their symmetry."""
    steric, box = good.get("steric"), good.get("box")
    walls = box and box["kind"] != "periodic"
    flow = good.get("flow")
    possible = {"[steric]": steric and steric["strength"], "a [box] of walls": walls, "[gravity]": good.get("gravity")}
    possible |= {"[flow]": flow and flow.get("kind") != "uniform", "[[forces]]": good.get("forces")}
    forces = [name for name, present in possible.items() if present]
    text = f" = true: not possible with {' and '.join(forces)}, whose forces could break the symmetry; leave it out"
    return [
        fault(("swimmers", i, "symmetric"), table, text)
        for i, table in enumerate(good.get("swimmers") or ())
        if forces and table.get("symmetric") is True
    ]


def _aim_faults(raw: dict[str, Any], good: dict[str, Any]) -> Faults:
    """Forces on ensembles that are not there, and what acts from outside where there are Cosserat rods."""
    given = [raw.get(key) for key in ("filaments", "swimmers")]
    tables = [table for part in given if isinstance(part, tuple) for table in part]
    known = [table.get("name") for table in tables if isinstance(table, dict)]
    text = ": does not act on [[cosserat]]: give these rods their own force and couple, in a scene of their own"
    refused = [
        fault((key,), raw[key], text) for key in ("flow", "gravity", "forces") if raw.get("cosserat") and raw.get(key)
    ]
    return refused + [
        fault(
            ("forces", i, "on"), table, f" = {shown(table['on'])}: there is no ensemble {shown(name)}; known: {known}"
        )
        for i, table in enumerate(good.get("forces") or ())
        for name in table.get("on") or ()
        if name not in known
    ]


def _late(scene: Scene) -> Iterator[UnitFault]:
    """Tables of motions that end before the run."""
    for i, table in enumerate(scene.swimmers):
        for j, end in enumerate(table.ends or ()):
            if isinstance(end, EndTable) and end.until < scene.time.end:
                text = f": a table of its motion ends at {end.until:g}, before time.end = {scene.time.end:g}: "
                yield ("swimmers", i, "ends", j), text + "go on with it, or let it be periodic"


def _width_faults(box: dict[str, Any], steric: dict[str, Any], tables: Sequence[dict[str, Any]]) -> Faults:
    """Boxes not wider than twice the range of the steric force, as only nearest images interact."""
    least = 2 * CUTOFF * steric["range"]
    required = f"must be above {least:g}, twice the reach of the steric force, 8 ranges"
    periods = ("size", "length") if box.get("ends") != "closed" else ("size",)
    for key in periods:
        if key in box:
            text = f" = {shown(box[key])}: {required}"
            return [fault(("box", key), box, text)] if np.min(box[key]) <= least else []
    if "fraction" not in box or not ROOMS[box["kind"]].sides or not tables:
        return []
    side = _filled(box["kind"], box["fraction"], sum(table["count"] for table in tables), steric["core"])[0]
    text = f" = {box['fraction']:g}: makes a box {side:.4g} wide; it {required}: place more swimmers, or fill less"
    return [fault(("box", "fraction"), box, text)] if side <= least else []


def _name_faults(raw: dict[str, Any]) -> Faults:
    """Ensembles whose names are equal or differ in case only, as some file systems ignore case."""
    first: dict[str, str] = {}
    faults = []
    for key in ENSEMBLES:
        tables = raw.get(key)
        for i, table in enumerate(tables if isinstance(tables, tuple) else []):
            name = table.get("name") if isinstance(table, dict) else None
            owner = first.setdefault(str(name).lower(), key_path((key, i)))
            if isinstance(name, str) and owner != key_path((key, i)):
                text = f" = {shown(name)}: is already the name of {owner}; each ensemble needs its own"
                faults.append(fault((key, i, "name"), name, text))
    return faults


def _message(errors: Sequence[Any], of_units: Sequence[UnitFault]) -> str:
    """One line for each fault. Where a quantity has one, it is the only one of its value."""
    apart = {loc for loc, _text in of_units}
    found = [(line["loc"], line["msg"]) for line in errors if line["loc"] not in apart]
    lines = [f"  {key_path(loc)}{text}" for loc, text in (*found, *of_units) if text]
    return f"{len(lines)} fault{'s' if len(lines) > 1 else ''} in the scene\n" + "\n".join(lines)

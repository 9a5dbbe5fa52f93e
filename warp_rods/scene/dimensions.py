"""Quantities with a unit in a scene, such as ``radius = "500 nm"``: which keys may have them, and their numbers.

To let a key have a unit, add its path to ``DIMENSIONS``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Any

from pydantic import ValidationError

from warp_rods.quantities import (
    FORCE,
    LENGTH,
    NONE,
    TIME,
    Dimension,
    QuantityError,
    is_quantity,
    may_be_inverse,
    parse,
    words,
)
from warp_rods.scene.body import BodyTable
from warp_rods.scene.units import BASE, EXAMPLES, Scale
from warp_rods.values import plain, shown

__all__ = ["ANY", "DIMENSIONS", "UnitFault", "in_scene_units"]

UnitFault = tuple[tuple[str | int, ...], str]
"""The path of a value, and its fault; empty where its fault is another one's."""

ANY = None
"""A key whose quantities may have any dimension."""
INVERSE, SPEED, RATE = Dimension(-1), Dimension(1, -1), Dimension(0, -1)
STIFFNESS, COUPLE, PER_LENGTH = Dimension(2, 0, 1), Dimension(1, 0, 1), Dimension(-1, 0, 1)
DRAG, TURNING_DRAG = Dimension(-2, 1, 1), Dimension(0, 1, 1)
DIMENSIONS: dict[str, Dimension | tuple[Dimension, ...] | None] = {
    # time, what is around the rods
    **dict.fromkeys(("time.end", "time.step", "time.save_every"), TIME),
    **dict.fromkeys(("steric.range", "steric.core"), LENGTH),
    "steric.strength": FORCE,
    **dict.fromkeys(("box.size", "box.height", "box.radius", "box.length", "box.sides", "box.wall.range"), LENGTH),
    "box.wall.strength": Dimension(-2, 0, 1),
    "gravity.force": PER_LENGTH,
    "flow.rate": RATE,
    **dict.fromkeys(("flow.velocity", "flow.speed"), SPEED),
    **dict.fromkeys(("flow.centre", "flow.radius"), LENGTH),
    "flow.parameters": ANY,
    "forces.force": PER_LENGTH,
    "forces.couple": FORCE,
    "forces.parameters": ANY,
    # membranes
    **{
        f"{where}.{key}": ANY if key == "parameters" else LENGTH
        for where in ("surface", "box.surface")
        for key in ("size", "radius", "radii", "length", "major", "minor", "a", "b", "neck", "body", "width",
                    "box", "spacing", "origin", "parameters")
    },
    **dict.fromkeys(("surface.wavenumber", "box.surface.wavenumber"), INVERSE),
    # of the membrane "undulated", the only kind that has it, in φ beside x² + y² + z²
    **dict.fromkeys(("surface.amplitude", "box.surface.amplitude"), Dimension(2)),
    # filaments
    "filaments.length": LENGTH,
    "filaments.stiffness": STIFFNESS,
    "filaments.intrinsic": INVERSE,
    "filaments.drag": (DRAG, DRAG, TURNING_DRAG),
    "filaments.parameters": ANY,
    "filaments.placement.position": LENGTH,
    "filaments.placement.geodesic_curvature": INVERSE,
    "filaments.shape.scale": LENGTH,
    "filaments.growth.rate": SPEED,
    **dict.fromkeys(("filaments.growth.start", "filaments.growth.time"), TIME),
    **{f"filaments.growth.{key}": LENGTH for key in ("until", "length", "spacing")},
    # swimmers
    **dict.fromkeys(("swimmers.bend", "swimmers.twist"), STIFFNESS),
    "swimmers.moment": LENGTH,
    "swimmers.couple": FORCE,
    "swimmers.drag_along": DRAG,
    "swimmers.rotational_drag": TURNING_DRAG,
    **{f"swimmers.{key}": INVERSE for key in ("natural_bend", "natural_bend.second", "natural_bend.third",
                                             "natural_twist", "flagella.sharpness")},
    "swimmers.flagella.relaxation": TIME,
    **dict.fromkeys(("swimmers.flagella.front", "swimmers.flagella.back"), PER_LENGTH),
    "swimmers.flagella.steepness": INVERSE,
    **dict.fromkeys(("swimmers.behaviour.reversal.rate", "swimmers.behaviour.tumble.rate"), RATE),
    "swimmers.behaviour.tumble.duration": TIME,
    "swimmers.behaviour.tumble.turn": NONE,
    "swimmers.flagella.diffusion": Dimension(2, -1),
    "swimmers.parameters": ANY,
    **dict.fromkeys(("swimmers.ends.thrust", "swimmers.ends.force"), FORCE),
    **dict.fromkeys(("swimmers.ends.torque", "swimmers.ends.couple"), COUPLE),
    "swimmers.ends.turning": RATE,
    **dict.fromkeys(("swimmers.ends.rotation", "swimmers.ends.rotation.points"), NONE),
    **dict.fromkeys(("swimmers.ends.motion", "swimmers.ends.motion.points"), LENGTH),
    **dict.fromkeys(("swimmers.ends.motion.times", "swimmers.ends.rotation.times"), TIME),
    **dict.fromkeys(("swimmers.shape.bend", "swimmers.shape.bend1", "swimmers.shape.bend2"), INVERSE),
    "swimmers.shape.twist": INVERSE,
    **dict.fromkeys(("swimmers.shape.amplitude", "swimmers.shape.smoothing", "filaments.shape.smoothing"), NONE),
    "swimmers.placement.position": LENGTH,
    # extensible rods
    "cosserat.stiffness": (STIFFNESS,) * 3 + (FORCE,) * 3,
    "cosserat.natural": (INVERSE,) * 3 + (NONE,) * 3,
    "cosserat.coupling": NONE,
    "cosserat.rotational_drag": TURNING_DRAG,
    "cosserat.force": PER_LENGTH,
    "cosserat.couple": FORCE,
    "cosserat.placement.position": LENGTH,
}  # fmt: skip
"""Path of a key → the dimension of its numbers; or one for each of those of a vector."""
TURNS = {"swimmers.ends.turning"}
"""Keys whose rates are of rotation, in radians per time: of a frequency it would be unclear what it counts."""
FREQUENCY = re.compile(r"(hz|hertz)\b", re.IGNORECASE)
SAME = 1e-9
"""Relative difference up to which two values are equal."""


def in_scene_units(tables: dict[str, Any]) -> tuple[dict[str, Any], list[UnitFault]]:
    """The tables of a scene with numbers in place of quantities with a unit, and faults of these.

    Where swimmers have a body, [units] and their drags follow from it.
    """
    faults: list[UnitFault] = []
    tables = _with_bodies(tables, faults)
    units = tables.get("units")
    scale = Scale.of(units if isinstance(units, dict) else {})
    broken = {key for key in BASE if isinstance(units, dict) and key in units and key not in scale.units}
    if _faulty_body(tables.get("swimmers")):  # from which they would follow
        broken |= BASE.keys() - scale.units.keys()

    def read(value: Any, loc: tuple[str | int, ...]) -> Any:
        if isinstance(value, dict):
            return {key: read(inner, (*loc, key)) for key, inner in value.items()}
        if isinstance(value, tuple):
            return tuple(read(inner, (*loc, i)) for i, inner in enumerate(value))
        if not isinstance(value, str) or (found := _wanted(loc)) is None:
            return value
        if not (is_quantity(value) or may_be_inverse(value, found[0])):
            return value
        text, number = _number(value, found[0], scale, broken)
        if _path(loc) in TURNS and number is not None and FREQUENCY.search(value):
            text = f" = {shown(value)}: a rate of rotation must be in rad/s or rpm, as 1 Hz may be a turn or a radian"
        if text is not None:
            faults.append((loc, text))
        return value if number is None else number

    converted = {key: value if key == "units" else read(value, (key,)) for key, value in tables.items()}
    return converted, faults


def _path(loc: tuple[str | int, ...]) -> str:
    return ".".join(part for part in loc if isinstance(part, str))


def _wanted(loc: tuple[str | int, ...]) -> tuple[Dimension | None] | None:
    """The dimension of the value at a path, ``ANY`` in a tuple for any; None where it has no unit."""
    keys = [part for part in loc if isinstance(part, str)]
    for length in range(len(keys), 0, -1):  # names of parameters and { nodes = [...] } belong to the key before
        path = ".".join(keys[:length])
        if path not in DIMENSIONS:
            continue
        if keys[length:] not in ([], ["nodes"]) and not path.endswith("parameters"):
            return None
        wanted = DIMENSIONS[path]
        if not isinstance(wanted, tuple) or isinstance(wanted, Dimension):
            return (wanted,)
        after = loc[_place(loc, length) :]
        indices = list(after[: next((i for i, part in enumerate(after) if isinstance(part, str)), len(after))])
        component = indices[-1] if indices else 0
        return (wanted[component],) if isinstance(component, int) and component < len(wanted) else None
    return None


def _place(loc: tuple[str | int, ...], keys: int) -> int:
    """The index in a path after this many keys."""
    at = [i for i, part in enumerate(loc) if isinstance(part, str)]
    return at[keys - 1] + 1


def _number(text: str, wanted: Dimension | None, scale: Scale, broken: set[str]) -> tuple[str | None, float | None]:
    """The fault of a quantity, or its number."""
    try:
        value, dimension = parse(text)
    except QuantityError as error:
        return f" = {shown(text)}: {error}", None
    if wanted is not ANY and dimension != wanted:
        return f" = {shown(text)}: is {words(dimension)}; must be {words(wanted)}", None
    if missing := scale.missing(dimension):
        if broken.intersection(missing):
            return "", None
        lines = " and ".join(f"{key} = {EXAMPLES[key]}" for key in missing)
        needs = " and ".join(missing)
        return f" = {shown(text)}: needs the unit of {needs} of the scene: add {lines} to [units]", None
    try:
        return None, float(value / scale.one(dimension))
    except (OverflowError, TypeError):
        return f" = {shown(text)}: is too large or small in the units of the scene", None


def _with_bodies(tables: dict[str, Any], faults: list[UnitFault]) -> dict[str, Any]:
    """The tables with [units] and the drags of swimmers that follow from their bodies."""
    bodies = dict(_bodies(tables.get("swimmers")))
    units = tables.get("units", {})
    if not bodies or not isinstance(units, dict):
        return tables
    first = next(iter(bodies.values()))
    own = {"length": first.length, "time": f"{first.seconds!r} s", "force": f"{first.force!r} N"}
    units = own | units
    scale = Scale.of(units)
    if len(scale.units) < len(BASE):
        return tables  # [units] has faults of its own
    L, T, F = (float(scale.units[key]) for key in BASE)
    swimmers = list(tables["swimmers"])
    given = bool(tables.get("units"))
    if not math.isclose(first.seconds, T, rel_tol=SAME):
        text = f" = {shown(units['time'])}: ζ∥L/f* of the swimmers is {first.seconds:.6g} s: leave it out"
        faults.append((("units", "time"), text))
    for i, body in bodies.items():
        faults += [(("swimmers", i, "body", key), text) for key, text in _differences(body, L, F, given)]
        along, across, about = body.drags
        drags = {"drag_ratio": across / along, "rotational_drag": about / (F * T)}
        ratio = along * L**2 / (F * T)
        if not math.isclose(ratio, 1.0, rel_tol=SAME):
            drags["drag_along"] = ratio
        swimmers[i] = drags | swimmers[i]
    return {**tables, "units": units, "swimmers": tuple(swimmers)}


def _bodies(swimmers: Any) -> Iterator[tuple[int, BodyTable]]:
    """The bodies without faults, by the number of their table."""
    for i, table in enumerate(swimmers if isinstance(swimmers, tuple) else ()):
        if isinstance(table, dict) and isinstance(table.get("body"), dict):
            try:
                yield i, BodyTable.model_validate(plain(table["body"]))
            except ValidationError:
                continue


def _faulty_body(swimmers: Any) -> bool:
    """Whether a table of swimmers has a body with a fault."""
    tables = swimmers if isinstance(swimmers, tuple) else ()
    given = {i for i, table in enumerate(tables) if isinstance(table, dict) and "body" in table}
    return bool(given - dict(_bodies(swimmers)).keys())


def _differences(body: BodyTable, length: float, force: float, given: bool) -> Iterator[tuple[str, str]]:
    """Bodies whose rods are not as long, or not pushed as strongly, as one unit of length and force."""
    remedy = "leave [units] out" if given else "use one scene for each"
    if not math.isclose(body.metres, length, rel_tol=SAME):
        text = f" = {shown(body.length)}: swimmers have the length 1, and units.length is {length:g} m: {remedy}"
        yield "length", text
    if not math.isclose(body.force, force, rel_tol=SAME):
        key = "thrust" if body.thrust is not None else "speed"
        text = f" = {shown(getattr(body, key))}: f*L is {body.force:g} N, and units.force is {force:g} N: {remedy}"
        yield key, text

"""The table [box] of a scene: the space in which swimmers move."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from pydantic import Field

from warp_rods.membranes import motion
from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.tables import SurfaceTable
from warp_rods.values import Positive, shown

__all__ = ["ROOMS", "Box", "Room", "Wall"]


@dataclass(frozen=True)
class Room:
    """A kind of box: its keys, and the number of sides that are periodic where ``size`` or ``fraction`` give them.

    Walls, and the region in which rods are placed, are those of the same name in ``warp_rods/contact/rooms.py``.
    """

    required: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()
    defaults: Mapping[str, Any] = field(default_factory=dict)
    sides: int = 0
    least: tuple[tuple[str, int], ...] = ()
    """Keys of lengths, each with the number of ranges of the walls that it must not be below."""

    @property
    def keys(self) -> set[str]:
        """All keys besides ``kind``."""
        return {*self.required, *self.optional, *self.defaults}


ALONG = {"axis": "x", "ends": "periodic", "wall": {}}
ROOMS: dict[str, Room] = {
    "periodic": Room(optional=("size", "fraction"), sides=3),
    "slab": Room(("height",), ("size", "fraction"), {"wall": {}}, sides=2, least=(("height", 2),)),
    "container": Room(("surface",), (), {"side": "inside", "wall": {}}),
    "pore": Room(("radius",), ("length",), ALONG, least=(("radius", 1),)),
    "duct": Room(("sides",), ("length",), ALONG, least=(("sides", 2),)),
}
"""Kinds of boxes. A pore is a cylinder and a duct has a rectangular section, both along an axis."""
KINDS = ", ".join(f'"{kind}"' for kind in list(ROOMS)[:-1]) + f' or "{list(ROOMS)[-1]}"'


class Wall(Table):
    """A soft wall: it pushes rods back by a force k (d + δ) per length where d > −δ, with d the distance outside it."""

    strength: Positive = Field(
        default=2000.0,
        title="stiffness k of the wall (force/length²)",
        description="a positive number: force per length and depth",
    )
    range: Positive = Field(
        default=0.05,
        title="range δ of the wall (length)",
        description="a positive number: distance from the wall at which its force begins",
    )


class Box(Table):
    """The space of swimmers: a periodic box, a slab, a surface from inside or outside, or a pore or duct."""

    kind: Literal["periodic", "slab", "container", "pore", "duct"] = Field(
        title="shape of the region, and where it is periodic or has walls", description=KINDS
    )
    size: tuple[Positive, ...] | None = Field(
        default=None,
        title="size of a periodic box or slab (length); a slab may have none",
        description="positive numbers: the periods along x, y and z (of a slab: along x and y)",
    )
    fraction: Positive | None = Field(
        default=None,
        title="share filled by cells as wide as the steric core, in place of size",
        description="a positive number below 1: the share of the volume (of a slab: of the area) that swimmers fill",
    )
    height: Positive | None = Field(
        default=None,
        title="height h of a slab, between walls at z = ±h/2 (length)",
        description="a positive number: the distance of a slab's walls",
    )
    surface: SurfaceTable | None = Field(
        default=None,
        title="surface of a container, any membrane at rest",
        description='a table as [surface], such as { kind = "sphere", radius = 3.0 }',
    )
    side: Literal["inside", "outside"] | None = Field(
        default=None,
        title="side of the surface of a container; inside if left out",
        description='"inside" or "outside": on which side of the surface swimmers are',
    )
    radius: Positive | None = Field(
        default=None, title="radius of the wall around the axis (length)", description="a positive number: of a pore"
    )
    sides: tuple[Positive, Positive] | None = Field(
        default=None,
        title="width of a duct along the two axes that follow its own (length)",
        description="two positive numbers: the sides of the section of a duct",
    )
    length: Positive | None = Field(
        default=None,
        title="length from one end to the other",
        description="a positive number: of a pore or duct, which is endless without it",
    )
    axis: Literal["x", "y", "z"] | None = Field(
        default=None,
        title="axis of a pore or duct; x if left out",
        description='"x", "y" or "z": the direction of a pore or duct',
    )
    ends: Literal["periodic", "closed"] | None = Field(
        default=None,
        title="whether rods that leave one end come in at the other, or meet a wall",
        description='"periodic" or "closed": of a pore or duct with a length',
    )
    wall: Wall | None = Field(
        default=None, title="soft walls of all boxes but periodic ones", description="a table { strength, range }"
    )

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        kind = data.get("kind")
        return {**ROOMS[kind].defaults, **data} if isinstance(kind, str) and kind in ROOMS else data

    @property
    def along(self) -> int:
        """The number of the axis of a pore or duct."""
        return "xyz".index(self.axis or "x")

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        kind = good.get("kind")
        if kind is None:
            return []
        room = ROOMS[kind]
        every = set().union(*(other.keys for other in ROOMS.values()))
        faults = [
            fault((key,), raw[key], f": a box of kind {kind} has no {key}; it has {', '.join(sorted(room.keys))}")
            for key in sorted(raw.keys() & every - room.keys)
        ]
        faults += [
            fault((key,), raw, f": missing; must be {cls.model_fields[key].description}")
            for key in room.required
            if key not in raw
        ]
        faults += _wall_faults(room, good) if "wall" in good and "wall" in room.keys else []
        return faults + _extent_faults(kind, raw, good)


def _extent_faults(kind: str, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
    """Faults of size and fraction, of which a periodic box needs exactly one, of ends, and of a moving container."""
    faults = []
    if "size" in raw and "fraction" in raw:
        faults.append(fault((), raw, ": size and fraction: one follows from the other; give one of them"))
    if kind == "periodic" and not raw.keys() & {"size", "fraction"}:
        faults.append(fault((), raw, ": size or fraction: missing; give one of them"))
    sides = ROOMS[kind].sides
    if "size" in good and sides and len(good["size"]) != sides:
        text = f" = {shown(good['size'])}: must be {sides} positive numbers for a {kind} box"
        faults.append(fault(("size",), good["size"], text))
    if "fraction" in good and not good["fraction"] < 1:
        faults.append(fault(("fraction",), good["fraction"], f" = {good['fraction']:g}: must be below 1"))
    if good.get("ends") == "closed" and "length" not in raw and "ends" in ROOMS[kind].keys:
        text = ' = "closed": needs the length between the ends; give length, or leave out ends'
        faults.append(fault(("ends",), good["ends"], text))
    if "surface" in good and kind == "container" and motion.is_moving(good["surface"]):
        faults.append(
            fault(("surface",), good["surface"], ": a container cannot move: give numbers, not formulas in t")
        )
    return faults


def _wall_faults(room: Room, good: dict[str, Any]) -> Faults:
    """Walls whose ranges overlap or reach the axis, where the force would jump."""
    reach = good["wall"].get("range", Wall.model_fields["range"].default)
    closed = (("length", 2),) if good.get("ends") == "closed" else ()
    faults = []
    for key, ranges in (*room.least, *closed):
        if key in good and np.min(good[key]) < ranges * reach:
            times = "twice the range" if ranges == 2 else "the range"
            text = f" = {shown(good[key])}: must be at least {ranges * reach:g}, {times} of the walls"
            faults.append(fault((key,), good[key], text))
    return faults

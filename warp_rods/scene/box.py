"""The table [box] of a scene: the space in which swimmers move."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from warp_rods.membranes import motion
from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.tables import SurfaceTable
from warp_rods.values import Positive, shown

__all__ = ["AXES", "Box", "Wall"]

KINDS: dict[str, dict[str, Any]] = {
    "periodic": {},
    "slab": {"wall": {}},
    "container": {"side": "inside", "wall": {}},
}
"""Kind of box → defaults of keys that only some kinds have."""
KEYS = {
    "periodic": {"size", "fraction"},
    "slab": {"size", "fraction", "height", "wall"},
    "container": {"surface", "side", "wall"},
}
"""Kind of box → its keys."""
AXES = {"periodic": 3, "slab": 2}
"""Kind of box → number of periodic axes."""


class Wall(Table):
    """A soft wall: it pushes rods back by a force k (d + δ) per length where d > −δ, with d the distance outside it.

    strength: k, range: δ.
    """

    strength: Positive = Field(default=2000.0, description="a positive number: force per length and depth")
    range: Positive = Field(
        default=0.05, description="a positive number: distance from the wall at which its force begins"
    )


class Box(Table):
    """The space of swimmers: a periodic box, a slab between two walls, or the inside or outside of a surface."""

    kind: Literal["periodic", "slab", "container"] = Field(description='"periodic", "slab" or "container"')
    size: tuple[Positive, ...] | None = Field(
        default=None, description="positive numbers: the periods along x, y and z (of a slab: along x and y)"
    )
    fraction: Positive | None = Field(
        default=None,
        description="a positive number below 1: the share of the volume (of a slab: of the area) that swimmers fill",
    )
    height: Positive | None = Field(default=None, description="a positive number: the distance of a slab's walls")
    surface: SurfaceTable | None = Field(
        default=None, description='a table as [surface], such as { kind = "sphere", radius = 3.0 }'
    )
    side: Literal["inside", "outside"] | None = Field(
        default=None, description='"inside" or "outside": on which side of the surface swimmers are'
    )
    wall: Wall | None = Field(default=None, description="a table { strength, range }")

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        kind = data.get("kind")
        return {**KINDS.get(kind, {}), **data} if isinstance(kind, str) else data

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        kind = good.get("kind")
        if kind is None:
            return []
        faults = [
            fault((key,), raw[key], f": a box of kind {kind} has no {key}; it has {', '.join(sorted(KEYS[kind]))}")
            for key in sorted(raw.keys() & set().union(*KEYS.values()) - KEYS[kind])
        ]
        faults += [
            fault((key,), raw, f": missing; must be {cls.model_fields[key].description}")
            for key in ("height", "surface")
            if key in KEYS[kind] and key not in raw
        ]
        faults += _wall_faults(good) if kind == "slab" and {"height", "wall"} <= good.keys() else []
        return faults + _extent_faults(kind, raw, good)


def _extent_faults(kind: str, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
    """Faults of size and fraction, of which a periodic box needs exactly one, and of a moving container."""
    faults = []
    if "size" in raw and "fraction" in raw:
        faults.append(fault((), raw, ": size and fraction: one follows from the other; give one of them"))
    if kind == "periodic" and not raw.keys() & {"size", "fraction"}:
        faults.append(fault((), raw, ": size or fraction: missing; give one of them"))
    if "size" in good and kind in AXES and len(good["size"]) != AXES[kind]:
        text = f" = {shown(good['size'])}: must be {AXES[kind]} positive numbers for a {kind} box"
        faults.append(fault(("size",), good["size"], text))
    if "fraction" in good and not good["fraction"] < 1:
        faults.append(fault(("fraction",), good["fraction"], f" = {good['fraction']:g}: must be below 1"))
    if "surface" in good and kind == "container" and motion.is_moving(good["surface"]):
        faults.append(
            fault(("surface",), good["surface"], ": a container cannot move: give numbers, not formulas in t")
        )
    return faults


def _wall_faults(good: dict[str, Any]) -> Faults:
    """Overlapping walls, whose force would jump at z = 0, where the nearer wall changes."""
    least = 2 * good["wall"].get("range", Wall.model_fields["range"].default)
    text = f" = {good['height']:g}: must be at least {least:g}, twice the range of the walls"
    return [fault(("height",), good["height"], text)] if good["height"] < least else []

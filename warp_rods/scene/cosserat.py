"""The table [[cosserat]] of a scene."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.ensemble import MOST_NODES, EnsembleTable, length_faults
from warp_rods.scene.per_rod import OR_EACH, Direction, EachVector, NumberEach, PositiveEach, Vector
from warp_rods.values import Number, Positive

__all__ = ["CosseratPlacement", "CosseratShape", "CosseratTable"]

Six = tuple[Number, Number, Number, Number, Number, Number]
SixPositive = tuple[Positive, Positive, Positive, Positive, Positive, Positive]
End = Literal["free", "hinged", "clamped"]
STRAINS = "(twist, two bendings, stretch, two shears)"


class CosseratShape(Table):
    """The shape at the start: at rest, straight, or at rest but for a beam mode; perhaps stretched."""

    kind: Literal["natural", "straight", "mode"] = Field(
        default="natural",
        title="shape at the start, natural, straight, or natural plus a beam mode",
        description='"natural", "straight" or "mode"',
    )
    mode: int | None = Field(
        default=None,
        ge=0,
        le=MOST_NODES // 2,
        title="number of the beam mode; 0, the lowest, if left out",
        description="a whole number, 0 or more, at most 50 000",
    )
    amplitude: NumberEach = Field(
        default=1.0,
        title="amplitude A of the beam mode φ, Ω₂ = A φ beyond the natural strain",
        description="a number" + OR_EACH,
    )
    stretch: PositiveEach = Field(
        default=1.0,
        title="factor of all of U at the start",
        description="a positive number" + OR_EACH + ": the length at the start over that at rest",
    )

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        kind = good.get("kind", "natural" if "kind" not in raw else None)
        if kind in (None, "mode") or good.get("mode") is None:
            return []
        return [fault(("mode",), raw["mode"], f": a shape of kind {kind} has no mode; leave it out")]


class CosseratPlacement(Table):
    """Initial positions: points and directions of the first director there [rod, 3]."""

    at: Literal["middle", "start"] = Field(
        default="middle",
        title="where on the rod its position is",
        description='"middle" or "start": which point of the rod is placed',
    )
    position: tuple[Vector, ...] = Field(
        title="places of the rods at the start (L)", description="a list of points [x, y, z], one for each rod"
    )
    direction: tuple[Direction, ...] | None = Field(
        None,
        title="directions of the first director there",
        description="a list of directions [dx, dy, dz], one for each rod; along x where left out",
    )


class CosseratTable(EnsembleTable):
    """An ensemble of extensible and shearable rods (3.63)–(3.79) with dimensionless parameters."""

    FEWEST_NODES: ClassVar[int] = 5

    nodes: Annotated[int, Field(ge=FEWEST_NODES, le=MOST_NODES)] = Field(
        title="number of nodes along each rod", description="a whole number, 5 or more, at most 100 000"
    )
    stiffness: EachVector[SixPositive] = Field(
        title="stiffness K on its diagonal, three numbers in f*L³, three in f*L",
        description=f"6 positive numbers {STRAINS}" + OR_EACH,
    )
    coupling: tuple[Vector, Vector, Vector] | None = Field(
        default=None,
        title="stiffness K between bending and stretching; none if left out",
        description="3 rows of 3 numbers: stiffness between twist, bendings (rows) and stretch, shears (columns)",
    )
    natural: EachVector[Six] = Field(
        default=(0.0, 0.0, 0.0, 1.0, 0.0, 0.0),
        title="natural strains ξ0, the first three in 1/L",
        description=f"6 numbers {STRAINS}" + OR_EACH + ": the strains at rest",
    )
    drag_ratio: PositiveEach = Field(
        default=2.0, title="drag ratio η = ζ⊥/ζ∥", description="a positive number" + OR_EACH
    )
    rotational_drag: PositiveEach = Field(
        default=3e-3,
        title="rotational drag ηr = ζr/(ζ∥L²) about the first director",
        description="a positive number" + OR_EACH,
    )
    shape: CosseratShape = Field(
        default_factory=CosseratShape,
        title="strains of the rods at the start",
        description="a table { kind, mode, amplitude, stretch }",
    )
    ends: tuple[End, End] = Field(
        default=("free", "free"),
        title='first and last end; "hinged" holds its place, "clamped" its frame',
        description='a pair such as ["clamped", "free"], each "free", "hinged" or "clamped"',
    )
    force: Vector | None = Field(
        default=None,
        title="external force in space (f*); not with [steric]",
        description="3 numbers: force per length, along x, y, z",
    )
    couple: Vector | None = Field(
        default=None, title="external couple in space (f*L)", description="3 numbers: couple per length, about x, y, z"
    )
    placement: CosseratPlacement | None = Field(
        default=None,
        title="where rods start; all at the origin, along x, if left out",
        description="a table { at, position, direction }",
    )

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        placement = tuple("placement." + key for key in ("position", "direction"))
        keys = ("drag_ratio", "rotational_drag", "shape.amplitude", "shape.stretch", *placement)
        return length_faults(raw, good, keys, vectors=("stiffness", "natural"))

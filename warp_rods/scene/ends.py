"""The ends of free rods in a scene."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from warp_rods.scene.along import checked_formula
from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.per_rod import OR_EACH, NumberEach, Vector, WordOrTable
from warp_rods.values import Number

__all__ = ["OF_KIND", "EndOrKind", "EndTable"]

Kind = Literal["free", "hinged", "clamped"]
OF_KIND = {
    "free": ("thrust", "torque", "force", "couple"),
    "hinged": ("torque", "couple", "motion"),
    "clamped": ("turning", "motion", "rotation"),
}
"""What an end of each kind may have."""


NumberOrFormula = Number | Annotated[str, AfterValidator(checked_formula("t"))]
Motion = tuple[NumberOrFormula, NumberOrFormula, NumberOrFormula]


class EndTable(Table):
    """One end of free rods: what holds it, and what moves or loads it."""

    kind: Kind = Field(default="free", description='"free", "hinged" or "clamped"')
    thrust: NumberEach | None = Field(default=None, description="a number" + OR_EACH + ": a force along the tangent")
    torque: NumberEach | None = Field(default=None, description="a number" + OR_EACH + ": a couple about the tangent")
    turning: NumberEach | None = Field(default=None, description="a number" + OR_EACH + ": a rate about the tangent")
    force: Vector | None = Field(default=None, description="a force [x, y, z] in space")
    couple: Vector | None = Field(default=None, description="a couple [x, y, z] in space")
    motion: Motion | None = Field(default=None, description="a displacement of three numbers or formulas in t")
    rotation: Motion | None = Field(default=None, description="a rotation vector of three numbers or formulas in t")

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

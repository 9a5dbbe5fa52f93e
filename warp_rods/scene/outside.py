"""The tables [gravity] and [[forces]] of a scene: what acts on its rods from outside, besides a flow."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.flows import formula_fault, with_values
from warp_rods.scene.parameters import Parameters
from warp_rods.scene.per_rod import Vector

__all__ = ["VARIABLES", "ForceTable", "Gravity"]

VARIABLES = ("x", "y", "z", "s", "t")
"""What forces may depend on: the place in space, the place along the rod from −1/2 to 1/2, and the time."""
NONE = (0.0, 0.0, 0.0)


class Gravity(Table):
    """The weight of rods less their buoyancy, the same for all: force per length in space."""

    force: Vector = Field(
        title="weight of a rod less its buoyancy, in space (force/length)",
        description="three numbers: a force per length",
    )


def _formulas(value: Any) -> Any:
    if not isinstance(value, tuple) or len(value) != 3:
        raise PydanticCustomError("note", "it has not three parts")
    for part in value:
        if text := formula_fault(part, VARIABLES):
            raise PydanticCustomError("note", "{text}", {"text": text})
    return value


ThreeFormulas = Annotated[Any, BeforeValidator(_formulas)]
WORDS = "three numbers or formulas in x, y, z, s and t, "


class ForceTable(Table):
    """A force per length and a couple per length, in space."""

    on: tuple[str, ...] | None = Field(
        default=None,
        title="ensembles of swimmers and filaments on which it acts",
        description="a list of names of ensembles, or left out for all",
    )
    force: ThreeFormulas = Field(
        default=NONE, title="external force in space (force/length)", description=WORDS + "a force per length"
    )
    couple: ThreeFormulas = Field(
        default=NONE, title="external couple in space (force)", description=WORDS + "a couple per length"
    )

    parameters: Parameters | None = Field(
        default=None,
        title="names of numbers for the formulas of this table",
        description="a table of numbers by name, such as { k = 7.0 }, for formulas",
    )

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        if raw.keys() & {"force", "couple"}:
            return []
        return [fault((), raw, ": force or couple: missing; give one of them, or both")]

    @property
    def texts(self) -> tuple[str, ...]:
        """The six formulas of force and couple, with the numbers of parameters in them."""
        return tuple(with_values(part, self.parameters) for part in (*self.force, *self.couple))

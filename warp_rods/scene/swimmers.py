"""The table [[swimmers]] of a scene."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, get_args

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, Tag

from warp_rods.scene.along import OR_ALONG, OR_IN_TIME, NumberAlong, PositiveAlong
from warp_rods.scene.behaviour import BEHAVIOURS, BehaviourTable
from warp_rods.scene.body import BodyTable
from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.ends import EndOrKind
from warp_rods.scene.ensemble import MOST_NODES, EnsembleTable, OrAuto, length_faults
from warp_rods.scene.flagella import (
    DEFAULT_LAW,
    LAWS,
    ODD_TARGET,
    TARGET,
    WITHOUT_BEHAVIOUR,
    FlagellaTable,
    is_odd,
    needs_target,
)
from warp_rods.scene.parameters import ParametersEach, names_of
from warp_rods.scene.per_rod import ONE, OR_EACH, TABLE, Direction, NumberEach, Vector, WordOrTable
from warp_rods.scene.shapes import ShapeTable, each_of_start

__all__ = ["Arrangement", "FreePlacement", "ShapeTable", "SwimmersTable"]


class FreePlacement(Table):
    """Initial positions of swimmers: middle points and directions of the tangent there [rod, 3]."""

    position: tuple[Vector, ...] = Field(
        title="places of the middle of each rod, or of its held end (L)",
        description="a list of points [x, y, z], one for each rod",
    )
    direction: tuple[Direction, ...] | None = Field(
        None,
        title="directions of the tangent there",
        description="a list of directions [dx, dy, dz], one for each rod; along x where left out",
    )


Arrangement = Literal["random", "aligned", "polar lanes", "nematic lanes", "bands"]
ARRANGEMENTS = [f'"{name}"' for name in get_args(Arrangement)]


def _odd(nodes: int) -> int:
    if nodes % 2 == 0:
        raise ValueError("even")
    return nodes


class NaturalBend(Table):
    """Natural bending about the second and about the third director."""

    second: NumberAlong = Field(
        default=0.0, title="natural bending Ω₁ about the second director (1/L)", description="a number" + OR_IN_TIME
    )
    third: NumberAlong = Field(
        default=0.0, title="natural bending Ω₂ about the third director (1/L)", description="a number" + OR_IN_TIME
    )


def _bend_or_both(value: Any) -> str:
    return TABLE if isinstance(value, NaturalBend) or (isinstance(value, dict) and "nodes" not in value) else ONE


BendOrBoth = Annotated[
    Annotated[NumberAlong, Tag(ONE)] | Annotated[NaturalBend, Tag(TABLE)], Discriminator(_bend_or_both)
]


class SwimmersTable(EnsembleTable):
    """An ensemble of active free rods (chapter 4) with dimensionless parameters."""

    FEWEST_NODES: ClassVar[int] = 17

    nodes: OrAuto[Annotated[int, Field(ge=FEWEST_NODES, le=MOST_NODES), AfterValidator(_odd)]] = Field(
        title='number of nodes along each rod; "auto" for as many as 1 % needs',
        description='an odd whole number, 17 or more, at most 100 000, or "auto"',
    )
    body: BodyTable | None = Field(
        default=None,
        title="the cell in SI, from which [units] and the drags follow",
        description="a table { length, diameter, viscosity, speed } in SI, or thrust in place of speed",
    )
    bend: PositiveAlong = Field(title="bending stiffness β⊥ = B⊥/(f*L³)", description="a positive number" + OR_ALONG)
    twist: PositiveAlong = Field(title="twist stiffness β∥ = B∥/(f*L³)", description="a positive number" + OR_ALONG)
    moment: NumberEach = Field(
        default=0.0,
        title="active moment M; the flagella exert M f per length about the tangent (L)",
        description="a number" + OR_EACH,
    )
    couple: NumberAlong | None = Field(
        default=None,
        title="external couple per length about the tangent (f*L); 0 if left out",
        description="a number" + OR_IN_TIME,
    )
    drag_ratio: PositiveAlong = Field(
        default=2.0, title="drag ratio η = ζ⊥/ζ∥", description="a positive number" + OR_ALONG
    )
    drag_along: PositiveAlong | None = Field(
        default=None,
        title="drag ζ∥, in units of that by which all is dimensionless; 1 if left out",
        description="a positive number" + OR_ALONG,
    )
    rotational_drag: PositiveAlong = Field(
        default=3e-3,
        title="rotational drag ηr = ζr/(ζ∥L²) about the tangent",
        description="a positive number" + OR_ALONG,
    )
    parameters: ParametersEach | None = Field(
        default=None,
        title="names of numbers for the formulas of this table",
        description="a table of numbers by name, such as { k = 7.0 }, for formulas" + OR_EACH,
    )
    natural_bend: BendOrBoth | None = Field(
        default=None,
        title="natural bending Ω₂ of the material, or Ω₁ and Ω₂ (1/L); 0 if left out",
        description="a number" + OR_IN_TIME + ", or a table { second, third } of two such values",
    )
    natural_twist: NumberAlong | None = Field(
        default=None, title="natural twist Ω₀ of the material (1/L); 0 if left out", description="a number" + OR_IN_TIME
    )
    ends: tuple[EndOrKind, EndOrKind] | None = Field(
        default=None,
        title="what holds, moves or loads the ends; both are free if left out",
        description='two ends, the first and the last, each "free", "hinged", "clamped", or a table { kind, … }',
    )
    flagella: FlagellaTable = Field(
        default_factory=FlagellaTable,
        title="flagellar field f, the active force per length along the tangent",
        description="a table { relaxation, diffusion, profile, sharpness, law }",
    )
    behaviour: BehaviourTable | None = Field(
        default=None,
        title="what the flagella do at random times, with the law driven",
        description="a table of behaviours, such as { reversal = { rate = 0.5 } }",
    )
    shape: ShapeTable = Field(
        default_factory=ShapeTable,
        title="shape of the rods at the start",
        description="a table such as { mode, amplitude }, { bend, twist }, { points, smoothing } or { run, frame }",
    )
    symmetric: bool = Field(
        default=False, title="whether the symmetry under rotation by π is kept exactly", description="true or false"
    )
    placement: WordOrTable[Arrangement, FreePlacement] | None = Field(
        default=None,
        title="where rods start; at the origin along x, or random in a box, if left out",
        description=f"a table {{ position, direction }}, or in a box one of {', '.join(ARRANGEMENTS)}",
    )

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        plain_keys = ("bend", "twist", "moment", "drag_ratio", "drag_along", "rotational_drag", "couple")
        nested = ("shape.amplitude", "shape.perturbation", "placement.position", "placement.direction")
        of_flagella = [f"flagella.{name}" for name in _each_rod_of_flagella(raw.get("flagella"))]
        random = [f"behaviour.{name}.{key}" for name, row in BEHAVIOURS.items() for key in row.parameters]
        named = [f"parameters.{name}" for name in names_of(raw)]
        each = (*plain_keys, *nested, *of_flagella, *random, *named)
        return [*length_faults(raw, good, each), *each_of_start(raw, good), *_activity_faults(raw, good)]


def _activity_faults(raw: dict[str, Any], good: dict[str, Any]) -> Faults:
    """What flagella, behaviour and symmetry do not agree on."""
    symmetric, behaviour = good.get("symmetric") is True, good.get("behaviour")
    faults = []
    if symmetric and behaviour:
        faults.append(fault(("symmetric",), True, f" = true: {WITHOUT_BEHAVIOUR}; leave one of them out"))
    if "flagella" in raw and "flagella" not in good:
        return faults
    flagella = good.get("flagella", {})
    name = flagella.get("law", DEFAULT_LAW)
    if behaviour and (text := needs_target(name)):
        faults.append(fault(("behaviour",), behaviour, text))
    if symmetric and LAWS[name].has_target:
        target = [np.array(flagella.get(key, LAWS[name].parameters[key].default)) for key in TARGET]
        fits = len({part.shape for part in target if part.ndim}) < 2  # a fault of its own
        if fits and not is_odd(*target).all():
            faults.append(fault(("symmetric",), True, f" = true: {ODD_TARGET}"))
    return faults


def _each_rod_of_flagella(table: Any) -> list[str]:
    """Keys of the table of flagella that may have one value per rod."""
    law = LAWS.get(str(table.get("law", DEFAULT_LAW))) if isinstance(table, dict) else None
    return ["relaxation", "diffusion", *(law.parameters if law else ())]

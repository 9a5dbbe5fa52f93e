"""The body of a swimmer in SI: what its units, its drags and its groups follow from (docs/model.md §1.6)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal, NamedTuple

from pydantic import Field

from warp_rods import arguments
from warp_rods.errors import SceneError, named
from warp_rods.quantities import FORCE, LENGTH, Dimension, parse
from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.units import QuantityText
from warp_rods.values import shown

__all__ = ["DRAGS", "BodyTable", "Drag", "drag_of_rod"]

SPEED, VISCOSITY = Dimension(1, -1), Dimension(-2, 1, 1)
SHORTEST = 2.0
"""Length over diameter from which on the corrections of the ends hold."""


class Drag(NamedTuple):
    """Drag along and across a rod, force per length and velocity, and about it, couple per length and rate."""

    along: float
    across: float
    about: float


def _slender(ratio: float) -> Drag:
    """To leading order in ln(L/d), as in appendix C.2; η = 2. About its axis as an infinite cylinder."""
    along = 2 * math.pi / math.log(ratio)
    return Drag(along, 2 * along, math.pi / ratio**2)


def _cylinder(ratio: float) -> Drag:
    """A cylinder with flat ends, by Tirado and García de la Torre, J. Chem. Phys. 71, 2581 (1979) and 73, 1986 (1980).

    Fits for 2 ≤ L/d ≤ 30; above, the terms in d/L vanish.
    """
    d = 1 / ratio
    along = 2 * math.pi / (math.log(ratio) - 0.207 + 0.980 * d - 0.133 * d**2)
    across = 4 * math.pi / (math.log(ratio) + 0.839 + 0.185 * d + 0.233 * d**2)
    return Drag(along, across, 3.841 * math.pi / 4 * d**2 * (1 + 0.677 * d - 0.183 * d**2))


DRAGS: dict[str, Callable[[float], Drag]] = {"slender": _slender, "cylinder": _cylinder}
"""Drag of a rod by name: functions of L/d, for L = 1 and a viscosity of 1."""


def drag_of_rod(length: float, diameter: float, viscosity: float = 1.0, law: str = "cylinder") -> Drag:
    """Drag of a straight rod per length: ``along`` ζ∥, ``across`` ζ⊥, ``about`` ζr, in the units of the arguments.

    law: "cylinder", with the ends (Tirado and García de la Torre: ζ⊥/ζ∥ = 1.39, 1.48, 1.62 at L/d = 10, 20, 100), or
    "slender", ζ∥ = 2πμ/ln(L/d), ζ⊥ = 2ζ∥ (appendix C.2). ``across/along`` is ``drag_ratio`` of ``FreeRods``, and
    ``about/(along L²)`` ``rotational_drag``. Raises SceneError for L < 2d, and values that are not positive.
    """
    drag = named(DRAGS, "law", law)
    given = {"length": length, "diameter": diameter, "viscosity": viscosity}
    length, diameter, viscosity = (arguments.real(name, value) for name, value in given.items())
    if length < SHORTEST * diameter:
        raise SceneError(
            f"length = {length:g}: must be at least {SHORTEST:g} diameters, and the diameter is {diameter:g}"
        )
    along, across, about = drag(length / diameter)
    return Drag(viscosity * along, viscosity * across, viscosity * length**2 * about)


class BodyTable(Table):
    """The body of swimmers in SI, by which one unit of length is L, of force f*L, and of time ζ∥L/f*."""

    length: QuantityText[LENGTH] = Field(
        title="length of the cell, one unit of length", description='a length in quotes, such as "20 um": L of the rod'
    )
    diameter: QuantityText[LENGTH] = Field(
        title="diameter d of the cell, from which its drags follow", description='a length in quotes, such as "0.8 um"'
    )
    viscosity: QuantityText[VISCOSITY] = Field(
        title="viscosity μ of the fluid", description='a viscosity in quotes, such as "1 mPa s"'
    )
    speed: QuantityText[SPEED] | None = Field(
        default=None,
        title="speed by which one unit of time is L/speed, in place of thrust",
        description='a speed in quotes, such as "25 um/s": f*/ζ∥ of a straight rod that is pushed alike',
    )
    thrust: QuantityText[FORCE] | None = Field(
        default=None,
        title="thrust of the flagella, one unit of force, in place of speed",
        description='a force in quotes, such as "0.5 pN": f*L of a rod that is pushed alike',
    )
    drag: Literal["slender", "cylinder"] = Field(
        default="slender",
        title="law by which ζ∥, ζ⊥ and ζr follow from L, d and μ",
        description='"slender", with ζ⊥ = 2ζ∥, or "cylinder", by the ratio of length and diameter',
    )

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        faults = []
        if ("speed" in raw) == ("thrust" in raw):
            faults.append(fault((), raw, ": speed or thrust: one follows from the other; give one of them"))
        if {"length", "diameter"} <= good.keys():
            ratio = parse(good["length"]).value / parse(good["diameter"]).value
            if ratio < SHORTEST:
                text = f" = {shown(good['diameter'])}: the length must be at least {SHORTEST:g} diameters"
                faults.append(fault(("diameter",), good["diameter"], text))
        return faults

    @property
    def metres(self) -> float:
        """L in m."""
        return float(parse(self.length).value)

    @property
    def drags(self) -> Drag:
        """ζ∥, ζ⊥ in N s/m², ζr in N s."""
        return drag_of_rod(
            self.metres, float(parse(self.diameter).value), float(parse(self.viscosity).value), self.drag
        )

    @property
    def force(self) -> float:
        """f*L in N."""
        if self.thrust is not None:
            return float(parse(self.thrust).value)
        assert self.speed is not None  # one of the two is given
        return self.drags.along * float(parse(self.speed).value) * self.metres

    @property
    def seconds(self) -> float:
        """ζ∥L/f* in s."""
        return self.drags.along * self.metres**2 / self.force

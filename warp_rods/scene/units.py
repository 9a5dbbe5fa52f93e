"""The table [units] of a scene, and numbers in these units."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from warp_rods.quantities import FORCE, LENGTH, TIME, Dimension, QuantityError, parse, si_words, words
from warp_rods.scene.checks import Table
from warp_rods.values import LARGEST, SMALLEST

__all__ = ["QuantityText", "Scale", "Units", "metres"]

BASE = {"length": LENGTH, "time": TIME, "force": FORCE}
"""Key of [units] → its dimension."""
POWER = re.compile(r"-?[0-9]{1,2}")
EXAMPLES = {"length": '"1 um"', "time": '"1 s"', "force": '"1 pN"'}


def quantity_text(dimension: Dimension) -> Any:
    """A check that a text is a positive quantity of a dimension."""

    def check(text: str) -> str:
        try:
            found = parse(text)
        except QuantityError as error:
            raise PydanticCustomError("note", "{text}", {"text": str(error)}) from None
        if found.dimension != dimension:
            note = f"it is {words(found.dimension)}"
            raise PydanticCustomError("note", "{text}", {"text": note})
        if not SMALLEST <= found.value <= LARGEST:
            raise PydanticCustomError("note", "{text}", {"text": "it is not positive, or too large or small"})
        return text

    return check


class _OfDimension:
    """``QuantityText[dimension]``: a positive quantity of a dimension, as text."""

    def __getitem__(self, dimension: Dimension) -> Any:
        return Annotated[str, AfterValidator(quantity_text(dimension))]


QuantityText: Any = _OfDimension()


class Units(Table):
    """What one unit of length, time and force of the scene is. Quantities with a unit need those of their dimension."""

    length: QuantityText[LENGTH] = Field(
        title="what one unit of length is",
        description='a positive number and a unit of length in quotes, such as "1 um"',
    )
    time: QuantityText[TIME] | None = Field(
        default=None,
        title="what one unit of time is, for quantities that have it",
        description='a positive number and a unit of time in quotes, such as "1 s", or left out',
    )
    force: QuantityText[FORCE] | None = Field(
        default=None,
        title="what one unit of force is, for quantities that have it",
        description='a positive number and a unit of force in quotes, such as "1 pN", or left out',
    )

    @property
    def metres(self) -> float:
        """One unit of length in metres."""
        return metres(self.length)

    @property
    def said(self) -> str:
        """The units on one line, as ``Scale.read`` takes them: "length 1 um, time 1 s"."""
        return ", ".join(f"{key} {value}" for key, value in self.model_dump(exclude_none=True).items())

    @property
    def scale(self) -> Scale:
        """The units as numbers."""
        return Scale.of(self.model_dump(exclude_none=True))


@dataclass(frozen=True)
class Scale:
    """One unit of length, time and force in SI, exact; of those that are given."""

    units: Mapping[str, Fraction]

    @classmethod
    def of(cls, table: Mapping[str, Any]) -> Scale:
        """From a table [units]; keys with a fault count as left out."""
        found = {}
        for key, dimension in BASE.items():
            try:
                value, given = parse(table[key])
            except (KeyError, TypeError, QuantityError):
                continue
            if given == dimension and value > 0:
                found[key] = value
        return cls(found)

    @classmethod
    def read(cls, said: str) -> Scale:
        """From ``Units.said``; without units from any other text."""
        return cls.of(dict(part.split(" ", 1) for part in said.split(", ") if " " in part))

    def missing(self, dimension: Dimension) -> list[str]:
        """Keys of [units] that quantities of this dimension need, and that are not given."""
        return [key for key, power in zip(BASE, dimension, strict=True) if power and key not in self.units]

    def one(self, dimension: Dimension) -> Fraction:
        """The unit of a dimension in SI; of dimensions with whole powers whose units are given."""
        factor = Fraction(1)
        for key, power in zip(BASE, dimension, strict=True):
            factor *= self.units[key] ** power if power else 1
        return factor

    def in_si(self, product: str) -> str:
        """Units such as "force*length^2/time" as a number and a unit in SI: "4e-10 N m^2/s"; as they are without it."""
        number, unit = self.number_in_si(product)
        return f"{number!r} {unit}" if unit else product

    def number_in_si(self, product: str) -> tuple[float, str]:
        """The number and the unit of ``in_si``; 1 and nothing where there are none."""
        dimension = dimension_of(product)
        if dimension is None or not any(dimension) or self.missing(dimension):
            return 1.0, ""
        try:
            number = float(self.one(dimension))
        except OverflowError:
            return 1.0, ""
        return (number, si_words(dimension)) if number else (1.0, "")


def dimension_of(product: str) -> Dimension | None:
    """The dimension of "1/length", "force*length^2/time"; None where a factor is not a whole power of a unit."""
    powers = dict.fromkeys(BASE, 0)
    for i, part in enumerate(product.split("/")):
        for factor in part.split("*"):
            name, _, power = factor.partition("^")
            if name in powers and (not power or POWER.fullmatch(power)):
                powers[name] += (-1 if i else 1) * int(power or 1)
            elif name != "1" or power:
                return None
    return Dimension(*powers.values())


def metres(text: Any) -> float:
    """A length such as "1 um" in metres; NaN where the text is not a length."""
    try:
        value, dimension = parse(text)
    except (TypeError, QuantityError):
        return math.nan
    return float(value) if dimension == LENGTH else math.nan

"""Quantities with a unit as text, such as "500 nm" or "2e-23 N m^2": their values in SI, exact, and their dimensions.

Base units of ``BASE`` are read here; all others by Pint, which is imported where one is met.
"""

from __future__ import annotations

import functools
import itertools
import re
from fractions import Fraction
from math import prod
from typing import Any, NamedTuple

from warp_rods.documented import Documented

__all__ = [
    "LENGTH",
    "NONE",
    "Dimension",
    "Quantity",
    "QuantityError",
    "is_quantity",
    "may_be_inverse",
    "parse",
    "si_words",
    "with_prefixes",
    "words",
]

BASE = {
    "m": ("m", 0), "cm": ("m", -2), "mm": ("m", -3), "um": ("m", -6), "µm": ("m", -6), "μm": ("m", -6),
    "nm": ("m", -9), "s": ("s", 0), "ms": ("s", -3), "N": ("N", 0), "nN": ("N", -9), "pN": ("N", -12),
}  # fmt: skip
"""Unit → its unit in SI, and the power of ten."""
NUMBER = r"([-+]?(?:[0-9]{1,30}\.?[0-9]{0,30}|\.[0-9]{1,30})(?:[eE][-+]?[0-9]{1,3})?)"
UNIT = r"[^\W\d_]{1,30}(?:(?:\^|\*\*)-?[0-9])?"
QUANTITY = re.compile(rf"\s*{NUMBER}\s*({UNIT}(?:\s*[ */·]\s*{UNIT}){{0,7}})\s*")
"""A number, and units with powers between which are spaces, * or /. No formula has a letter after a number."""
INVERSE = re.compile(rf"\s*{NUMBER}(?:\s+1)?\s*/\s*({UNIT}(?:\s*[ */·]\s*{UNIT}){{0,7}})\s*")
"""A number over units, such as "0.5/um" or "0.5 1/um"; it may be a formula, too."""
FACTOR = re.compile(r"([Nms])(?:\^([0-9]+))?")
PREFIXES = {"N": ("p", "n", "µ", "m", "", "f"), "m": ("µ", "n", "m", ""), "s": ("", "m", "µ")}
"""A factor of a unit in SI, and the prefixes that it may have, the first ones rather."""
POWERS = {"": 1.0, "m": 1e-3, "µ": 1e-6, "n": 1e-9, "p": 1e-12, "f": 1e-15}
NOT_UNITS = {"point", "points"}
"""What follows a number in texts that are no quantities."""


VARIABLES = {"s", "t"}
"""Units that are variables of formulas, too."""


class QuantityError(ValueError, metaclass=Documented):
    """A text that is no quantity; the message says why."""


class Dimension(NamedTuple):
    """The powers of length, time and force in a dimension."""

    length: Any = 0
    time: Any = 0
    force: Any = 0


class Quantity(NamedTuple):
    """A value in SI (m, s, N), and its dimension."""

    value: Fraction
    dimension: Dimension


NONE, LENGTH, TIME, FORCE = Dimension(), Dimension(1), Dimension(0, 1), Dimension(0, 0, 1)
OF_BASE = {"m": LENGTH, "s": TIME, "N": FORCE}
WORDS = {
    NONE: "a number", LENGTH: "a length", TIME: "a time", FORCE: "a force", Dimension(1, -1): "a speed",
    Dimension(-2, 1, 1): "a viscosity", Dimension(2, 0, 1): "a stiffness", Dimension(1, 0, 1): "a couple",
    Dimension(-1, 0, 1): "a force per length", Dimension(-1): "an inverse length", Dimension(0, -1): "a rate",
}  # fmt: skip
"""What quantities of a dimension are called."""


def is_quantity(text: Any) -> bool:
    """Whether a text is a number and something that may be a unit; formulas are not."""
    found = QUANTITY.fullmatch(text) if isinstance(text, str) else None
    return found is not None and found[2] not in NOT_UNITS


def may_be_inverse(text: Any, wanted: Dimension | None) -> bool:
    """Whether a text such as "0.5/um" is a quantity of a dimension, rather than a formula; None: of any."""
    found = INVERSE.fullmatch(text) if isinstance(text, str) else None
    if found is None:
        return False
    try:
        dimension = parse(text).dimension
    except QuantityError:
        return False
    return found[2] not in VARIABLES if wanted is None else dimension == wanted


@functools.lru_cache(maxsize=512)
def parse(text: str) -> Quantity:
    """The quantity in a text; raises QuantityError for an unknown unit, and for one that is not of mechanics."""
    found = QUANTITY.fullmatch(text) or INVERSE.fullmatch(text)
    if found is None:
        raise QuantityError('it is not a number and a unit, such as "500 nm"')
    number, unit = Fraction(found[1]), found[2]
    if found.re is INVERSE:
        factor, dimension = _by_pint(f"1/{unit}")
        return Quantity(number * factor, dimension)
    if unit in BASE:
        root, power = BASE[unit]
        return Quantity(number * Fraction(10) ** power, OF_BASE[root])
    factor, dimension = _by_pint(unit)
    return Quantity(number * factor, dimension)


def words(dimension: Dimension) -> str:
    """A dimension in words, with an example of its unit in SI."""
    unit = si_words(dimension)
    name = WORDS.get(dimension)
    return f"{name}, in {unit}" if name and unit else name or f"in {unit}"


def si_words(dimension: Dimension) -> str:
    """The unit in SI of a dimension: "N m^2", "m/s"; empty for a number."""
    powers = list(zip(("N", "m", "s"), (dimension.force, dimension.length, dimension.time), strict=True))
    above = " ".join(_power(unit, p) for unit, p in powers if p > 0)
    below = [_power(unit, -p) for unit, p in powers if p < 0]
    return "/".join([above or "1", *below]) if above or below else ""


def with_prefixes(number: float, unit: str) -> tuple[float, str]:
    """A number of a unit in SI such as "N m^2/s", and the unit, with the prefixes that make it a number from 1 to 1000.

    The usual ones of small rods come first, and as few as possible: 1e-06 m/s is 1 µm/s, 1e-18 N m 1 pN µm. As they are
    where there are none.
    """
    factors = FACTOR.findall(unit)
    found = []
    for chosen in itertools.product(*(PREFIXES[name] for name, _ in factors)):
        each = zip(chosen, factors, _signs(unit), strict=True)
        size = prod(POWERS[prefix] ** (sign * int(power or 1)) for prefix, (_, power), sign in each)
        left = float(f"{number / size:.12g}")
        if 1 <= left < 1000:
            found.append((left, sum(map(bool, chosen)), chosen))
    if not found:
        return number, unit
    left, _, chosen = min(found, key=lambda one: one[:2])  # the first of equal ones
    names = iter(chosen)
    return left, FACTOR.sub(lambda match: next(names) + match[0], unit)


def _signs(unit: str) -> list[int]:
    """1 for each factor above the fraction bar, −1 for those below."""
    return [-1 if "/" in unit[: match.start()] else 1 for match in FACTOR.finditer(unit)]


def _power(unit: str, power: Any) -> str:
    return unit if power == 1 else f"{unit}^{power}"


@functools.lru_cache(maxsize=256)
def _by_pint(unit: str) -> tuple[Fraction, Dimension]:
    """One unit in SI, and its dimension."""
    import pint

    try:
        found = _registry().Quantity(Fraction(1), unit.replace("·", "*")).to_base_units()
    except pint.errors.UndefinedUnitError as error:
        raise QuantityError(f"{error}".replace("in the unit registry", "as a unit")) from None
    except (pint.errors.PintError, ArithmeticError, SyntaxError, TypeError, ValueError, AssertionError, LookupError,
            AttributeError):  # fmt: skip
        raise QuantityError(f"{unit} cannot be read as a unit") from None
    powers = dict(found.dimensionality)
    mass, length, time = (powers.pop(f"[{name}]", 0) for name in ("mass", "length", "time"))
    if powers:
        raise QuantityError(f"{unit} is no unit of length, time and force")
    return Fraction(found.magnitude), Dimension(_whole(length - mass), _whole(time + 2 * mass), _whole(mass))


@functools.cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(non_int_type=Fraction)


def _whole(power: Any) -> Any:
    return int(power) if power == int(power) else Fraction(power)

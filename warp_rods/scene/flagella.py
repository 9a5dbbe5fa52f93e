"""The flagella of swimmers: the tables of activity laws and of profiles, and the table ``flagella`` of a scene.

To add a law: a function, a number and a branch in ``kernels/free/flagella.py``, and a row of ``LAWS`` here with the
name of that number and the additional parameters of the law. To add a profile: a row of ``PROFILES``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, TypeAdapter, ValidationError

from warp_rods.scene.checks import Faults, Table, fault
from warp_rods.scene.per_rod import OR_EACH, NumberEach, PositiveEach, ZeroOrMoreEach
from warp_rods.values import Positive, must_be, nearest, plain

__all__ = [
    "LAWS", "ODD_TARGET", "PROFILES", "WITHOUT_BEHAVIOUR", "FlagellaTable", "Law", "LawParameter", "is_odd",
    "needs_target",
]  # fmt: skip

ALLOWED: dict[str, tuple[Any, str]] = {
    "any number": (NumberEach, "a number"),
    "positive": (PositiveEach, "a positive number"),
    "zero or more": (ZeroOrMoreEach, "0 or a positive number"),
}
"""Kinds of allowed values of a parameter of a law: type, and description."""


TARGET = ("front", "back")
"""The first parameters of a law with a target of f at s > 0 and at s < 0, on which behaviours act."""
ODD_TARGET = "the target of the flagella must be odd: front = -back"
"""Where the symmetry under rotation by π is imposed."""
WITHOUT_BEHAVIOUR = "a behaviour could break the symmetry"


@dataclass(frozen=True)
class LawParameter:
    """A parameter of a law, common to all rods or one value per rod: meaning, default, and a key of ``ALLOWED``."""

    meaning: str
    default: float
    allowed: str = "any number"

    @property
    def words(self) -> str:
        """What is allowed."""
        return ALLOWED[self.allowed][1] + OR_EACH


@dataclass(frozen=True)
class Law:
    """An activity law: the name of its number in ``kernels/free/flagella.py``, and at most four parameters of its own.

    The kernel gets them as ``parameters``, in this order. ``diffuses``: whether the flagellar field diffuses along the
    rod; if not, the key ``diffusion`` plays no part.
    """

    kernel: str
    parameters: Mapping[str, LawParameter] = field(default_factory=dict)
    diffuses: bool = True

    @property
    def has_target(self) -> bool:
        """Whether f follows a target, which the first two parameters give."""
        return tuple(self.parameters)[:2] == TARGET


LAWS: dict[str, Law] = {
    "relaxing": Law("RELAXING"),
    "held": Law("HELD", diffuses=False),
    "driven": Law(
        "DRIVEN",
        {
            "front": LawParameter("target of the flagellar field f at s > 0 (f*)", 1.0),
            "back": LawParameter("target of the flagellar field f at s < 0 (f*)", 1.0),
            "steepness": LawParameter(
                "factor of s in the tanh by which the target goes from back to front (1/L)", 10.0, "positive"
            ),
        },
    ),
}
"""``relaxing``: τf ∂t f = (1 − f²) u0 + D f'' (4.12). ``held``: f stays as it is at the start, whatever τf and D.
``driven``: τf ∂t f = g(s) − f + D f'' with the target g, from ``back`` at s < 0 to ``front`` at s > 0."""
DEFAULT_LAW = "relaxing"
"""Not written into scenes that do not name a law, so that scenes of earlier versions keep their hash."""


def needs_target(law: str) -> str:
    """The fault of a behaviour of flagella with this law; empty where there is none."""
    if LAWS[law].has_target:
        return ""
    others = " or ".join(f'"{name}"' for name, row in LAWS.items() if row.has_target)
    return f": acts on the target of the flagella, which the law {law} does not have; use flagella.law = {others}"


def is_odd(front: Any, back: Any) -> np.ndarray:
    """Whether a target that goes from ``back`` to ``front`` is odd, up to round-off; numbers, or arrays [rod]."""
    return np.asarray(np.isclose(front, np.negative(back), rtol=1e-9, atol=0.0))


PROFILES: dict[str, Callable[[np.ndarray, float], np.ndarray]] = {
    "tanh": lambda s, sharpness: -np.tanh(sharpness * s),
    "piecewise": lambda s, sharpness: -np.sign(s),
    "uniform": lambda s, sharpness: np.ones_like(s),
    "none": lambda s, sharpness: np.zeros_like(s),
}
"""f(s, 0) by name: compressive, smooth or with a jump at the middle (4.38); uniform; none, of passive rods with the law
``held``."""


def _known(table: Mapping[str, Any]) -> AfterValidator:
    def check(name: str) -> str:
        if name not in table:
            raise ValueError("not in the table")
        return name

    return AfterValidator(check)


def _one_of(table: Mapping[str, Any]) -> str:
    return "one of " + ", ".join(f'"{name}"' for name in table)


class FlagellaTable(Table):
    """The flagellar field (4.12): how it starts, and how it changes in time.

    A law may have parameters of its own besides these keys.
    """

    model_config = ConfigDict(extra="allow")

    relaxation: PositiveEach = Field(
        default=1e-2,
        title="relaxation time τf of the flagellar field f (ζ∥L/f*)",
        description="a positive number" + OR_EACH,
    )
    diffusion: ZeroOrMoreEach = Field(
        default=1e-3,
        title="diffusion D = ζ∥D_f/(f*L) of the flagellar field f",
        description="0 or a positive number" + OR_EACH,
    )
    profile: Annotated[str, _known(PROFILES)] = Field(
        default="tanh", title="flagellar field f(s) at the start", description=_one_of(PROFILES)
    )
    sharpness: Positive = Field(
        default=10.0,
        title="factor of s in f = −tanh(sharpness·s) at the start (1/L)",
        description="a positive number: the steepness of the profile tanh",
    )
    law: Annotated[str, _known(LAWS)] | None = Field(
        default=None,
        title="activity law, by which the flagellar field f changes in time",
        description=f"{_one_of(LAWS)}; {DEFAULT_LAW} where left out",
    )

    @property
    def law_parameters(self) -> dict[str, Any]:
        """The parameters of the law by name, defaults filled in."""
        return dict(self.model_extra or {})

    @classmethod
    def filled(cls, data: dict[str, Any]) -> dict[str, Any]:
        """The table with the defaults of the parameters of the law."""
        law = LAWS.get(str(data.get("law", DEFAULT_LAW)))
        defaults = {} if law is None else {name: row.default for name, row in law.parameters.items()}
        return {**defaults, **data}

    @classmethod
    def cross_faults(cls, raw: dict[str, Any], good: dict[str, Any]) -> Faults:
        """Unknown keys, and wrong values of the parameters of the law."""
        name = raw.get("law", DEFAULT_LAW)
        if not isinstance(name, str) or name not in LAWS:
            return []  # already a fault
        own = LAWS[name].parameters
        faults = []
        for key in raw.keys() - cls.model_fields.keys():
            known = [*cls.model_fields, *own]
            if key not in own:
                text = f": unknown key{nearest(key, known)}; known here, with the law {name}: {', '.join(known)}"
                faults.append(fault((key,), raw[key], text))
            elif text := _fault_of(raw[key], own[key]):
                faults.append(fault((key,), raw[key], text))
        return faults


def _fault_of(value: Any, parameter: LawParameter) -> str:
    """The fault of a value of a parameter of a law; empty where there is none."""
    kind, _ = ALLOWED[parameter.allowed]
    try:
        TypeAdapter(kind, config=ConfigDict(strict=True)).validate_python(plain(value))
    except ValidationError:
        return must_be(parameter.words, value)
    return ""

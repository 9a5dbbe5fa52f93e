"""The common representation of all kinds of surface: a field φ with its parameters, and a box around the surface."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

__all__ = ["Box", "Data", "Described", "Fault", "Kind", "LevelSet", "MovingKind", "Values"]

Box = tuple[np.ndarray, np.ndarray]
"""Lower and upper corner [3]."""
Values = Mapping[str, Any]
"""The values of a table [surface] by their keys, without its kind."""
Fault = tuple[tuple[str | int, ...], str]
"""The key path of a wrong value below the table [surface], and the text that follows it in a message."""


@dataclass(frozen=True)
class Data:
    """What became of the data of a file."""

    notes: tuple[str, ...] = ()
    """Lines for the user: what was mended, the membrane before and after it was smoothed, its bodies."""
    warnings: tuple[str, ...] = ()
    bodies: Any = None
    """The ``Bodies`` of the membrane."""
    metres: float | None = None
    """One unit of length in metres, where the file says so."""


@dataclass(frozen=True)
class LevelSet:
    """A surface φ(x) = 0 at rest; outward is where φ > 0."""

    field: Any
    """The Warp function x, p -> φ, ∇φ, ∇∇φ."""
    numbers: np.ndarray
    """The parameters of the field [8 at most], in the order of p.v."""
    box: Box
    closed: bool | None
    """Whether the surface is closed; None where this has to be found by sampling φ."""
    grid: np.ndarray | None = None
    """Spline coefficients [x, y, z] of a surface given on a grid."""
    data: Data = Data()


class Described(NamedTuple):
    """What a key means, and what is allowed, in words; its default, None where there is none."""

    meaning: str
    words: str
    default: Any = None


class Kind(Protocol):
    """A kind of surface: it checks values and makes a level set from them."""

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of its values."""

    @property
    def described(self) -> Mapping[str, Described]:
        """What each of them means, and what is allowed."""

    def read(self, raw: Values) -> tuple[dict[str, Any], list[Fault]]:
        """The values with defaults filled in, and their faults. Builds nothing."""

    def level_set(self, values: Values) -> LevelSet:
        """The surface with these values, in which formulas in t have been replaced by numbers."""


class MovingKind(Kind, Protocol):
    """A kind of surface whose values may be formulas in t."""

    def numbers(self, values: Values) -> np.ndarray:
        """The parameters of the field [8 at most] for these values, or their rates for the rates of the values."""

    def rate(self, values: Values) -> Any:
        """The Warp function x, p, dp/dt -> ∂tφ, ∇∂tφ."""

"""The dissertation's figures and numbers, each made anew by a run of this code.

To add one, write a function ``(quick) -> Result`` and give it a row of ``REPRODUCTIONS``. The numbers in brackets in
tables and figures are the dissertation's equations and sections.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from . import stiffness
from .result import Result, Row

__all__ = ["REPRODUCTIONS", "Reproduction", "Result", "Row"]


class Reproduction(NamedTuple):
    """``what`` it shows, and ``make(quick)``, which runs it: with ``quick``, a reduced form of the same."""

    what: str
    make: Callable[[bool], Result]


REPRODUCTIONS: dict[str, Reproduction] = {
    "stiffness": Reproduction("critical bending stiffness of a real cell in SI units (C.2)", stiffness.si),
}
"""By name; ``warp-rods reproduce all`` begins in this order, so that what takes longest comes first."""

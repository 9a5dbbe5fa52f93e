"""The dissertation's figures and numbers, each made anew by a run of this code.

To add one, write a function ``(quick) -> Result`` and give it a row of ``REPRODUCTIONS``. The numbers in brackets in
tables and figures are the dissertation's equations and sections.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from . import attractors, fredholm, roll_map, speeds, stiffness, symmetric
from .result import Result, Row

__all__ = ["REPRODUCTIONS", "Reproduction", "Result", "Row"]


class Reproduction(NamedTuple):
    """``what`` it shows, and ``make(quick)``, which runs it: with ``quick``, a reduced form of the same."""

    what: str
    make: Callable[[bool], Result]


REPRODUCTIONS: dict[str, Reproduction] = {
    "fig4.3a": Reproduction("a twisted U in space, from several starts", partial(attractors.attractor, "a")),
    "fig4.3b": Reproduction("waving while twisting, from several starts", partial(attractors.attractor, "b")),
    "fig4.3c": Reproduction("a twisted S, from several starts", partial(attractors.attractor, "c")),
    "fig4.3d": Reproduction("flapping in space, from several starts", partial(attractors.attractor, "d")),
    "fig4.3e": Reproduction("swimming speed against active moment", speeds.against_moment),
    "fig4.3f": Reproduction("swimming speed against bending stiffness", speeds.against_stiffness),
    "fig4.3map": Reproduction("Fig 4.3a-d over the rotational drag, which is not given", roll_map.over_rotational_drag),
    "symmetry": Reproduction("rotation by π and gauge are conserved, as a check (C.4)", symmetric.check),
    "tension": Reproduction("the series of the tension against the direct solve (C.1)", fredholm.check),
    "stiffness": Reproduction("critical bending stiffness of a real cell in SI units (C.2)", stiffness.si),
}
"""By name; ``warp-rods reproduce all`` begins in this order, so that what takes longest comes first."""

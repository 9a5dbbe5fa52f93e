"""The dissertation's figures and numbers, each made anew by a run of this code.

To add one, write a function ``(quick) -> Result`` and give it a row of ``REPRODUCTIONS``. The numbers in brackets in
tables and figures are the dissertation's equations and sections.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from warp_rods.reproductions import (
    attractors,
    bridge,
    critical,
    fredholm,
    linear,
    phase,
    roll_map,
    sensors,
    speeds,
    stiffness,
    symmetric,
    thresholds,
)
from warp_rods.reproductions.result import Result, Row

__all__ = ["REPRODUCTIONS", "Reproduction", "Result", "Row"]


class Reproduction(NamedTuple):
    """``what`` it shows; ``make(quick)``, which runs it, or a reduced form; about how many ``minutes`` on a core."""

    what: str
    make: Callable[[bool], Result]
    minutes: float = 0.1


REPRODUCTIONS: dict[str, Reproduction] = {
    "critical": Reproduction("first ten critical stiffnesses, by three theories (§4.3)", critical.stiffnesses),
    "fig4.1g": Reproduction("phase portrait of planar swimmers, down and up in stiffness", phase.portrait, 0.5),
    "fig4.1h": Reproduction("its cross-section at 1.3e-4: waving", phase.waving),
    "fig4.1i": Reproduction("its cross-section at 7.6e-5: flapping, and waving", phase.flapping),
    "fig4.2a": Reproduction("eigenvalues of a straight swimmer against its stiffness", linear.spectrum),
    "fig4.2b": Reproduction("growth rates without and with an active moment", linear.growth),
    "fig4.2c": Reproduction("unstable modes and beam modes", linear.modes),
    "fig4.3a": Reproduction("a twisted U in space, from several starts", partial(attractors.attractor, "a"), 0.3),
    "fig4.3b": Reproduction("waving while twisting, from several starts", partial(attractors.attractor, "b"), 0.3),
    "fig4.3c": Reproduction("a twisted S, from several starts", partial(attractors.attractor, "c"), 0.3),
    "fig4.3d": Reproduction("flapping in space, from several starts", partial(attractors.attractor, "d"), 0.3),
    "fig4.3e": Reproduction("swimming speed against active moment", speeds.against_moment, 2),
    "fig4.3f": Reproduction("swimming speed against bending stiffness", speeds.against_stiffness, 2),
    "fig4.3map": Reproduction("Fig 4.3a–d over the rotational drag, not given", roll_map.over_rotational_drag, 2.5),
    "thresholds": Reproduction("fold and Hopf point of the U-swimmer, window of flapping", thresholds.all_of_them, 0.6),
    "fig5.3": Reproduction("growth and buckling of a filament on the bridge between two cells", bridge.grow, 0.3),
    "fig5.4": Reproduction("100 proteins that prefer positive curvature, with and without twist", sensors.positive, 5),
    "fig5.5": Reproduction("100 proteins that prefer negative curvature, with and without twist", sensors.negative, 9),
    "symmetry": Reproduction("rotation by π and gauge are conserved, as a check (C.4)", symmetric.check),
    "tension": Reproduction("the series of the tension against the direct solve (C.1)", fredholm.check),
    "stiffness": Reproduction("critical bending stiffness of a real cell in SI units (C.2)", stiffness.si),
}
"""By name. Of several, the one with the most ``minutes`` begins first: then cores do not wait for it at the end."""

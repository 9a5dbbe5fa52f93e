"""The table of reproductions: the figures and numbers of the dissertation.

To add one, write a function ``(quick) -> Result`` and give it a row of ``REPRODUCTIONS``. Numbers in brackets in tables
and figures are equations of the dissertation.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from warp_rods.reproductions import (
    asymmetry,
    attractors,
    bridge,
    critical,
    fredholm,
    linear,
    moment,
    phase,
    rotational_drag,
    sensors,
    space,
    speeds,
    stiffness,
    symmetric,
    thresholds,
)
from warp_rods.reproductions.result import Comparison, Result

__all__ = ["REPRODUCTIONS", "Comparison", "Reproduction", "Result"]


class Reproduction(NamedTuple):
    """What it shows; ``make(quick)``, which runs it or a reduced form; its approximate ``minutes`` on one core."""

    what: str
    make: Callable[[bool], Result]
    minutes: float = 0.1


REPRODUCTIONS: dict[str, Reproduction] = {
    "critical": Reproduction("first ten critical stiffnesses, by three theories (§4.3)", critical.stiffnesses),
    "fig4.1g": Reproduction("phase portrait of planar swimmers over falling and rising stiffness", phase.portrait, 0.5),
    "fig4.1h": Reproduction("cross-section of 4.1g at β⊥ = 1.3e-4: waving", phase.waving),
    "fig4.1i": Reproduction("cross-section of 4.1g at β⊥ = 7.6e-5: flapping and waving", phase.flapping),
    "fig4.2a": Reproduction("eigenvalues of a straight swimmer against its stiffness", linear.spectrum),
    "fig4.2b": Reproduction("growth rates without and with an active moment", linear.growth),
    "fig4.2c": Reproduction("unstable modes and beam modes", linear.modes),
    "fig4.3a": Reproduction(
        "a twisted U in space, from several initial shapes", partial(attractors.attractor, "a"), 0.3
    ),
    "fig4.3b": Reproduction(
        "waving while twisting, from several initial shapes", partial(attractors.attractor, "b"), 0.3
    ),
    "fig4.3c": Reproduction("a twisted S, from several initial shapes", partial(attractors.attractor, "c"), 0.3),
    "fig4.3d": Reproduction("flapping in space, from several initial shapes", partial(attractors.attractor, "d"), 0.3),
    "fig4.3e": Reproduction("swimming speed against active moment", speeds.against_moment, 2),
    "fig4.3f": Reproduction("swimming speed against bending stiffness", speeds.against_stiffness, 2),
    "fig4.3map": Reproduction("class of motion of Fig 4.3a–d over the rotational drag", rotational_drag.class_map, 2.5),
    "asymmetry": Reproduction(
        "growth of asymmetric perturbations of the U, the S and Figs 4.3c, d (§4.4)", asymmetry.instability, 1.5
    ),
    "phases": Reproduction("classes of motion in space over β⊥ and M, with published boundaries", space.phase_map, 1.2),
    "thresholds": Reproduction("fold and Hopf point of the U-swimmer, onset of flapping", thresholds.thresholds, 0.6),
    "fig5.3": Reproduction("growth and buckling of a filament on the bridge between two cells", bridge.grow, 0.3),
    "fig5.4": Reproduction("100 proteins that prefer positive curvature, with and without twist", sensors.positive, 5),
    "fig5.5": Reproduction("100 proteins that prefer negative curvature, with and without twist", sensors.negative, 9),
    "symmetry": Reproduction("conservation of the symmetry under rotation by π and of gauge (C.4)", symmetric.check),
    "tension": Reproduction("the series of the tension against the direct solution (C.1)", fredholm.check),
    "moment": Reproduction("active moment of a cell from the shape of its flagella (§4.2)", moment.moments),
    "stiffness": Reproduction("critical bending stiffness of a real cell in SI units (C.2)", stiffness.real_cell),
}
"""By name. Of several, those with the most ``minutes`` start first, which keeps all cores busy until the end."""

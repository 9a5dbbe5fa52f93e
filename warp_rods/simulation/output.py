"""Which variables of a frame a run saves: those of the table [output], or all."""

from __future__ import annotations

from collections.abc import Mapping

from warp_rods.errors import SceneError, nearest
from warp_rods.rods.ensemble import Ensemble
from warp_rods.rods.variables import Variable
from warp_rods.scene.tables import Output

__all__ = ["ALWAYS", "check_output", "chosen"]

ALWAYS = ("position", "status")
"""Variables that every trajectory has."""


def chosen(output: Output | None, saved: Mapping[str, Variable]) -> dict[str, Variable]:
    """The variables to be saved of those that an ensemble has."""
    names = None if output is None else output.variables
    return {name: v for name, v in saved.items() if names is None or name in (*ALWAYS, *names)}


def check_output(output: Output | None, ensembles: Mapping[str, Ensemble]) -> None:
    """Raises SceneError naming every variable of [output] that no ensemble of the scene has, or that is lacking."""
    if output is None or output.variables is None:
        return
    known = sorted({name for ensemble in ensembles.values() for name in ensemble.saved})
    faults = [
        f'output.variables[{index}] = "{name}": no ensemble of this scene has it{nearest(name, known)}; known here: '
        f"{', '.join(known)}"
        for index, name in enumerate(output.variables)
        if name not in known
    ]
    if faults:
        raise SceneError("\n".join(faults))

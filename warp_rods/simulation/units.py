"""What a run says of units: those of the scene, and what the groups of swimmers with a body are in SI."""

from __future__ import annotations

from typing import TYPE_CHECKING

from warp_rods.quantities import FORCE, LENGTH, TIME, Dimension
from warp_rods.scene.units import Scale

if TYPE_CHECKING:
    from warp_rods.scene.scene import Scene
    from warp_rods.scene.swimmers import SwimmersTable

__all__ = ["lines_of_units"]

STIFFNESS = Dimension(2, 0, 1)
IN_SI = {"bend": STIFFNESS, "twist": STIFFNESS, "moment": LENGTH, "rotational_drag": Dimension(0, 1, 1)}
"""Group of swimmers → the dimension of what it stands for."""
UNITS = {STIFFNESS: "N m²", LENGTH: "m", Dimension(0, 1, 1): "N s", TIME: "s", FORCE: "N"}


def lines_of_units(scene: Scene) -> list[str]:
    """Lines for the user; none for a scene without units of time and force."""
    if scene.units is None or scene.units.time is None or scene.units.force is None:
        return []
    one = {"length": LENGTH, "time": TIME, "force": FORCE}
    parts = [f"{key} {float(scene.units.scale.one(d)):.4g} {UNITS[d]}" for key, d in one.items()]
    return [
        f"one unit is: {', '.join(parts)}",
        *(_line(table, scene.units.scale) for table in scene.swimmers if table.body),
        *_without_body(scene),
    ]


def _without_body(scene: Scene) -> list[str]:
    """Lines on swimmers without a body beside those with one, whose drags do not follow from any."""
    if not any(table.body for table in scene.swimmers):
        return []
    return [
        f"{table.name}: has no body: its drag_ratio, {table.drag_ratio}, and rotational_drag, {table.rotational_drag}, "
        f"are as given or as usual, not those of the bodies"
        for table in scene.swimmers
        if not table.body
    ]


def _line(table: SwimmersTable, scale: Scale) -> str:
    """The groups of a table, and what they stand for."""
    body = table.body
    assert body is not None  # of those that have one
    found = []
    for name, dimension in IN_SI.items():
        value = getattr(table, name)
        if isinstance(value, (int, float)) and value:
            found.append(f"{name} {value:.4g} ({value * float(scale.one(dimension)):.4g} {UNITS[dimension]})")
    along, across, _about = body.drags
    pushed = f"f*L = {body.force:.4g} N, f*/ζ∥ = {body.force / body.metres / along:.4g} m/s"
    drags = f"ζ∥ = {along:.4g} N s/m², ζ⊥/ζ∥ = {across / along:.4g}"
    return f"{table.name}: {pushed}, {drags}; {', '.join(found)}"

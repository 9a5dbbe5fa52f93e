"""What a run says of units: those of the scene, and what the groups of swimmers with a body are in SI."""

from __future__ import annotations

from typing import TYPE_CHECKING

from warp_rods.quantities import Dimension, si_words
from warp_rods.scene.dimensions import DIMENSIONS
from warp_rods.scene.units import BASE, Scale

if TYPE_CHECKING:
    from warp_rods.scene.scene import Scene
    from warp_rods.scene.swimmers import SwimmersTable

__all__ = ["lines_of_units"]

GROUPS = ("bend", "twist", "moment", "rotational_drag")
"""Groups of swimmers that stand for something in SI."""


def lines_of_units(scene: Scene) -> list[str]:
    """Lines for the user; none for a scene without units of time and force."""
    if scene.units is None or scene.units.time is None or scene.units.force is None:
        return []
    parts = [f"{key} {_in_si(1.0, dimension, scene.units.scale)}" for key, dimension in BASE.items()]
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
    for name in GROUPS:
        value, dimension = getattr(table, name), DIMENSIONS[f"swimmers.{name}"]
        if isinstance(value, (int, float)) and value and isinstance(dimension, Dimension):
            found.append(f"{name} {value:.4g} ({_in_si(value, dimension, scale)})")
    along, across, _about = body.drags
    pushed = f"f*L = {body.force:.4g} N, f*/ζ∥ = {body.force / body.metres / along:.4g} m/s"
    drags = f"ζ∥ = {along:.4g} N s/m², ζ⊥/ζ∥ = {across / along:.4g}"
    return f"{table.name}: {pushed}, {drags}; {', '.join(found)}"


def _in_si(value: float, dimension: Dimension, scale: Scale) -> str:
    """A value in units of the scene as one in SI."""
    return f"{value * float(scale.one(dimension)):.4g} {si_words(dimension).replace('^2', '²')}"

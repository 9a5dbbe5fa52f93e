"""The surfaces of a scene: its membrane, and the container of its box."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.membranes.sampling import Part
from warp_rods.membranes.surfaces import Surface, bodies_of, built
from warp_rods.scene.scene import Scene
from warp_rods.values import shown


def build_surfaces(scene: Scene) -> tuple[Surface | None, Surface | None]:
    """The membrane and the container of a scene; raises SceneError naming the faults of both."""
    found, faults = [], []
    for path, table in (("surface", scene.surface), ("box.surface", scene.box and scene.box.surface)):
        try:
            end = scene.time.end
            found.append(built(table.kind, table.parameters, path=path, end=end) if table else None)
        except SceneError as error:
            faults.append(str(error))
    if faults:
        raise SceneError("\n".join(faults))
    membrane, container = found
    return membrane, container


def part_of(surface: Surface, numbers: Sequence[int] | None) -> Part | None:
    """The part of a membrane made of these bodies, None for all of it; raises SceneError where it has no such body."""
    if numbers is None:
        return None
    bodies, chosen = bodies_of(surface), list(numbers)
    if max(chosen) >= len(bodies):
        raise SceneError(f"bodies = {chosen}: the membrane has {bodies.listed()}")
    return Part(*bodies.box(chosen), lambda x: np.isin(bodies.nearest(x), chosen))


def lines_on_data(scene: Scene, path: str, surface: Surface | None) -> tuple[list[str], list[str]]:
    """Notes and warnings on what became of the file of a surface; ``path``: the name of its table."""
    if surface is None:
        return [], []
    data, warnings = surface.data, list(surface.data.warnings)
    if data.metres and scene.units and not math.isclose(data.metres, scene.units.metres, rel_tol=1e-3):
        warnings.append(
            f"one unit of length is {data.metres:g} m in the file, and units.length = {shown(scene.units.length)}: "
            f"give spacing in units of the scene"
        )
    return [f"{path}: {line}" for line in data.notes], [f"{path}: {line}" for line in warnings]

"""The surfaces of a scene: its membrane, and the container of its box."""

from __future__ import annotations

from warp_rods.errors import SceneError
from warp_rods.membranes.surfaces import Surface, make
from warp_rods.scene.scene import Scene


def build_surfaces(scene: Scene) -> tuple[Surface | None, Surface | None]:
    """The membrane and the container of a scene; raises SceneError naming the faults of both."""
    built, faults = [], []
    for path, table in (("surface", scene.surface), ("box.surface", scene.box and scene.box.surface)):
        try:
            end = scene.time.end
            built.append(make(table.kind, table.parameters, path=path, end=end) if table else None)
        except SceneError as error:
            faults.append(str(error))
    if faults:
        raise SceneError("\n".join(faults))
    membrane, container = built
    return membrane, container

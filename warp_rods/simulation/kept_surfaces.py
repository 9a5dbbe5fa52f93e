"""What a run keeps of files in its folder, so that it does not depend on the originals: sampled fields and starts."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from warp_rods.membranes.kept import kept_bytes
from warp_rods.membranes.surface import Surface
from warp_rods.scene.scene import Scene
from warp_rods.scene.tables import SurfaceTable
from warp_rods.simulation.files import digest
from warp_rods.simulation.kept_starts import KEPT_STARTS, kept_starts, with_starts
from warp_rods.simulation.start_arrays import Given

__all__ = ["NAMES", "KeptSurfaces", "with_files"]

NAMES = {"surface": "membrane.npz", "box.surface": "container.npz", "shape": KEPT_STARTS}
"""The file in a run folder with the field of each table of a scene, and that with the shapes at the start."""


class KeptSurfaces:
    """The surfaces of a run that come from files, and the starts of its rods.

    contents: by the names of their files. origins: for each of these its own hash, and path and hash of the original.
    """

    def __init__(self, scene: Scene, surfaces: Mapping[str, Surface | None], starts: Mapping[str, Given]):
        self.contents: dict[str, bytes] = {}
        self.origins: dict[str, dict[str, Any]] = {}
        if starts:
            data, origin = kept_starts(scene, starts)
            self.contents[KEPT_STARTS], self.origins[KEPT_STARTS] = data, origin
        for key, table in from_files(scene).items():
            surface, source = surfaces[key], Path(table.parameters["file"])
            assert surface is not None and surface.grid is not None
            data = kept_bytes(surface.grid, surface.parameters, surface.box, table.parameters)
            self.contents[NAMES[key]] = data
            self.origins[NAMES[key]] = {
                "sha256": hashlib.sha256(data).hexdigest(),
                "source": str(source),
                "source_sha256": digest(source),
            }

    def keep_origins(self, earlier: Mapping[str, Mapping[str, Any]]) -> None:
        """Name the first origins of surfaces that were read from the files of a run folder, which has ``earlier``."""
        for name, origin in self.origins.items():
            before = earlier.get(name)
            if before is not None and before["sha256"] == origin["source_sha256"]:
                self.contents[name] = Path(origin["source"]).read_bytes()
                self.origins[name] = dict(before)


def from_files(scene: Scene) -> dict[str, SurfaceTable]:
    """The tables of surfaces from files, by their keys in the scene."""
    tables = {"surface": scene.surface, "box.surface": scene.box and scene.box.surface}
    return {key: table for key, table in tables.items() if table and "file" in table.parameters}


def with_files(scene: Scene, files: Mapping[str, str]) -> Scene:
    """The scene with these files for its surfaces and shapes, by the keys of their tables."""
    if "shape" in files:
        scene = with_starts(scene, files["shape"])
    changes: dict[str, Any] = {}
    for key, table in from_files(scene).items():
        if key not in files:
            continue
        given = table.model_copy(update={"file": files[key]})
        if key == "surface":
            changes["surface"] = given
        else:
            assert scene.box is not None
            changes["box"] = scene.box.model_copy(update={"surface": given})
    return scene.model_copy(update=changes)

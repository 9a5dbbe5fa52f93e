"""Surfaces from files in a run folder: their sampled fields, so that the run does not depend on the original files."""

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

__all__ = ["NAMES", "KeptSurfaces", "with_files"]

NAMES = {"surface": "membrane.npz", "box.surface": "container.npz"}
"""The file in a run folder with the field of each table of a scene."""


class KeptSurfaces:
    """The surfaces of a run that come from files.

    contents: by the names of their files. origins: for each of these its own hash, and path and hash of the original.
    """

    def __init__(self, scene: Scene, surfaces: Mapping[str, Surface | None]):
        self.contents: dict[str, bytes] = {}
        self.origins: dict[str, dict[str, str]] = {}
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

    def keep_origins(self, earlier: Mapping[str, Mapping[str, str]]) -> None:
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
    """The scene with these files for its surfaces, by the keys of their tables."""
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

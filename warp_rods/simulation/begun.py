"""The run that a folder holds, as it was begun: what may continue it, and how another scene differs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.errors import RunFolderError
from warp_rods.scene.scene import Scene
from warp_rods.scene.tables import Time
from warp_rods.simulation.document import Document
from warp_rods.simulation.files import digest
from warp_rods.simulation.frames import Frames
from warp_rods.simulation.kept_starts import KEPT_STARTS, tables_from_files
from warp_rods.simulation.kept_surfaces import NAMES, from_files, with_files
from warp_rods.simulation.resolution import with_nodes
from warp_rods.simulation.starts import kept_path, sources_of
from warp_rods.simulation.store import STORE
from warp_rods.values import key_path, shown

__all__ = ["KEPT", "Begun"]

KEPT = "kept_surfaces"
"""The attribute of the root of a store with hashes and origins of the surfaces that the folder keeps."""
MAY_CHANGE = ("time.end", "output.usd", "output.poster", "output.film", "on_failure")
"""Keys that may change: how far a run goes, also after a loss, and what is made of it at its end."""


@dataclass(frozen=True)
class Begun:
    """The run in the folder ``path``: its scene, with the surfaces that the folder keeps, and their origins."""

    path: Path
    scene: Scene
    text: str
    """The scene as the store has it, with names of kept files relative to the folder."""
    kept: Mapping[str, Mapping[str, Any]]

    @classmethod
    def read(cls, path: Path) -> Begun:
        """The run in a folder; raises RunFolderError where there is none, and SceneError for a missing surface."""
        attributes = Document.read(path / STORE).attributes
        if "scene" not in attributes:
            raise RunFolderError(f"{path / STORE} has no scene: run the scene again with --overwrite")
        text = attributes["scene"]
        return cls(path, Scene.parse(text, path.resolve()), text, attributes.get(KEPT, {}))

    def continued(self, scene: Scene) -> Scene:
        """The scene that continues the run: on its surfaces; with its nodes, step and frames where they are not given.

        What is chosen follows ``time.end``: without this no run could be made longer. Raises RunFolderError with every
        difference where ``scene`` is not that of the run, other than ``MAY_CHANGE``.
        """
        edited: dict[str, str] = {}
        files: dict[str, str] = {}
        for key, table in from_files(scene).items():
            if (origin := self.kept.get(NAMES[key])) is None:
                continue
            edited |= _edited(key, Path(table.parameters["file"]), self.path / NAMES[key], origin)
            files[key] = str(self.path.resolve() / NAMES[key])
        if KEPT_STARTS in self.kept:
            edited |= self._edited_starts(scene)
            files["shape"] = str(self.path.resolve() / KEPT_STARTS)
        scene = with_nodes(with_files(scene, files), _numbers_of_nodes(self.scene))
        time = scene.time
        if time.save_every == Time.filled({"end": time.end, "step": time.step or 0.0})["save_every"]:
            scene = _with_time(scene, save_every=self.scene.time.save_every)
        self._refuse(self._differences(scene) | edited)
        return scene

    def _edited_starts(self, scene: Scene) -> dict[str, str]:
        """A line for each shape whose file is not what the run began with, by content."""
        kept, edited = self.path / KEPT_STARTS, {}
        for key, table in tables_from_files(scene).items():
            if (path := kept_path(table)) is not None and path.resolve() == kept.resolve():
                continue
            began = {sha for _, sha in self.kept[KEPT_STARTS]["sources"].get(table.name, ())}
            for source, sha in sources_of(table, scene):
                if sha not in began:
                    edited[f"{key}.shape"] = (
                        f"{key}.shape: {source} with SHA-256 {sha} in the scene is not what the run began with: it was "
                        f"edited or is another; {kept} is the start of the run"
                    )
        return edited

    def _differences(self, scene: Scene) -> dict[str, str]:
        """A line for each key in which a scene differs from that of the run, steps as they would be taken."""
        planned = _with_time(scene, step=Frames.of(scene.time).longest_step) if scene.time.step else scene
        old, new = (dict(_leaves(s.model_dump(exclude_none=True))) for s in (self.scene, planned))
        return {
            key: f"{key}: {_said(old, key)} in the run, {_said(new, key)} in the scene"
            for key in [*old, *(key for key in new if key not in old)]
            if key not in MAY_CHANGE and not _same(key, old.get(key), new.get(key))
        }

    def _refuse(self, differences: Mapping[str, str]) -> None:
        if differences:
            lines = "\n".join(f"  {line}" for line in differences.values())
            raise RunFolderError(
                f"the run in {self.path} differs from the scene given in {', '.join(differences)}: only "
                f"{', '.join(MAY_CHANGE)} may change, to continue it\n{lines}\n"
                f"To continue the run as it was begun: warp-rods run {self.path / 'scene.toml'} --out {self.path} "
                f"--resume. To run the scene given: another --out, or --overwrite."
            )


def _same(key: str, old: Any, new: Any) -> bool:
    """Whether values are equal. The last digits of the step as run follow the number of frames."""
    if key in ("time.step", "time.save_every") and old is not None and new is not None:
        return bool(np.isclose(new, old, rtol=1e-9, atol=0))
    return old == new


def _with_time(scene: Scene, **changes: float) -> Scene:
    return scene.model_copy(update={"time": scene.time.model_copy(update=changes)})


def _numbers_of_nodes(scene: Scene) -> dict[str, int]:
    return {table.name: table.node_count for table in (*scene.filaments, *scene.swimmers, *scene.cosserat)}


def _edited(key: str, given: Path, kept: Path, origin: Mapping[str, str]) -> dict[str, str]:
    """The difference between the file of a scene and the one that the run began with, by content; empty if none."""
    if given.resolve() == kept.resolve():
        return {}
    now = digest(given)
    if now in (origin["source_sha256"], origin["sha256"]):
        return {}
    line = (
        f"{key}.file: {origin['source']} with SHA-256 {origin['source_sha256']} in the run, {given} with SHA-256 {now} "
        f"in the scene: the file was edited or is another; {kept} is the surface that the run began with"
    )
    return {f"{key}.file": line}


def _leaves(value: Any, loc: tuple[str | int, ...] = ()) -> Iterator[tuple[str, Any]]:
    """The values of a scene by their key paths; lists of numbers are single values."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _leaves(item, (*loc, key))
    elif isinstance(value, tuple) and value and isinstance(value[0], Mapping):
        for index, item in enumerate(value):
            yield from _leaves(item, (*loc, index))
    else:
        yield key_path(loc), value


def _said(leaves: Mapping[str, Any], key: str) -> str:
    return shown(leaves[key]) if key in leaves else "None" if key.startswith("time.") else "not given"

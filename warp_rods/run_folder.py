"""The folder of a run: scene as run, trajectory, checkpoint; made only when everything else is ready."""

from __future__ import annotations

import io
import os
import shutil
import tomllib
from pathlib import Path

import numpy as np

from warp_rods.errors import RunFolderError
from warp_rods.scene import Scene
from warp_rods.trajectory import STORE, GroupSpec, TrajectoryWriter

SCENE, CHECKPOINT = "scene.toml", "checkpoint.npz"
PARTS = (SCENE, STORE, CHECKPOINT, "animation.usdc")


class RunFolder:
    """``path`` and what is written there: ``writer`` appends frames, ``checkpoint`` makes a restart possible."""

    def __init__(self, path: Path, writer: TrajectoryWriter):
        self.path, self.writer = path, writer

    @staticmethod
    def check_free(path: Path, overwrite: bool) -> None:
        """Raises RunFolderError where ``path`` holds a run already and may not be overwritten, or is no folder."""
        if path.exists() and not path.is_dir():
            raise RunFolderError(f"{path} is a file: give another --out")
        if not overwrite and any((path / part).exists() for part in PARTS):
            raise RunFolderError(
                f"{path} holds a run already: give another --out, --overwrite to replace it, or --resume to go on"
            )

    @classmethod
    def create(cls, path: Path, scene: Scene, groups: dict[str, GroupSpec], attributes: dict) -> RunFolder:
        """A fresh folder; an old run's parts in it are removed."""
        path.mkdir(parents=True, exist_ok=True)
        for part in PARTS:
            target = path / part
            shutil.rmtree(target) if target.is_dir() else target.unlink(missing_ok=True)
        (path / SCENE).write_text(scene.to_toml(), encoding="utf-8")
        return cls(path, TrajectoryWriter.create(path / STORE, groups, attributes))

    @classmethod
    def resume(cls, path: Path, scene: Scene) -> tuple[RunFolder, dict[str, np.ndarray]]:
        """The folder of an unfinished run of this very scene, and its last checkpoint.

        Raises RunFolderError where there is none, or the scene differs.
        """
        if not (path / CHECKPOINT).is_file():
            raise RunFolderError(f"{path} has no {CHECKPOINT} to go on from: run without --resume")
        before = Scene.parse(tomllib.loads((path / SCENE).read_text(encoding="utf-8")))
        if before.hash() != scene.hash():
            raise RunFolderError(f"{path}/{SCENE} differs from the scene given: only the same scene can go on")
        with np.load(path / CHECKPOINT) as stored:
            state = dict(stored)
        return cls(path, TrajectoryWriter.resume(path / STORE, int(state["frame"]) + 1)), state

    def checkpoint(self, state: dict[str, np.ndarray]) -> None:
        """Replace the checkpoint in one move: whenever the machine stops, one whole checkpoint is there."""
        buffer = io.BytesIO()
        np.savez(buffer, **state)  # type: ignore[arg-type]
        partial = self.path / f".{CHECKPOINT}.partial"
        with partial.open("wb") as file:
            file.write(buffer.getbuffer())
            file.flush()
            os.fsync(file.fileno())
        partial.replace(self.path / CHECKPOINT)
        folder = os.open(self.path, os.O_RDONLY)
        os.fsync(folder)
        os.close(folder)

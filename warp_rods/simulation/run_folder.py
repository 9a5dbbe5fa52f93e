"""The folder of a run: scene as run, trajectory, checkpoint; made only when everything else is ready."""

from __future__ import annotations

import io
import os
import shutil
import zipfile
from pathlib import Path

import numpy as np
from filelock import FileLock, Timeout

from warp_rods.errors import RunFolderError
from warp_rods.scene.scene import Scene
from warp_rods.scene.tables import Time
from warp_rods.simulation.trajectory import STORE, GroupSpec, TrajectoryWriter

SCENE, CHECKPOINT, LOCK = "scene.toml", "checkpoint.npz", ".lock"
FORMAT = 3
"""Of checkpoints: which arrays make up a state, and which variables its trajectory has."""
PARTS = (SCENE, STORE, CHECKPOINT, "animation.usdc")


class RunFolder:
    """``path`` and what is written there: ``writer`` appends frames, ``checkpoint`` makes a restart possible."""

    def __init__(self, path: Path, writer: TrajectoryWriter, lock: FileLock):
        self.path, self.writer, self._lock = path, writer, lock
        self.checkpointed = writer.frames - 1
        """The frame that a restart goes on from."""

    def __enter__(self) -> RunFolder:
        return self

    def __exit__(self, *_exception: object) -> None:
        """Finish the trajectory and let others write here."""
        self.writer.close()
        self._lock.release()

    @staticmethod
    def check_free(path: Path, overwrite: bool) -> None:
        """Raises RunFolderError where ``path`` holds a run already and may not be overwritten, or is no folder."""
        if path.exists() and not path.is_dir():
            raise RunFolderError(f"{path} is a file: give another --out")
        if not (path / STORE).exists():
            others = [part for part in PARTS if (path / part).exists()]
            if others:
                raise RunFolderError(f"{path} holds a {others[0]} that is of no run: give another --out")
        elif not overwrite:
            raise RunFolderError(
                f"{path} holds a run already: give another --out, --overwrite to replace it, or --resume to go on"
            )

    @classmethod
    def create(cls, path: Path, groups: dict[str, GroupSpec], attributes: dict) -> RunFolder:
        """A fresh folder; an old run's parts in it are removed."""
        path.mkdir(parents=True, exist_ok=True)
        lock = _lock(path)
        for part in PARTS:
            target = path / part
            shutil.rmtree(target) if target.is_dir() else target.unlink(missing_ok=True)
        return cls(path, TrajectoryWriter.create(path / STORE, groups, attributes), lock)

    @classmethod
    def resume(cls, path: Path, scene: Scene, attributes: dict) -> tuple[RunFolder, dict[str, np.ndarray]]:
        """The folder of an unfinished run of this very scene, and its last checkpoint.

        Raises RunFolderError where there is none, or the scene differs.
        """
        if not (path / CHECKPOINT).is_file():
            raise RunFolderError(f"{path} has no {CHECKPOINT} to go on from: run without --resume, perhaps --overwrite")
        _check_same(Scene.load(path / SCENE), scene, path)
        try:
            with np.load(path / CHECKPOINT) as stored:
                state = dict(stored)
        except (OSError, ValueError, EOFError, zipfile.BadZipFile) as fault:
            raise RunFolderError(f"{path / CHECKPOINT} is damaged ({fault}): run anew with --overwrite") from None
        if int(state.pop("format", 1)) != FORMAT:
            raise RunFolderError(f"{path / CHECKPOINT} is of another version of warp-rods: run anew with --overwrite")
        lock = _lock(path)
        writer = TrajectoryWriter.resume(path / STORE, int(state["frame"]) + 1, attributes)
        return cls(path, writer, lock), state

    def keep(self, scene: Scene) -> None:
        """Write down the scene as run."""
        (self.path / SCENE).write_text(scene.to_toml(), encoding="utf-8")

    def checkpoint(self, state: dict[str, np.ndarray]) -> None:
        """Replace the checkpoint in one move: whenever the machine stops, one whole checkpoint is there."""
        buffer = io.BytesIO()
        np.savez(buffer, format=np.array(FORMAT), **state)  # type: ignore[arg-type]
        partial = self.path / f".{CHECKPOINT}.partial"
        with partial.open("wb") as file:
            file.write(buffer.getbuffer())
            file.flush()
            os.fsync(file.fileno())
        partial.replace(self.path / CHECKPOINT)
        _sync(self.path)
        self.checkpointed = int(state["frame"])


def _lock(path: Path) -> FileLock:
    """Hold the folder until the lock is released or the process ends; RunFolderError if another process holds it."""
    lock = FileLock(path / LOCK)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        raise RunFolderError(f"another run is writing to {path}: wait for it, or give another --out") from None
    return lock


def _sync(folder: Path) -> None:
    """Make renames in a folder last through a loss of power, where the system can."""
    if os.name == "posix":
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def as_begun(path: Path, scene: Scene) -> Scene:
    """The scene with the step and the spacing of frames of the run in a folder, where it leaves them to be chosen.

    What is chosen follows ``time.end``: without this no run could be made longer.
    """
    if not (path / SCENE).is_file():
        return scene
    before, time = Scene.load(path / SCENE).time, scene.time
    begun: dict[str, float | None] = {}
    if time.step is None:
        begun["step"] = before.step
    if time.save_every == Time.filled({"end": time.end, "step": time.step or 0.0})["save_every"]:
        begun["save_every"] = before.save_every
    return scene.model_copy(update={"time": time.model_copy(update=begun)})


def _check_same(before: Scene, scene: Scene, path: Path) -> None:
    """Raises RunFolderError naming the keys in which a scene is not the one that was run, ``time.end`` apart."""
    old, new = before.model_dump(), scene.model_dump()
    differing = [key for key in new if key != "time" and new[key] != old[key]]
    # The step as run is the frames' spacing over a whole number: its last digits follow the number of frames.
    same = {key: np.isclose(new["time"][key], old["time"][key], rtol=1e-9, atol=0) for key in ("step", "save_every")}
    differing += [f"time.{key}" for key, close in same.items() if not close]
    if differing:
        raise RunFolderError(
            f"{path / SCENE} differs from the scene given in {', '.join(differing)}: only time.end may change, to go on"
        )

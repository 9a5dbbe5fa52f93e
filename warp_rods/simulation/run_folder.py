"""The folder of a run: scene as run, trajectory, checkpoint, surfaces; made only when everything else is ready."""

from __future__ import annotations

import io
import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from filelock import FileLock, Timeout

from warp_rods.archive import read_archive
from warp_rods.errors import RunFolderError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.begun import KEPT, Begun
from warp_rods.simulation.document import METADATA
from warp_rods.simulation.files import replace_file
from warp_rods.simulation.kept_surfaces import NAMES, KeptSurfaces, with_files
from warp_rods.simulation.trajectory import STORE, GroupSpec, TrajectoryWriter

SCENE, CHECKPOINT, LOCK = "scene.toml", "checkpoint.npz", ".lock"
FORMAT = 4
"""Of checkpoints: which arrays make up a state, and which variables its trajectory has."""
PARTS = (SCENE, CHECKPOINT, "animation.usdc", *NAMES.values(), STORE)
"""All that a run may leave; the store is removed last, so that a folder with a part of a run still counts as one."""

State = dict[str, np.ndarray]


class RunFolder:
    """``path`` and what is written there: ``writer`` appends frames, ``checkpoint`` makes a restart possible."""

    def __init__(self, path: Path, writer: TrajectoryWriter, lock: FileLock):
        self.path, self.writer, self._lock = path, writer, lock
        self.checkpointed = writer.frames - 1
        """The frame from which a restart continues."""

    def __enter__(self) -> RunFolder:
        return self

    def __exit__(self, *_exception: object) -> None:
        """Finish the trajectory and release the folder."""
        try:
            self.writer.close()
        finally:
            self._lock.release()

    @staticmethod
    def mark(path: Path) -> tuple[int, ...]:
        """A mark of the run that a folder holds, which another run would not have; empty where it holds none."""
        for file in (path / STORE / METADATA, path / STORE):
            if file.exists():
                found = os.stat(file)
                return found.st_dev, found.st_ino, found.st_mtime_ns
        return ()

    @staticmethod
    def check_free(path: Path, overwrite: bool) -> None:
        """Raises RunFolderError where ``path`` holds a run already and may not be overwritten, or is no folder."""
        if path.exists() and not path.is_dir():
            raise RunFolderError(f"{path} is a file: give another --out")
        if not (path / STORE).exists():
            others = [part for part in PARTS if (path / part).exists()]
            if others:
                raise RunFolderError(f"{path} holds a {others[0]} that belongs to no run: give another --out")
        elif not overwrite:
            raise RunFolderError(
                f"{path} holds a run already: give another --out, --overwrite to replace it, or --resume to continue it"
            )

    @classmethod
    def create(
        cls,
        path: Path,
        groups: Mapping[str, GroupSpec],
        attributes: Mapping[str, Any],
        *,
        scene: Scene,
        surfaces: KeptSurfaces,
        overwrite: bool = False,
        expected: tuple[int, ...] = (),
    ) -> RunFolder:
        """A fresh folder; the parts of the run that it held when its ``mark`` was ``expected`` are removed.

        Raises RunFolderError, and removes nothing, where another process holds the folder or has put a run there since.
        """
        path.mkdir(parents=True, exist_ok=True)
        lock = _lock(path)
        try:
            cls.check_free(path, overwrite)
            if cls.mark(path) != expected:
                raise RunFolderError(f"{path} holds another run than before this one was prepared: give another --out")
            for part in PARTS:
                _remove(path / part)
            text = with_files(scene, NAMES).to_toml()
            attributes = {**attributes, "scene": text, KEPT: surfaces.origins}
            writer = TrajectoryWriter.create(path / STORE, groups, attributes)
            for name, data in surfaces.contents.items():
                replace_file(path / name, data, durable=True)
            _keep_scene(path, text)
        except BaseException:
            lock.release()
            raise
        return cls(path, writer, lock)

    @classmethod
    def resume(
        cls,
        path: Path,
        scene: Scene,
        attributes: Mapping[str, Any],
        accept: Callable[[State], object] = lambda state: None,
    ) -> tuple[RunFolder, State]:
        """The folder of an unfinished run of this scene, and its last checkpoint.

        ``accept`` is called with the state and may raise. Raises RunFolderError where there is none, the scene differs,
        or something is damaged. A refusal changes nothing in the folder.
        """
        _refuse_or_accept(path, scene, accept)  # before the lock, which would leave a file
        lock = _lock(path)
        try:
            begun, state = _refuse_or_accept(path, scene, accept)  # another process may have been here
            text = with_files(scene, {key: name for key, name in NAMES.items() if name in begun.kept}).to_toml()
            new = {"scene": text} if text != begun.text else {}
            kept = {key: value for key, value in attributes.items() if key not in ("scene", "scene_hash") or new}
            writer = TrajectoryWriter.resume(path / STORE, int(state["frame"]) + 1, {**kept, **new})
            _keep_scene(path, text)
        except BaseException:
            lock.release()
            raise
        return cls(path, writer, lock), state

    def checkpoint(self, state: State) -> None:
        """Replace the checkpoint as a whole: whenever the machine stops, one whole checkpoint is there."""
        buffer = io.BytesIO()
        np.savez(buffer, format=np.array(FORMAT), **state)  # type: ignore[arg-type]
        replace_file(self.path / CHECKPOINT, buffer.getbuffer(), durable=True)
        self.checkpointed = int(state["frame"])


def read_checkpoint(path: Path) -> State:
    """The last checkpoint in a folder; raises RunFolderError where there is none, or it is damaged."""
    file = path / CHECKPOINT
    if not file.is_file():
        raise RunFolderError(f"{path} has no {CHECKPOINT} to continue from: run without --resume, perhaps --overwrite")
    try:
        state = read_archive(file)
        version = int(state.pop("format", 1))
    except (ValueError, TypeError) as fault:
        raise RunFolderError(f"{file} is damaged ({fault}): run the scene again with --overwrite") from None
    if version != FORMAT:
        raise RunFolderError(f"{file} is of another version of warp-rods: run the scene again with --overwrite")
    return state


def _refuse_or_accept(path: Path, scene: Scene, accept: Callable[[State], object]) -> tuple[Begun, State]:
    state = read_checkpoint(path)
    begun = Begun.read(path)
    begun.check_times(begun.continued(scene))
    accept(state)
    return begun, state


def _keep_scene(path: Path, text: str) -> None:
    """Write down the scene as run, where it is not written yet."""
    file, data = path / SCENE, text.encode()
    if not file.is_file() or file.read_bytes() != data:
        replace_file(file, data, durable=True)


def _remove(target: Path) -> None:
    if target.is_dir():
        (target / METADATA).unlink(missing_ok=True)  # first, so that nobody reads a half
        shutil.rmtree(target)
    else:
        target.unlink(missing_ok=True)


def _lock(path: Path) -> FileLock:
    """Hold the folder until the lock is released or the process ends; RunFolderError if another process holds it."""
    lock = FileLock(path / LOCK)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        raise RunFolderError(f"another run is writing to {path}: wait for it, or give another --out") from None
    return lock

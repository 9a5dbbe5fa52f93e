"""The folder of a run: scene as run, trajectory, checkpoint, surfaces; made only when everything else is ready."""

from __future__ import annotations

import contextlib
import math
import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from time import perf_counter as clock
from typing import Any

import numpy as np
from filelock import FileLock

from warp_rods.errors import RunFolderError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.begun import KEPT, Begun
from warp_rods.simulation.checkpoint import CHECKPOINT, State, read_checkpoint, write_checkpoint
from warp_rods.simulation.document import METADATA, Document
from warp_rods.simulation.files import replace_file
from warp_rods.simulation.kept_surfaces import NAMES, KeptSurfaces, with_files
from warp_rods.simulation.leftovers import clear_leftovers, is_being_made, new_store, old_store
from warp_rods.simulation.storage import StorageError, told_with_remedy
from warp_rods.simulation.trajectory import STORE, GroupSpec, TrajectoryWriter
from warp_rods.simulation.under_way import UNDER_WAY, lock_folder

SCENE = "scene.toml"
MADE = ("animation.usdc", "poster.png", "film.mp4")
"""Pictures that are made of a run at its end."""
FRAMES_EVERY = 0.25
"""Seconds for which frames wait in memory at most, as writing them takes 10 ms whether they are one or many."""
MOST_HELD = 32e6
"""Bytes of frames that wait at most."""
OWN = (SCENE, CHECKPOINT, *NAMES.values(), STORE, UNDER_WAY)
"""The data of a run, which nothing may replace."""
PARTS = (SCENE, CHECKPOINT, *MADE, *NAMES.values(), STORE)
"""All that a run may leave."""


class RunFolder:
    """``path`` and what is written there: ``writer`` appends frames, ``checkpoint`` makes a restart possible."""

    def __init__(self, path: Path, writer: TrajectoryWriter, lock: FileLock, device: str = ""):
        self.path, self.writer, self._lock, self._device = path, writer, lock, device
        self.continues_from = 0.0
        """The time from which a restart continues."""
        self._written = -math.inf

    def __enter__(self) -> RunFolder:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_exception: object) -> None:
        """Finish the trajectory and release the folder. A failure to finish does not hide what ended the run."""
        try:
            self.finish()
        except StorageError:
            if kind is None:
                raise
        finally:
            self._lock.release()

    def finish(self) -> None:
        """Finish the trajectory: its last metadata are for readers that do not use consolidated ones."""
        with told_with_remedy(self.path, self._device):
            self.writer.close()

    def append(self, time: float, frame: Mapping[str, Mapping[str, np.ndarray]]) -> None:
        """Save a frame: at once where frames are rare, and otherwise with others that follow within a moment."""
        size = sum(np.asarray(values).nbytes for group in frame.values() for values in group.values())
        at_once = self._due or self.writer.bytes_held + size > MOST_HELD
        self.writer.hold(time, frame, copy=not at_once)
        if at_once:
            self._write_frames()

    @property
    def _due(self) -> bool:
        return clock() - self._written >= FRAMES_EVERY

    def write_frames(self) -> None:
        """Write the frames that wait, where they have waited for long enough."""
        if self._due:
            self._write_frames()

    def _write_frames(self) -> None:
        """Raises StorageError, as on a full disk."""
        with told_with_remedy(self.path, self._device):
            self.writer.write()
        self._written = clock()

    def describe(self, **attributes: Any) -> None:
        """Set attributes of the trajectory, after the frames that wait; raises StorageError."""
        self._write_frames()
        with told_with_remedy(self.path, self._device):
            self.writer.describe(**attributes)

    @staticmethod
    def mark(path: Path) -> tuple[int, ...]:
        """A mark of the run that a folder holds, which another run would not have; empty where it holds none."""
        for file in (path / STORE / METADATA, path / STORE):
            if file.exists():
                found = os.stat(file)
                return found.st_dev, found.st_ino, found.st_mtime_ns
        return ()

    @staticmethod
    def size(path: Path) -> float:
        """Bytes of the run that a folder holds."""
        parts = (path / part for part in PARTS)
        files = (file for part in parts for file in ([part] if part.is_file() else part.rglob("*")))
        return float(sum(file.stat().st_size for file in files if file.is_file()))

    @staticmethod
    def check_free(path: Path, overwrite: bool) -> None:
        """Raises RunFolderError where ``path`` holds a run already and may not be overwritten, or is no folder."""
        if path.exists() and not path.is_dir():
            raise RunFolderError(f"{path} is a file: give another --out")
        if is_being_made(path):
            return
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

        Killed at any moment, it leaves the run that was there, or a folder in which ``is_being_made`` or that holds a
        store without a frame: ``--resume`` starts anew there. Raises RunFolderError, and removes nothing, where another
        process holds the folder or has put a run there since; StorageError where it cannot be written.
        """
        with told_with_remedy(path):
            path.mkdir(parents=True, exist_ok=True)
            lock = lock_folder(path)
            try:
                cls.check_free(path, overwrite)
                if cls.mark(path) != expected:
                    raise RunFolderError(
                        f"{path} holds another run than before this one was prepared: give another --out"
                    )
                with contextlib.suppress(RunFolderError):  # there is none, or a damaged one is replaced
                    surfaces.keep_origins(Document.read(path / STORE).attributes.get(KEPT, {}))
                _set_aside(path)
                text = with_files(scene, NAMES).to_toml()

                def companions() -> None:
                    for name in NAMES.values():
                        if name in surfaces.contents:
                            replace_file(path / name, surfaces.contents[name], durable=True)
                        else:
                            _remove(path / name)
                    _keep_scene(path, text)

                attributes = {**attributes, "scene": text, KEPT: surfaces.origins}
                writer = TrajectoryWriter.create(path / STORE, groups, attributes, companions)
                clear_leftovers(path, (*PARTS, UNDER_WAY))
            except BaseException:
                lock.release()
                raise
        return cls(path, writer, lock, str(attributes.get("device", "")))

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
        lock = lock_folder(path)
        try:
            begun, state = _refuse_or_accept(path, scene, accept)  # another process may have been here
            text = with_files(scene, {key: name for key, name in NAMES.items() if name in begun.kept}).to_toml()
            new = {"scene": text} if text != begun.text else {}
            kept = {key: value for key, value in attributes.items() if key not in ("scene", "scene_hash") or new}
            with told_with_remedy(path, str(attributes.get("device", ""))):
                clear_leftovers(path, (*PARTS, UNDER_WAY))
                writer = TrajectoryWriter.resume(path / STORE, int(state["frame"]) + 1, {**kept, **new})
                _keep_scene(path, text)
        except BaseException:
            lock.release()
            raise
        return cls(path, writer, lock, str(attributes.get("device", ""))), state

    def checkpoint(self, state: State) -> None:
        """Replace the checkpoint as a whole, after the frames that wait: it is never ahead of the trajectory.

        Whenever the machine stops, one whole checkpoint is there.
        """
        self._write_frames()
        with told_with_remedy(self.path, self._device):
            write_checkpoint(self.path, state)


def starts_anew(path: Path, scene: Scene) -> bool:
    """Whether a run of ``scene`` that is to be continued starts anew, as it was ended before its first checkpoint.

    Raises RunFolderError where a folder without a checkpoint holds more than that: another scene, frames that were
    saved after a checkpoint, or a damaged store. Nothing is changed.
    """
    if (path / CHECKPOINT).exists() and not is_being_made(path):
        return False
    RunFolder.check_free(path, overwrite=True)
    if not (path / STORE).exists():
        return True
    begun = Begun.read(path)
    begun.continued(scene)
    if (frames := Document.read(path / STORE).frames) > 1:
        raise RunFolderError(
            f"{path} holds {frames} frames of this scene, but {CHECKPOINT}, from which they are continued, is missing: "
            f"give another --out, or --overwrite to replace them"
        )
    return True


def _refuse_or_accept(path: Path, scene: Scene, accept: Callable[[State], object]) -> tuple[Begun, State]:
    state = read_checkpoint(path)
    begun = Begun.read(path)
    begun.continued(scene)
    accept(state)
    return begun, state


def _keep_scene(path: Path, text: str) -> None:
    """Write down the scene as run, where it is not written yet."""
    file, data = path / SCENE, text.encode()
    if not file.is_file() or file.read_bytes() != data:
        replace_file(file, data, durable=True)


def _set_aside(path: Path) -> None:
    """Make way for a new run. A store that is replaced is renamed first; while it is there, nothing else counts."""
    for file in (path / STORE, new_store(path / STORE)):
        if file.exists():
            _remove(old_store(path / STORE))
            file.rename(old_store(path / STORE))
    for name in (CHECKPOINT, *MADE):
        _remove(path / name)
    for content in old_store(path / STORE).glob("*"):  # its space is needed; the folder marks what is unfinished
        _remove(content)


def _remove(target: Path) -> None:
    if target.is_dir():
        (target / METADATA).unlink(missing_ok=True)  # first, so that nobody reads a half
        shutil.rmtree(target)
    else:
        target.unlink(missing_ok=True)

"""What a run that is under way tells other processes: a small file in its folder, replaced about every second.

Whether a run is under way follows from the lock of its folder, which a process loses however it ends.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from filelock import FileLock, Timeout

from warp_rods.errors import RunFolderError
from warp_rods.simulation.files import replace_file

__all__ = [
    "LOCK",
    "UNDER_WAY",
    "FolderInUse",
    "Telling",
    "UnderWay",
    "is_under_way",
    "lock_folder",
    "telling_what_is_made",
]

LOCK, UNDER_WAY = ".lock", ".under_way.json"
TELL_EVERY = 1.0
"""Seconds after which the file is replaced."""
PATIENCE = 0.5
"""Seconds for which a run waits for the lock: another process may be looking at it, which takes microseconds."""


@dataclass(frozen=True)
class UnderWay:
    """How far a run is: ``time`` of the simulation, and from which ``first`` in how many ``seconds`` and ``rod_steps``.

    Those of this process; a run that is continued begins at a later ``first``. ``making``: the picture that is made at
    the end of the run; the other numbers are then 0.
    """

    time: float
    first: float
    seconds: float
    rod_steps: int
    making: str = ""

    @classmethod
    def read(cls, folder: Path) -> UnderWay | None:
        """What the run in a folder told last; None where it told nothing yet."""
        try:
            return cls(**json.loads((folder / UNDER_WAY).read_bytes()))
        except (OSError, ValueError, TypeError):
            return None

    def seconds_left(self, end: float) -> float | None:
        """Seconds until the time ``end``, if it goes on like this; None where nothing can be said yet."""
        done = self.time - self.first
        return self.seconds * (end - self.time) / done if done > 0 else None


class Telling:
    """A context in which a run tells how far it is; the file is removed at its end."""

    def __init__(self, folder: Path, first: float):
        self._file, self._first = folder / UNDER_WAY, first
        self._began, self._told = time.perf_counter(), float("-inf")

    def __enter__(self) -> Telling:
        return self

    def __exit__(self, *_exception: object) -> None:
        with contextlib.suppress(OSError):
            self._file.unlink(missing_ok=True)

    def tell(self, now: float, rod_steps: int) -> None:
        """Set the time of the simulation and the rod-steps done since the beginning."""
        clock = time.perf_counter()
        if clock - self._told < TELL_EVERY:
            return
        self._told = clock
        state = UnderWay(now, self._first, clock - self._began, rod_steps)
        with contextlib.suppress(OSError):  # a run does not depend on who looks at it: its frames tell of a full disk
            replace_file(self._file, json.dumps(asdict(state)).encode())


@contextlib.contextmanager
def telling_what_is_made(folder: Path, what: str) -> Iterator[None]:
    """A context in which a run that has all its frames tells which picture is being made."""
    file = folder / UNDER_WAY
    with contextlib.suppress(OSError):
        replace_file(file, json.dumps(asdict(UnderWay(0.0, 0.0, 0.0, 0, what))).encode())
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            file.unlink(missing_ok=True)


class FolderInUse(RunFolderError):
    """Another process holds the folder of a run."""


def lock_folder(folder: Path) -> FileLock:
    """Hold a folder until the lock is released or the process ends; FolderInUse if another process holds it."""
    lock = FileLock(folder / LOCK)
    try:
        lock.acquire(timeout=PATIENCE, poll_interval=0.02)
    except Timeout:
        raise FolderInUse(f"another run is writing to {folder}: wait for it, or give another --out") from None
    with contextlib.suppress(OSError):  # what a killed run told is not of this one
        (folder / UNDER_WAY).unlink(missing_ok=True)
    return lock


def is_under_way(folder: Path) -> bool:
    """Whether a process holds a folder. Reads only: a folder of somebody else can be looked at, too.

    Raises RunFolderError where the file system cannot tell.
    """
    file = folder / LOCK
    if not file.exists():
        return False
    return _is_locked(file) if os.name == "posix" else _is_taken(file)


def _is_locked(file: Path) -> bool:
    """By a shared lock, which two processes that look may have at once."""
    import fcntl

    try:
        descriptor = os.open(file, os.O_RDONLY)
    except FileNotFoundError:
        return False
    except OSError as fault:
        raise RunFolderError(f"{file} cannot be read ({fault}): whether the run goes on is not known") from None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError as fault:
        if fault.errno in (errno.EWOULDBLOCK, errno.EACCES):
            return True
        raise RunFolderError(f"{file} cannot be locked ({fault}): whether the run goes on is not known") from None
    finally:
        os.close(descriptor)
    return False


def _is_taken(file: Path) -> bool:
    """Where there are no shared locks, as on Windows."""
    try:
        with FileLock(file).acquire(blocking=False):
            return False
    except Timeout:
        return True

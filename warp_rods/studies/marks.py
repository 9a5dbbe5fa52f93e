"""Marks: files that say who writes, as locks of file systems that several machines see cannot be relied on.

A mark that does not change for long is of a process that was killed, or stopped, which finds out before it writes on.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from warp_rods.simulation.leftovers import this_process

__all__ = ["MarkLost", "alone"]

STALE = 30.0
"""Seconds after which the mark of a process that writes is that of one that was killed; a file takes some ms."""
LOOK = 0.02
"""Seconds between looks at the mark of another process."""


class MarkLost(Exception):
    """Another process has taken the mark of this one, which did nothing for long."""


@contextlib.contextmanager
def alone(mark: Path) -> Iterator[Callable[[], None]]:
    """Wait for a mark and hold it; gives a function that raises MarkLost where it is no longer this process's."""
    owner = f"{this_process()}-{threading.get_ident()}-{time.monotonic_ns()}".encode()
    seen, since = None, time.monotonic()
    while not _made(mark, owner):
        if (now := _changed(mark)) != seen:
            seen, since = now, time.monotonic()
        elif time.monotonic() - since > STALE:
            mark.unlink(missing_ok=True)
        time.sleep(LOOK)

    def still_alone() -> None:
        try:
            if mark.read_bytes() != owner:
                raise MarkLost
            os.utime(mark)
        except FileNotFoundError:
            raise MarkLost from None

    try:
        yield still_alone
    finally:
        with contextlib.suppress(MarkLost):
            still_alone()
            mark.unlink(missing_ok=True)


def _made(mark: Path, owner: bytes) -> bool:
    """Whether the mark could be made; False where there is one. Raises OSError, as on a full disk, and leaves none."""
    try:
        descriptor = os.open(mark, os.O_CREAT | os.O_EXCL | os.O_WRONLY)
    except FileExistsError:
        return False
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(owner)
    except OSError:
        mark.unlink(missing_ok=True)  # others would wait for it in vain
        raise
    return True


def _changed(mark: Path) -> tuple[int, int] | None:
    """Which file a mark is, and when it was last changed by the clock of its file system."""
    try:
        about = mark.stat()
    except FileNotFoundError:
        return None
    return about.st_ino, about.st_mtime_ns

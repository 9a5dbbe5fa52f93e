"""Failures of the storage under a run folder in words: a full disk, a quota, a folder that may not be written."""

from __future__ import annotations

import contextlib
import errno
import shlex
from collections.abc import Iterator
from pathlib import Path

from warp_rods.device import choose
from warp_rods.errors import WarpRodsError

__all__ = ["StorageError", "how_to_continue", "told_with_remedy"]


class StorageError(WarpRodsError):
    """Files of a run that can no longer be written, as on a full disk; says what to do and how to go on."""


REMEDIES = {
    errno.ENOSPC: ("No space left on the disk of {folder}", "free some space"),
    errno.EDQUOT: ("The disk quota is used up in {folder}", "remove some files, or ask for a larger quota"),
    errno.EFBIG: ("A file in {folder} may not become larger", "raise the limit on the size of files (ulimit -f)"),
    errno.EROFS: ("The file system of {folder} is read-only now", "make it writable again"),
    errno.EACCES: ("{folder} may not be written any more", "give yourself the permission to write there"),
    errno.EPERM: ("{folder} may not be written any more", "give yourself the permission to write there"),
    errno.EMFILE: ("Too many files are open", "raise the limit on open files (ulimit -n)"),
}
"""What has happened, and what the user can do about it, by the number of the error."""
OTHERWISE = ("{folder} cannot be written", "mend what the system reports here")


def how_to_continue(folder: Path, device: str) -> str:
    """The command that continues the run in a folder, on the device on which it was begun."""
    options = "" if device in ("", choose(None)) else f" --device {device}"
    scene, out = (shlex.quote(str(path)) for path in (folder / "scene.toml", folder))
    return f"warp-rods run {scene} --out {out}{options} --resume"


@contextlib.contextmanager
def told_with_remedy(folder: Path, device: str = "") -> Iterator[None]:
    """Raises StorageError, with what to do and how to go on, where something in ``folder`` cannot be written."""
    try:
        yield
    except OSError as fault:
        happened, remedy = REMEDIES.get(fault.errno or 0, OTHERWISE)
        where = f"{fault.strerror or fault}: {fault.filename or folder}"
        if (folder / "scene.toml").is_file():
            then = f"All frames up to the last complete one are kept. To go on, {remedy}, then: "
            then += how_to_continue(folder, device)
        else:
            then = f"To begin, {remedy}, then run the same command again, with --resume."
        raise StorageError(f"{happened.format(folder=folder)} ({where}). {then}") from fault

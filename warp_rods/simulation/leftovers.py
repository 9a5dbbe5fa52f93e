"""What a run or an export that was killed may leave under temporary names, and how a folder is made free of it."""

from __future__ import annotations

import contextlib
import os
import platform
import re
import shutil
import time
from collections.abc import Iterable
from pathlib import Path

from warp_rods.simulation.store import STORE

__all__ = [
    "aside_of",
    "clear_leftovers",
    "is_being_made",
    "new_store",
    "old_store",
    "partial_of",
    "remove_partial",
    "replace_folder",
    "this_process",
]

_LEFT_AFTER = 86400.0
"""Seconds without a change after which a temporary file counts as left, where its process cannot be asked after."""


def new_store(store: Path) -> Path:
    """The name of a store until it is whole."""
    return store.with_name(f".{store.name}.new")


def old_store(store: Path) -> Path:
    """The name of a store that is being replaced."""
    return store.with_name(f".{store.name}.old")


def is_being_made(folder: Path) -> bool:
    """Whether a folder without a store is one in which a run was being made, or replaced, when it was killed."""
    store = folder / STORE
    return not store.exists() and (new_store(store).exists() or old_store(store).exists())


def clear_leftovers(folder: Path, names: Iterable[str]) -> None:
    """Remove whatever a killed run or export of files with these names has left; to be called by who holds the folder.

    Of a store that was replaced the folder goes last, as it marks what is unfinished.
    """
    for name in names:
        remove_partial(folder / name)
    for store in (new_store(folder / STORE), old_store(folder / STORE)):
        if store.is_dir():
            shutil.rmtree(store)


def partial_of(file: Path) -> Path:
    """The temporary name under which this process makes a file or a folder; it ends with the suffix of its format."""
    return file.with_name(f"{_own(file)}.partial{file.suffix.lower()}")


def aside_of(folder: Path) -> Path:
    """The name of a folder while this process replaces it."""
    return folder.with_name(f"{_own(folder)}.old")


def replace_folder(path: Path, new: Path) -> None:
    """Put a new folder in place; the old one is renamed first, and removed when the new one is there."""
    aside = aside_of(path)
    path.rename(aside)
    try:
        new.rename(path)
    except OSError:
        aside.rename(path)
        raise
    shutil.rmtree(aside)


def this_process() -> str:
    """A name that no other process has, on any machine."""
    return f"{_host()}-{os.getpid()}"


def _own(file: Path) -> str:
    return f".{file.name}.{this_process()}"


def _host() -> str:
    """The name of this machine in letters, digits and hyphens: folders may be shared with others."""
    return re.sub(r"[^A-Za-z0-9]", "-", platform.node()) or "here"


def remove_partial(file: Path) -> None:
    """Remove what this process, and processes that have ended, have left of a file or a folder under temporary names.

    Writers of USD leave files of their own beside ours, with our names and another suffix. A folder that was set aside
    returns where the new one did not come.
    """
    names = re.compile(rf"\.{re.escape(file.name)}\.([A-Za-z0-9-]+)-(\d+)\.(partial|old)(\..+)?")
    for found in list(file.parent.iterdir()) if file.parent.is_dir() else ():
        name = names.fullmatch(found.name)
        if found.name == f".{file.name}.partial" and found.is_file():
            found.unlink(missing_ok=True)
        elif name and _is_left(found, name[1], int(name[2])):
            if name[3] == "old" and not file.exists():
                found.rename(file)
            elif found.is_dir() and not found.is_symlink():
                shutil.rmtree(found, ignore_errors=True)
            else:
                found.unlink(missing_ok=True)


def _is_left(found: Path, host: str, process: int) -> bool:
    """Whether nobody works on a temporary file: its process is this one, or has ended."""
    if host == _host() and process == os.getpid():
        return True
    if host == _host() and os.name == "posix":
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            return True
        except OSError:  # it is of another user
            return False
        return False
    with contextlib.suppress(OSError):
        return time.time() - found.stat().st_mtime > _LEFT_AFTER
    return False

"""What a run or an export that was killed may leave under temporary names, and how a folder is made free of it."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path

from warp_rods.simulation.store import STORE

__all__ = ["clear_leftovers", "is_being_made", "new_store", "old_store", "remove_partial"]


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


def remove_partial(file: Path) -> None:
    """Remove the temporary files of a file: ours, and what a writer of USD has made beside ours."""
    for found in file.parent.iterdir() if file.parent.is_dir() else ():
        ours = found.name == f".{file.name}.partial" or found.name.startswith(f".{file.stem}.partial.")
        if ours and found.is_file():
            found.unlink(missing_ok=True)

"""Where an export goes: what it may replace, and how it takes its place when it is whole.

A file replaces a file with a suffix of its kind; a folder one in which there is nothing but what exports of its kind
write. Nothing else is ever removed.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from warp_rods.arguments import wrong
from warp_rods.errors import RunFolderError, SceneError
from warp_rods.simulation.files import check_writable
from warp_rods.simulation.leftovers import partial_of, remove_partial, replace_folder
from warp_rods.simulation.run_folder import OWN

__all__ = ["file_place", "folder_place", "placed"]

_OF_FILES = re.compile(
    r"\.(usd[acz]?|png|jpe?g|gif|mp4|html?|py|tiff?|vtkhdf|h5|gsd|simularium|wcon|csv|toml|txt)", re.I
)
"""Suffixes that no folder gets: who gives one expects a file."""
_OF_DESKTOPS = (".DS_Store", "Thumbs.db", "desktop.ini")
"""Files that file managers leave in every folder that is looked at."""


def file_place(path: Path, file_name: str, suffixes: Sequence[str]) -> Path:
    """Where a file with one of these suffixes goes: ``path``, or under its usual name in the folder ``path``.

    Raises SceneError for another suffix and a place in a trajectory, RunFolderError where it cannot be written.
    """
    path = path / file_name if path.is_dir() else path
    _check(path)
    if path.suffix.lower() not in suffixes:
        allowed = " or ".join(suffixes)
        raise wrong("out", str(path), f"a file with the suffix {allowed}, or a folder that exists")
    if path.is_dir():
        raise SceneError(f"out = {str(path)!r}: is a folder, which no file replaces: give another --out")
    return path


def folder_place(path: Path, holds: str) -> Path:
    """Where a folder goes whose files have paths in it of the pattern ``holds``: ``path``, without symbolic links.

    Raises SceneError where there is anything else that it would replace, and for the suffix of a file.
    """
    path = path.resolve()
    _check(path)
    if _OF_FILES.fullmatch(path.suffix) and not path.is_dir():
        raise wrong("out", str(path), "a folder, without the suffix of a file")
    if path.exists() and not path.is_dir():
        raise SceneError(f"out = {str(path)!r}: is a file, which no folder replaces: give another --out")
    if foreign := _foreign(path, holds):
        raise SceneError(
            f"out = {str(path)!r}: holds {foreign}, which no export of this kind writes, and would be replaced: give "
            "another --out, or move it elsewhere"
        )
    return path


def _check(path: Path) -> None:
    """Raises SceneError for places within a trajectory and names of a run's own files, RunFolderError below a file."""
    if any(part.suffix == ".zarr" for part in (path.resolve(), *path.resolve().parents)) or path.name in OWN:
        raise SceneError(f"out = {str(path)!r}: belongs to the data of a run: give another --out")
    check_writable(path.parent, "out")


def _foreign(folder: Path, holds: str) -> str:
    """A path in a folder that is not of the pattern ``holds``; empty where there is none."""
    for found in folder.rglob("*"):
        name = found.relative_to(folder).as_posix()
        if found.name not in _OF_DESKTOPS and not re.fullmatch(holds, name):
            return name
    return ""


@contextlib.contextmanager
def placed(path: Path) -> Iterator[Path]:
    """Give a temporary name beside ``path``; what is written there then takes its place, also that of a folder.

    Folders above are made. Raises RunFolderError where something cannot be written; then nothing is left.
    """
    temporary = partial_of(path)
    above = [folder for folder in path.parents if not folder.exists()]
    done = False
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        remove_partial(path)  # of exports that were killed
        yield temporary
        _replace(path, temporary)
        done = True
    except OSError as fault:
        raise RunFolderError(f"{path} cannot be written: {str(fault.strerror or fault).rstrip('.')}.") from None
    finally:
        remove_partial(path)
        for folder in () if done else above:
            with contextlib.suppress(OSError):
                folder.rmdir()


def _replace(path: Path, new: Path) -> None:
    """Put a new file or folder in place."""
    if path.is_dir():
        replace_folder(path, new)
    else:
        new.replace(path)

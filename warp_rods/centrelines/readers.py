"""The formats of centre lines: one row of ``READERS`` for each suffix."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from warp_rods.centrelines.swc import read_swc
from warp_rods.centrelines.table import read_array, read_table
from warp_rods.centrelines.track import Track, TrackError
from warp_rods.centrelines.wcon import read_wcon

__all__ = ["CHOICES", "READERS", "Format", "read_track", "suffix_of"]


@dataclass(frozen=True)
class Format:
    """A format: its function of a path and of the keys of a scene in ``choices`` that choose one of several lines."""

    words: str
    read: Callable[..., Track]
    choices: tuple[str, ...] = ()


_TABLE = Format("columns x, y (and z), with or without a header", read_table, ("frame", "time"))
_WCON = Format("midlines of worms (WCON)", read_wcon, ("worm", "frame", "time"))
READERS: dict[str, Format] = {
    **dict.fromkeys((".csv", ".tsv", ".txt", ".dat"), _TABLE),
    ".npy": Format("an array [point, 2 or 3] or [frame, point, 2 or 3]", read_array, ("frame",)),
    **dict.fromkeys((".wcon", ".json", ".wcon.zip"), _WCON),
    ".swc": Format("a traced tree, of which one path is taken", read_swc, ("branch",)),
}
"""Formats by suffix. A longer suffix goes before a shorter one."""
CHOICES = ("frame", "time", "worm", "branch")
"""Keys that choose one of the lines of a file."""


def suffix_of(path: Path) -> str | None:
    """The suffix of a path that has a row in ``READERS``, or None."""
    name = path.name.lower()
    return max((suffix for suffix in READERS if name.endswith(suffix)), key=len, default=None)


def read_track(path: Path, choice: Mapping[str, Any]) -> Track:
    """The points in a file; ``choice``: those of ``CHOICES`` that are not None.

    Raises TrackError for a file that cannot be read, and for a choice that its format does not have.
    """
    suffix = suffix_of(path)
    if suffix is None:
        raise TrackError(f"must end in one of {', '.join(READERS)}")
    given = {name: value for name, value in choice.items() if value is not None}
    for name, value in given.items():
        if name not in READERS[suffix].choices:
            known = READERS[suffix].choices
            has = f"lines are chosen by {', '.join(known)}"
            raise TrackError(f"{name} = {value!r}: not a choice in a {suffix} file, where {has}: leave it out")
    try:
        return READERS[suffix].read(path, **given)
    except OSError as fault:
        raise TrackError(f"cannot be read: {fault.strerror or fault}") from None
    except UnicodeError as fault:
        raise TrackError(f"is no text: {fault}") from None

"""Errors that users can cause or encounter; the command line shows them without a traceback."""

import difflib
from collections.abc import Iterable, Mapping
from typing import TypeVar

from warp_rods.documented import Documented

__all__ = ["RodFailure", "RunFolderError", "SceneError", "UnknownReproduction", "WarpRodsError"]

Row = TypeVar("Row")


class WarpRodsError(Exception, metaclass=Documented):
    """Base class of all errors of this package; ``exit_code`` is the exit code of the command line."""

    exit_code = 1
    _unlisted = frozenset({"exit_code"})


class SceneError(WarpRodsError, ValueError):
    """A scene or a parameter that is not valid; names each faulty key, its value and what is allowed."""

    exit_code = 2


class RunFolderError(WarpRodsError):
    """A run folder that already holds a run, holds none or one of another scene, or is damaged."""

    exit_code = 2


class RodFailure(WarpRodsError):
    """Rods that became non-finite or left their surface; names the rods, their times and parameters."""


class UnknownReproduction(WarpRodsError):
    """An unknown name of a reproduction; lists the known ones."""

    exit_code = 2


def nearest(word: object, known: Iterable[str]) -> str:
    """A hint with the most similar known word, or an empty text."""
    close = difflib.get_close_matches(str(word), list(known), n=1)
    return f" (did you mean {close[0]}?)" if close else ""


def named(table: Mapping[str, Row], what: str, name: object) -> Row:
    """A row of a table by its name; raises SceneError with all known names for an unknown one."""
    if not isinstance(name, str) or name not in table:
        raise SceneError(f"{what} = {name!r}: must be one of {', '.join(table) or 'none'}{nearest(name, table)}")
    return table[name]


def refuse_unknown(names: Iterable[str], known: Iterable[str], what: str) -> None:
    """Raises SceneError for the first unknown name."""
    known = list(known)
    for name in names:
        if name not in known:
            raise SceneError(f"{what}: unknown key {name!r}{nearest(name, known)}; known here: {', '.join(known)}")

"""The errors that a user can cause or meet; the command line shows them without a traceback."""

import difflib
from collections.abc import Iterable, Mapping
from typing import TypeVar

Row = TypeVar("Row")


class WarpRodsError(Exception):
    """Base of every error of this package; ``exit_code`` is what the command line returns for it."""

    exit_code = 1


class SceneError(WarpRodsError, ValueError):
    """A scene or a parameter that cannot be used: names each faulty key, its value and what is allowed."""

    exit_code = 2


class RunFolderError(WarpRodsError):
    """A run folder that holds a run already, or none, or one that does not fit the scene."""

    exit_code = 2


class RodFailure(WarpRodsError):
    """Rods that became non-finite or left their surface: names which, when, with what parameters."""


class UnknownReproduction(WarpRodsError):
    """A name that is none of the reproductions: lists those there are."""

    exit_code = 2


def nearest(word: object, known: Iterable[str]) -> str:
    """A hint with the known word that looks most like this one, or nothing."""
    close = difflib.get_close_matches(str(word), list(known), n=1)
    return f" (did you mean {close[0]}?)" if close else ""


def named(table: Mapping[str, Row], what: str, name: object) -> Row:
    """A row of a table by its name; raises SceneError with the names there are for one that is not known."""
    if not isinstance(name, str) or name not in table:
        raise SceneError(f"{what} = {name!r}: must be one of {', '.join(table) or 'none'}{nearest(name, table)}")
    return table[name]


def refuse_unknown(names: Iterable[str], known: Iterable[str], what: str) -> None:
    """Raises SceneError for the first of the names that is not known."""
    known = list(known)
    for name in names:
        if name not in known:
            raise SceneError(f"{what}: unknown key {name!r}{nearest(name, known)}; known here: {', '.join(known)}")

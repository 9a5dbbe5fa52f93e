"""Sources written from formulas, kept on disk beside Warp's compiled kernels: for each formula a file.

Its name is a hash of all that the source follows from: the formula, the names of its parameters, the programs that
wrote it, and the version of SymPy. A file that is damaged, or says something else than its name, is written again.
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path

from warp_rods import formula
from warp_rods.membranes.cache_folder import cache_folder, replace_file

__all__ = ["kept_source"]

FOLDER = "warp_rods_formulas"
"""In the folder of Warp's cache."""
WRITERS = ("field_source.py", "symbolic.py", "source_cache.py")
"""Modules beside this one from which a source follows."""


def kept_source(kind: str, phi: str, names: Sequence[str], make: Callable[[], str]) -> str:
    """The source of this kind for a formula; ``make`` writes it where it is not kept.

    Raises FormulaError where ``make`` does; a cache that cannot be read or written is no fault.
    """
    subject: dict[str, object] = {"kind": kind, "phi": phi, "names": list(names), "written_by": _writers()}
    file = _folder() / f"{_digest(json.dumps(subject))}.json"
    if (found := _read(file, subject)) is None:
        found = make()
        content = {**subject, "source": found, "sha256": _digest(found)}
        replace_file(file, json.dumps(content).encode("ascii"))
    return found


@functools.cache
def _writers() -> str:
    """A hash of the programs that write sources."""
    files = [Path(__file__).with_name(name) for name in WRITERS] + [Path(formula.__file__)]
    parts = [file.read_bytes() for file in files] + [version("sympy").encode()]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def _folder() -> Path:
    return cache_folder(FOLDER)


def _read(file: Path, subject: dict[str, object]) -> str | None:
    """The source in a file if it is whole and that of this subject."""
    try:
        found = json.loads(file.read_bytes())
        source = found["source"]
        whole = {key: found[key] for key in subject} == subject and found["sha256"] == _digest(source)
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None
    return source if whole else None


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()

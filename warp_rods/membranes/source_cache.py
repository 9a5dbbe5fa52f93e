"""Sources written from formulas, kept on disk beside Warp's compiled kernels: for each formula a file.

Its name is a hash of all that the source follows from: the formula, the names of its parameters, the programs that
wrote it, and the version of SymPy. A file that is damaged, or says something else than its name, is written again.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path

import warp as wp

from warp_rods import formula
from warp_rods.device import start

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
        _write(file, {**subject, "source": found, "sha256": _digest(found)})
    return found


@functools.cache
def _writers() -> str:
    """A hash of the programs that write sources."""
    files = [Path(__file__).with_name(name) for name in WRITERS] + [Path(formula.__file__)]
    parts = [file.read_bytes() for file in files] + [version("sympy").encode()]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def _folder() -> Path:
    start()  # which decides where the cache is
    return Path(wp.config.kernel_cache_dir or tempfile.gettempdir()) / FOLDER


def _read(file: Path, subject: dict[str, object]) -> str | None:
    """The source in a file if it is whole and that of this subject."""
    try:
        found = json.loads(file.read_bytes())
        source = found["source"]
        whole = {key: found[key] for key in subject} == subject and found["sha256"] == _digest(source)
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None
    return source if whole else None


def _write(file: Path, content: dict[str, object]) -> None:
    """Replace a file as a whole: other processes may read it, or write it at the same time."""
    with contextlib.suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        number, partial = tempfile.mkstemp(dir=file.parent, suffix=".partial")
        try:
            with os.fdopen(number, "w", encoding="ascii") as opened:
                json.dump(content, opened)
            os.replace(partial, file)
        except OSError:
            os.unlink(partial)
            raise


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()

"""Surfaces made from files, kept beside Warp's compiled kernels: for each a file.

To read a mesh, to smooth it and to sample the distance to it takes seconds. The name of a file is a hash of all that
the surface follows from: the content of the user's file, the values of the table, the programs of this folder, and the
versions of the libraries. A file that is damaged is made again.
"""

from __future__ import annotations

import functools
import hashlib
import io
import json
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.archive import read_archive
from warp_rods.kernels.surface import spline
from warp_rods.membranes.bodies import Bodies, Body
from warp_rods.membranes.cache_folder import cache_folder, replace_file
from warp_rods.membranes.level_set import Data, LevelSet
from warp_rods.membranes.triangles import Triangles

__all__ = ["kept_surface"]

FOLDER = "warp_rods_surfaces"
"""In the folder of Warp's cache."""
LARGEST_FILE, LARGEST = 100_000_000, 30_000_000
"""Bytes of the user's file, and of a surface that is kept, at most."""
LIBRARIES = ("numpy", "scipy", "trimesh", "warp-lang")


def kept_surface(path: Path, values: tuple[Any, ...], make: Callable[[], LevelSet]) -> LevelSet:
    """The surface that follows from the file and the ``values``; ``make`` makes it where it is not kept.

    Raises what ``make`` does, and OSError where the user's file cannot be read.
    """
    if path.stat().st_size > LARGEST_FILE:
        return make()
    subject = json.dumps([path.suffixes, values, _makers()]).encode() + path.read_bytes()
    file = _folder() / f"{hashlib.sha256(subject).hexdigest()}.npz"
    try:
        return _level_set(read_archive(file))
    except (ValueError, LookupError, TypeError):  # not there, or damaged
        made = make()
    if made.field is spline.spline and len(content := _content(made)) <= LARGEST:
        replace_file(file, content)
    return made


def _folder() -> Path:
    return cache_folder(FOLDER)


@functools.cache
def _makers() -> str:
    """A hash of the programs that make surfaces."""
    folders = (Path(__file__).parent, Path(spline.__file__).parent)
    files = sorted(file for folder in folders for file in folder.glob("*.py"))
    parts = [file.read_bytes() for file in files] + [version(name).encode() for name in LIBRARIES]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def _content(made: LevelSet) -> bytes:
    """The content of a file with a surface."""
    data, bodies = made.data, made.data.bodies
    words = {"notes": data.notes, "warnings": data.warnings, "metres": data.metres, "closed": made.closed}
    arrays: dict[str, Any] = {"grid": made.grid, "numbers": made.numbers, "low": made.box[0], "high": made.box[1]}
    arrays["words"] = np.frombuffer(json.dumps(words).encode(), dtype=np.uint8)
    if bodies is not None:
        arrays |= {"points": bodies.triangles.points, "faces": bodies.triangles.faces, "of_points": bodies.of_points}
        arrays |= {name: np.array([getattr(body, name) for body in bodies.bodies]) for name in Body._fields}
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def _level_set(arrays: dict[str, np.ndarray]) -> LevelSet:
    """The surface in a file."""
    words, bodies = json.loads(arrays["words"].tobytes()), None
    if "points" in arrays:
        rows = zip(*(arrays[name] for name in Body._fields), strict=True)
        each = [Body(float(volume), centre, int(depth)) for volume, centre, depth in rows]
        bodies = Bodies(each, Triangles(arrays["points"], arrays["faces"]), arrays["of_points"])
    data = Data(tuple(words["notes"]), tuple(words["warnings"]), bodies, words["metres"])
    box = arrays["low"], arrays["high"]
    return LevelSet(spline.spline, arrays["numbers"], box, words["closed"], grid=arrays["grid"], data=data)

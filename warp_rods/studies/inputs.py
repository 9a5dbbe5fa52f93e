"""The files that a study reads, as they were when it began: a point computed later must not see others."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

from warp_rods.scene.scene import paths_read
from warp_rods.simulation.files import digest
from warp_rods.studies.plan import Index, Plan

__all__ = ["inputs"]


def inputs(plan: Plan) -> dict[str, str]:
    """By path: the SHA-256 of each file that a scene of the study reads, of a folder that of the files in it.

    Of a folder names, sizes and times count, as a run may be large. Files that are not there have none.
    """
    paths = {path for point in _points(plan) for path in paths_read(plan.tables_at(point))}
    return {path: _digest(Path(path)) for path in sorted(paths)}


def _points(plan: Plan) -> Iterator[Index]:
    """The first point, and for each axis that may name files one with each of its values."""
    first = (0,) * len(plan.axes)
    yield first
    for number, axis in enumerate(plan.axes[:-1]):
        if any(not isinstance(value, (int, float)) for value in axis.values):
            yield from ((*first[:number], i, *first[number + 1 :]) for i in range(1, len(axis)))


def _digest(path: Path) -> str:
    if path.is_file():
        return digest(path)
    found = hashlib.sha256()
    for file in sorted(path.rglob("*")):
        about = file.stat()
        found.update(f"{file.relative_to(path)} {about.st_size} {about.st_mtime_ns}\n".encode())
    return found.hexdigest() if path.is_dir() else ""

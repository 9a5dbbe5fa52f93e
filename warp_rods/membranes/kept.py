"""The sampled field of a surface from a file, kept in a run folder: the same membrane, to the same bits, anywhere.

It does not depend on how a later version reads the file and smooths it.
"""

from __future__ import annotations

import functools
import io
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.archive import read_archive
from warp_rods.kernels.surface.spline import spline
from warp_rods.membranes.files import FileError
from warp_rods.membranes.level_set import Box, LevelSet, Values

__all__ = ["kept_bytes", "kept_level_set"]


def kept_bytes(grid: np.ndarray, numbers: np.ndarray, box: Box, values: Values) -> bytes:
    """The content of a file with the field of a surface; ``values``: those of its table, with spacing and origin."""
    buffer = io.BytesIO()
    arrays: dict[str, Any] = {"grid": grid, "numbers": numbers, "low": box[0], "high": box[1]}
    spacing = values.get("spacing")  # None: chosen when the surface was made
    arrays["spacing"] = np.array([] if spacing is None else spacing)
    np.savez(buffer, **arrays, origin=np.array(values["origin"]))
    return buffer.getvalue()


@functools.lru_cache(maxsize=4)
def kept_level_set(path: Path, changed: int, spacing: tuple[float, ...] | None, origin: tuple[float, ...]) -> LevelSet:
    """The surface in a file last changed at the time ``changed``; raises FileError.

    A kept field cannot be sampled again: ``spacing`` and ``origin`` must be those with which it was.
    """
    arrays = _read(path)
    for name, value in (("spacing", spacing or ()), ("origin", origin)):
        if tuple(arrays[name].tolist()) != tuple(value):
            raise FileError(
                f"is a field that a run kept, sampled with {name} = {arrays[name].tolist()}, not {list(value)}: give "
                f"the original file to sample it again"
            )
    return LevelSet(spline, arrays["numbers"], (arrays["low"], arrays["high"]), closed=None, grid=arrays["grid"])


def _read(path: Path) -> dict[str, np.ndarray]:
    """The arrays in a file, whose checksums are right."""
    try:
        stored = read_archive(path)
        return {name: stored[name] for name in ("grid", "numbers", "low", "high", "spacing", "origin")}
    except (ValueError, KeyError) as fault:
        raise FileError(f"is no field that a run kept, or is damaged: {fault}") from None

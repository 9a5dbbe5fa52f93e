"""The membrane given on a grid: kind = "grid" of a scene. A level set, a segmented stack, or a closed mesh."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy import ndimage

from warp_rods.kernels.surface.spline import spline
from warp_rods.membranes import distance
from warp_rods.membranes.distance import ShapeError
from warp_rods.membranes.kinds import Shape, Values

ARRAYS, MESHES = (".npy",), (".obj", ".stl", ".ply")
FEWEST_NODES = 8
MOST_NODES = 2e7
CELLS = 64
"""Grid spacings along the longest side of a mesh, where no spacing is given."""
PAD = 8
"""Nodes added on each side, as if φ went straight on, so that the ends of the spline are felt outside alone."""

Triple = tuple[float, float, float]
Faults = list[tuple[tuple[str | int, ...], str]]


class LevelSet:
    """φ from a file, as a C² spline on a grid."""

    key = "file"
    keys = ("file", "spacing", "origin")

    def read(self, raw: Values) -> tuple[dict[str, Any], Faults]:
        """The values with defaults filled in, and what is wrong with them."""
        faults: Faults = [
            ((name,), f": not a parameter of grid; it has {', '.join(self.keys)}")
            for name in raw
            if name not in self.keys
        ]
        spacing = _three(raw.get("spacing"), "spacing", "a positive number, or three", faults, positive=True)
        origin = _three(raw.get("origin"), "origin", "three numbers", faults)
        path = _path(raw.get("file"), faults)
        if path and path.suffix.lower() in ARRAYS and spacing is None and "spacing" not in raw:
            faults.append((("spacing",), ": missing; must be a positive number, or three: the distance between nodes"))
        if faults or path is None:
            return {}, faults
        try:
            spacing, origin = _filled(path, spacing, origin)
            _grid(str(path), path.stat().st_mtime_ns, spacing, origin)
        except (ShapeError, OSError) as error:
            return {}, [(("file",), f": {path} {error}")]
        return {"file": str(path), "spacing": spacing, "origin": origin}, []

    def shape(self, values: Values) -> Shape:
        """The surface with these values."""
        path = Path(values["file"])
        return _grid(str(path), path.stat().st_mtime_ns, tuple(values["spacing"]), tuple(values["origin"]))


def _path(value: Any, faults: Faults) -> Path | None:
    kinds = ", ".join(ARRAYS + MESHES)
    if not isinstance(value, str) or Path(value).suffix.lower() not in ARRAYS + MESHES:
        faults.append((("file",), f": must be the path of a file of a kind {kinds}, in quotes"))
        return None
    if not Path(value).is_file():
        faults.append((("file",), f": there is no file {value} (a path in a scene file starts at the scene's folder)"))
        return None
    return Path(value)


def _three(value: Any, name: str, allowed: str, faults: Faults, positive: bool = False) -> Triple | None:
    """Three numbers, from one where that is allowed; None where there is no value, or a wrong one."""
    if value is None:
        return None
    row = [value] * 3 if positive and not isinstance(value, Sequence) else value
    good = isinstance(row, Sequence) and len(row) == 3
    good = good and all(isinstance(v, (int, float)) and not isinstance(v, bool) and math.isfinite(v) for v in row)
    if not good or (positive and min(row) <= 0):
        faults.append(((name,), f": must be {allowed}"))
        return None
    return float(row[0]), float(row[1]), float(row[2])


def _filled(path: Path, spacing: Triple | None, origin: Triple | None) -> tuple[Triple, Triple]:
    """Spacing and origin, by default: of an array centred; of a mesh as it lies, in 64 steps."""
    if path.suffix.lower() in MESHES:
        if spacing is None:
            spacing = (float(distance.read_mesh(path).extents.max()) / CELLS,) * 3
        return spacing, origin or (0.0, 0.0, 0.0)
    assert spacing is not None  # refused before
    if origin is None:
        x, y, z = (-h * (n - 1) / 2 for h, n in zip(spacing, _array(path).shape, strict=True))
        origin = (x, y, z)
    return spacing, origin


def _array(path: Path) -> np.ndarray:
    try:
        values = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, EOFError) as error:
        raise ShapeError(f"cannot be read as an array: {error}") from None
    fits = values.ndim == 3 and min(values.shape) >= FEWEST_NODES and values.size <= MOST_NODES
    if not fits or values.dtype.kind not in "biuf":
        raise ShapeError(
            f"has shape {values.shape} of {values.dtype}: must be [x, y, z] with at least {FEWEST_NODES} nodes along "
            f"each and {MOST_NODES:.0g} in all; floats (φ, negative inside), or true or labels inside and 0 outside"
        )
    return values


@functools.lru_cache(maxsize=4)
def _grid(file: str, changed: int, spacing: Triple, origin: Triple) -> Shape:
    """The surface in a file that was last changed then; raises ShapeError."""
    path, h = Path(file), np.array(spacing)
    if path.suffix.lower() in MESHES:
        mesh = distance.read_mesh(path)
        if (count := np.prod(distance.nodes_round(mesh, h)[1], dtype=float)) > MOST_NODES:
            raise ShapeError(f"with spacing = {list(spacing)} needs {count:.2g} nodes; at most {MOST_NODES:.0g}")
        phi, first = distance.from_mesh(mesh, h)
        return spline_shape(phi, h, first + origin)
    values = _array(path)
    phi = values.astype(float) if values.dtype.kind == "f" else distance.from_cells(values != 0, h)
    if not np.isfinite(phi).all():
        raise ShapeError("holds values that are not finite")
    return spline_shape(phi, h, np.array(origin))


def spline_shape(phi: np.ndarray, spacing: np.ndarray, origin: np.ndarray) -> Shape:
    """The surface of φ [x, y, z] at nodes origin + (i, j, k) spacing: the cubic spline through them."""
    grid = ndimage.spline_filter(np.pad(phi, PAD, mode="reflect", reflect_type="odd"), order=3, mode="mirror")
    numbers = np.concatenate([origin - PAD * spacing, spacing])
    box = (np.array(origin), origin + (np.array(phi.shape) - 1) * spacing)
    return Shape(spline, numbers, box, closed=None, grid=grid)

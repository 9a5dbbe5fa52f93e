"""The surface from a file: kind = "grid" in a scene. A level set, a segmented stack, or a closed mesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from warp_rods.membranes.files import ARRAYS, KEPT, MESHES, FileError, read_array, read_mesh
from warp_rods.membranes.level_set import Fault, LevelSet, Values
from warp_rods.values import Positive, must_be, numbers

__all__ = ["Grid"]

CELLS = 64
"""Grid spacings along the longest side of a mesh, where no spacing is given."""

Triple = tuple[float, float, float]


class Grid:
    """φ from a file, as a C² spline on a grid."""

    keys = ("file", "spacing", "origin")

    def read(self, raw: Values) -> tuple[dict[str, Any], list[Fault]]:
        """The values with defaults filled in, and their faults.

        The file is read only where a default needs it: the size of a mesh, or the shape of an array.
        """
        faults: list[Fault] = []
        spacing = _spacing(raw.get("spacing"), faults)
        origin = _origin(raw.get("origin"), faults)
        path = _path(raw.get("file"), faults)
        if path and path.suffix.lower() in (*ARRAYS, KEPT) and "spacing" not in raw:
            faults.append((("spacing",), ": missing; must be a positive number, or three: the distance between nodes"))
        if faults or path is None:
            return {}, faults
        try:
            spacing = spacing or _default_spacing(path)
            origin = origin or _default_origin(path, spacing)
        except (FileError, OSError) as error:
            return {}, [(("file",), f": {path} {error}")]
        return {"file": str(path), "spacing": spacing, "origin": origin}, []

    def level_set(self, values: Values) -> LevelSet:
        """The surface with these values; raises FileError for a file that defines none."""
        from warp_rods.membranes.kept import kept_level_set
        from warp_rods.membranes.spline import from_file

        path = Path(values["file"])
        made = kept_level_set if path.suffix.lower() == KEPT else from_file
        return made(path, path.stat().st_mtime_ns, tuple(values["spacing"]), tuple(values["origin"]))


def _path(value: Any, faults: list[Fault]) -> Path | None:
    suffixes = ARRAYS + MESHES
    if not isinstance(value, str) or Path(value).suffix.lower() not in (*suffixes, KEPT):
        faults.append((("file",), must_be(f"the path of a file that ends in {', '.join(suffixes)}, in quotes", value)))
        return None
    if not Path(value).is_file():
        faults.append(
            (("file",), f": there is no file {value} (relative paths in a scene file start at the folder of the scene)")
        )
        return None
    return Path(value)


def _spacing(value: Any, faults: list[Fault]) -> Triple | None:
    """Three numbers, from one or three; None where there is no value or a wrong one."""
    if value is None:
        return None
    try:
        x, y, z = numbers(value if isinstance(value, tuple) else (value,) * 3, 3, Positive)
    except ValueError:
        faults.append((("spacing",), must_be("a positive number, or three", value)))
        return None
    return x, y, z


def _origin(value: Any, faults: list[Fault]) -> Triple | None:
    if value is None:
        return None
    try:
        x, y, z = numbers(value, 3)
    except ValueError:
        faults.append((("origin",), must_be("three numbers", value)))
        return None
    return x, y, z


def _default_spacing(path: Path) -> Triple:
    return (float(read_mesh(path).extents.max()) / CELLS,) * 3


def _default_origin(path: Path, spacing: Triple) -> Triple:
    """For an array, such that its middle is at the origin; a mesh is not moved."""
    if path.suffix.lower() in (*MESHES, KEPT):
        return 0.0, 0.0, 0.0
    x, y, z = (-h * (n - 1) / 2 for h, n in zip(spacing, read_array(path).shape, strict=True))
    return x, y, z

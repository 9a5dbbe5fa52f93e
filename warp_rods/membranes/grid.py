"""The surface from a file: kind = "grid" in a scene. A level set, a segmented stack, or a closed mesh."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any, ClassVar

from warp_rods.membranes.files import ARRAYS, IMAGES, KEPT, MESHES, FileError
from warp_rods.membranes.images import Header, ending, read_header
from warp_rods.membranes.level_set import Described, Fault, LevelSet, Values
from warp_rods.values import Positive, must_be, numbers, shown

__all__ = ["Grid"]

AXES = ("xyz", "zyx")
SUFFIXES = ARRAYS + MESHES + IMAGES
FILE = f"the path of a file that ends in {', '.join(SUFFIXES)}, in quotes"
SPACING, ORIGIN = "a positive number, or three", "three numbers"
AXES_WORDS = '"xyz" or "zyx", the order of the indices of the array'
LABEL = "a whole number, 1 or more: the label of the voxels inside"
"""What is allowed, in words."""

Triple = tuple[float, float, float]


class Grid:
    """φ from a file, as a C² spline on a grid."""

    described: ClassVar = {
        "file": Described("closed mesh, segmented stack, or level set that is negative inside", FILE),
        "spacing": Described("size of a voxel along x, y, z, or spacing of the grid of a mesh (length)", SPACING),
        "origin": Described("middle of the first voxel, or displacement of a mesh (length)", ORIGIN),
        "axes": Described("indices of a stack", AXES_WORDS),
        "label": Described("which voxels of a stack are inside; all that are not 0 if left out", LABEL),
    }
    keys = tuple(described)

    def read(self, raw: Values) -> tuple[dict[str, Any], list[Fault]]:
        """The values with defaults filled in, and their faults.

        Of the file only the header is read, for the voxel size and the shape of a stack. The spacing of a mesh, where
        none is given, is chosen when the surface is made.
        """
        faults: list[Fault] = []
        spacing = _spacing(raw.get("spacing"), faults)
        origin = _origin(raw.get("origin"), faults)
        path = _path(raw.get("file"), faults)
        is_mesh = path is not None and ending(path) in MESHES
        order = _of_stacks("axes", raw.get("axes"), is_mesh, faults)
        label = _of_stacks("label", raw.get("label"), is_mesh, faults)
        if path and not is_mesh and ending(path) in ARRAYS and "spacing" not in raw:
            faults.append((("spacing",), ": missing; must be a positive number, or three: the distance between nodes"))
        if faults or path is None:
            return {}, faults
        values: dict[str, Any] = {"file": str(path)}
        if is_mesh or ending(path) == KEPT:
            given = {"spacing": spacing, "axes": order, "label": label}
            values |= {key: value for key, value in given.items() if value is not None}
            return values | {"origin": origin or (0.0, 0.0, 0.0)}, []
        try:
            header = read_header(path, order)
        except (FileError, OSError) as error:
            return {}, [(("file",), f": {path} {error}")]
        if (spacing := spacing or header.spacing) is None:
            text = f": missing, and {path} has no voxel size; must be a positive number, or three (x, y, z)"
            return {}, [(("spacing",), text)]
        values |= {"spacing": spacing, "origin": origin or _default_origin(header, spacing)}
        values |= {"axes": header.axes} if order or header.axes != "xyz" else {}
        return values | ({} if label is None else {"label": label}), []

    def level_set(self, values: Values) -> LevelSet:
        """The surface with these values; raises FileError for a file that defines none."""
        from warp_rods.membranes.kept import kept_level_set

        path, spacing = Path(values["file"]), values.get("spacing")
        changed, origin = path.stat().st_mtime_ns, tuple(values["origin"])
        spacing = None if spacing is None else tuple(spacing)
        if ending(path) == KEPT:
            return kept_level_set(path, changed, spacing, origin)
        return _from_file(path, changed, spacing, origin, values.get("axes"), values.get("label"))


@functools.lru_cache(maxsize=4)
def _from_file(
    path: Path, changed: int, spacing: Triple | None, origin: Triple, axes: str | None, label: int | None
) -> LevelSet:
    """The surface in a file last changed at the time ``changed``."""
    from warp_rods.membranes.surface_cache import kept_surface

    def make() -> LevelSet:
        from warp_rods.membranes.data import from_file  # slow to import

        return from_file(path, spacing, origin, axes, label)

    return kept_surface(path, (spacing, origin, axes, label), make)


def _path(value: Any, faults: list[Fault]) -> Path | None:
    if not isinstance(value, str) or ending(Path(value)) not in (*SUFFIXES, KEPT):
        faults.append((("file",), must_be(FILE, value)))
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
        faults.append((("spacing",), must_be(SPACING, value)))
        return None
    return x, y, z


def _origin(value: Any, faults: list[Fault]) -> Triple | None:
    if value is None:
        return None
    try:
        x, y, z = numbers(value, 3)
    except ValueError:
        faults.append((("origin",), must_be(ORIGIN, value)))
        return None
    return x, y, z


def _of_stacks(key: str, value: Any, is_mesh: bool, faults: list[Fault]) -> Any:
    """The value of ``axes`` or ``label``, or None; a mesh has neither."""
    if value is None:
        return None
    if is_mesh:
        faults.append(((key,), f" = {shown(value)}: is for stacks of voxels; leave it out for a mesh"))
    elif key == "axes" and value not in AXES:
        faults.append(((key,), must_be(AXES_WORDS, value)))
    elif key == "label" and (type(value) is not int or value < 1):
        faults.append(((key,), must_be(LABEL, value)))
    return value


def _default_origin(header: Header, spacing: Triple) -> Triple:
    """Such that the middle of the array is at the origin."""
    x, y, z = (-h * (n - 1) / 2 for h, n in zip(spacing, header.shape, strict=True))
    return x, y, z

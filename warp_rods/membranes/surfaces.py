"""Make a surface of any kind, for example ``make("sphere", {"radius": 1.0})``.

The kinds are the keys of ``KINDS``; ``KINDS[kind].keys`` are the names of the values of a kind.
"""

from __future__ import annotations

import logging
from typing import Any

from warp_rods.errors import SceneError
from warp_rods.formula import FormulaError
from warp_rods.membranes.bodies import Bodies, oriented
from warp_rods.membranes.built_in import SURFACES
from warp_rods.membranes.built_in import Parameter as Parameter
from warp_rods.membranes.built_in import SurfaceKind as SurfaceKind
from warp_rods.membranes.catalogue import GIVEN as GIVEN
from warp_rods.membranes.catalogue import KINDS, motion_faults, read
from warp_rods.membranes.files import FileError
from warp_rods.membranes.inspection import inspect
from warp_rods.membranes.level_set import Fault
from warp_rods.membranes.mesh import triangulate
from warp_rods.membranes.surface import Surface
from warp_rods.values import key_path, plain

__all__ = ["KINDS", "Surface", "make"]


def make(kind: str, values: Any, *, path: str = "surface", end: float = 0.0) -> Surface:
    """The surface of this kind with these values and defaults; surfaces from formulas and files are inspected.

    values: by name, as in the table [surface] of a scene; NumPy scalars, arrays, tuples and paths are accepted. path:
    the name of the table in messages. end: time up to which a moving surface is checked. Raises SceneError naming every
    fault: an unknown kind or parameter, a missing or impossible value, a φ that defines no smooth surface.
    Warnings go to the logger ``warp_rods``; what became of a file is in ``data`` of the surface.
    """
    surface = built(kind, values, path=path, end=end)
    for line in surface.data.warnings:
        logging.getLogger("warp_rods").warning("%s: %s", path, line)
    return surface


def built(kind: str, values: Any, *, path: str, end: float) -> Surface:
    """As ``make``, without logging."""
    filled, faults = read(plain(kind), plain(values))
    faults = faults or motion_faults(kind, filled, end)
    if not faults:
        surface, faults = _built(kind, filled, end)
    if faults:
        raise SceneError("\n".join(path + ("." if loc else "") + key_path(loc) + text for loc, text in faults))
    return surface


def bodies_of(surface: Surface) -> Bodies:
    """The bodies of a surface; of one without data those of its triangulation at t = 0."""
    if surface.data.bodies is not None:
        return surface.data.bodies
    mesh = triangulate(surface)
    return oriented(mesh.points, mesh.triangles)[0]


def _built(kind: str, values: dict[str, Any], end: float) -> tuple[Any, list[Fault]]:
    """The surface, or None, and its faults."""
    try:
        surface = Surface(kind, values, KINDS[kind])
    except FormulaError as error:
        return None, [(("phi",), f": {error}")]
    except (FileError, OSError) as error:
        return None, [(("file",), f": {values['file']} {error}")]
    if kind in SURFACES:
        return surface, []
    surface.closed, found = inspect(surface)
    if found:
        return surface, [(KINDS[kind].keys[:1], text) for text in found]
    return surface, _faults_later(surface, end) if surface.moving and end else []


def _faults_later(surface: Surface, end: float) -> list[Fault]:
    """Faults of a moving surface at half the time and at the end."""
    for time in (end / 2, end):
        closed, found = inspect(surface.at(time))
        if surface.closed and not closed and not found:
            found = ["has left its box and is no longer closed: widen the box"]
        if found:
            return [((), f" at t = {time:.4g}: {text.removeprefix(': ')}") for text in found]
    return []

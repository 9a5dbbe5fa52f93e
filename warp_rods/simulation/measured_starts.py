"""Measured centre lines as the shape of rods at the start."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.centrelines.centreline import Line, line_of
from warp_rods.centrelines.on_membrane import CentrelineOnMembrane, on_membrane
from warp_rods.centrelines.readers import CHOICES, read_track
from warp_rods.centrelines.track import Track, TrackError
from warp_rods.errors import SceneError
from warp_rods.membranes.surface import Surface
from warp_rods.rods.per_rod import each_rod
from warp_rods.scene.filaments import FilamentsTable
from warp_rods.scene.scene import Scene
from warp_rods.scene.shapes import Start
from warp_rods.scene.swimmers import SwimmersTable
from warp_rods.simulation.files import digest
from warp_rods.simulation.start_arrays import Arrays, Given, Source

__all__ = ["from_points", "sources_of_points"]

MOST_NOTES = 5
"""Lines about the points of an ensemble, at most."""


def from_points(table: SwimmersTable | FilamentsTable, scene: Scene, surface: Surface | None) -> Given:
    """The rods along the centre lines of a table; raises SceneError naming its key, and the file."""
    lines = _lines(table, scene)
    if isinstance(table, SwimmersTable):
        return Given(functools.cache(functools.partial(_free, table, lines)), sources_of_points(table))
    assert surface is not None  # a scene of filaments without a surface is refused
    return Given(functools.cache(functools.partial(_bound, table, lines, surface)), sources_of_points(table))


def sources_of_points(table: SwimmersTable | FilamentsTable) -> tuple[Source, ...]:
    """The files of a table, with their hashes as they are now."""
    assert table.shape is not None
    return tuple((path, digest(Path(path))) for path in dict.fromkeys(_each(table.shape.points, table.count)))


def _each(value: Any, count: int) -> list[Any]:
    return list(value) if isinstance(value, tuple) else [value] * count


def _lines(table: SwimmersTable | FilamentsTable, scene: Scene) -> list[Line]:
    """The line of each rod; lines that are the same are read once."""
    shape, count = table.shape, table.count
    assert shape is not None and shape.points is not None
    keys = ("points", *CHOICES)
    rows = list(zip(*(_each(getattr(shape, key), count) for key in keys), strict=True))
    read = functools.cache(functools.partial(_line, table, scene))
    found = []
    for rod, row in enumerate(rows):
        try:
            found.append(read(*row))
        except TrackError as fault:
            index = f"[{rod}]" if isinstance(shape.points, tuple) else ""
            raise SceneError(f"shape.points{index}: {row[0]} {fault}") from None
    return found


def _line(table: SwimmersTable | FilamentsTable, scene: Scene, path: str, *choice: Any) -> Line:
    shape = table.shape
    assert shape is not None
    track = read_track(Path(path), dict(zip(CHOICES, choice, strict=True)))
    scale, notes = (1.0, ()) if isinstance(table, SwimmersTable) else _scale(shape, track, scene)
    unit = None if isinstance(table, SwimmersTable) else 1.0
    line = line_of(Track(track.points * scale, track.metres, track.chosen), shape.smoothing, bool(shape.reverse), unit)
    return Line(line.curve, line.points, line.metres, (*line.notes, *notes))


def _scale(shape: Start, track: Track, scene: Scene) -> tuple[float, tuple[str, ...]]:
    """What one unit of the points is in units of the scene, and a line about it."""
    given = getattr(shape, "scale", None)
    if given is not None:
        return float(given), ()
    if track.metres is None:
        return 1.0, ()
    if scene.units is None:
        return 1.0, (f"one unit of the file is {track.metres:g} m: without [units] it is taken as that of the scene",)
    scale = track.metres / scene.units.metres
    return scale, (f"one unit of the file is {scale:g} of the scene",) if scale != 1 else ()


def _free(table: SwimmersTable, lines: Sequence[Line], nodes: int) -> tuple[Arrays, list[str]]:
    made = {id(line): line.rod(nodes) for line in lines}
    rods = [made[id(line)] for line in lines]
    lengths = np.array([rod.length for rod in rods])
    # Swimmers have the length one; places are in the mean of their lengths, so that distances have one unit.
    place = np.array([rod.position for rod in rods]) * (lengths / lengths.mean())[:, None]
    arrays = {
        "strain": np.array([rod.strain for rod in rods]),
        "position": place,
        "rotation": np.array([rod.rotation for rod in rods]),
    }
    off = np.array([[rod.rms, rod.largest] for rod in rods]) / lengths[:, None]
    halved = np.array([rod.smoothing for rod in rods]) / lengths
    text = (
        f"{table.name}: the length of the centre line in the file, {_range(lengths)}, is 1; bends with a wavelength of "
        f"{_range(halved)} were halved; the rod is within {off[:, 1].max():.2g} of the points (rms "
        f"{np.sqrt(np.mean(off[:, 0] ** 2)):.2g}); it has no twist, which a centre line does not tell"
    )
    return arrays, [text, *_told(table.name, lines)]


def _bound(table: FilamentsTable, lines: Sequence[Line], surface: Surface, nodes: int) -> tuple[Arrays, list[str]]:
    lengths = [None] * table.count if table.length is None else each_rod(table.length, table.count).tolist()
    made: dict[tuple[int, float | None], CentrelineOnMembrane] = {}
    for rod, (line, length) in enumerate(zip(lines, lengths, strict=True)):
        if (id(line), length) not in made:
            try:
                found = on_membrane(line.curve, line.points.points, surface.at(0.0), nodes, length)
            except TrackError as fault:
                raise SceneError(f"shape.points: the line of rod {rod} {fault}") from None
            made[id(line), length] = found
    rods = [made[id(line), length] for line, length in zip(lines, lengths, strict=True)]
    arrays = {
        "line": np.array([rod.line for rod in rods]),
        "tangent": np.array([rod.tangent for rod in rods]),
        "geodesic_curvature": np.array([rod.geodesic_curvature for rod in rods]),
        "length": np.array([rod.length for rod in rods]),
    }
    found_rms, off_rms = (np.sqrt(np.mean([getattr(rod, key) ** 2 for rod in rods])) for key in ("rms", "off_rms"))
    farthest, largest = (max(getattr(rod, key) for rod in rods) for key in ("off_largest", "largest"))
    text = (
        f"{table.name}: points up to {farthest:.2g} away from the membrane (rms {off_rms:.2g}) were projected onto it; "
        f"bends with a wavelength of {_range(np.array([rod.smoothing for rod in rods]))} were halved; the filament, of "
        f"length {_range(arrays['length'])}, is within {largest:.2g} of the points (rms {found_rms:.2g})"
    )
    return arrays, [text, *_told(table.name, lines)]


def _told(name: str, lines: Sequence[Line]) -> list[str]:
    notes = dict.fromkeys(note for line in lines for note in line.notes)
    return [f"{name}: {note}" for note in list(notes)[:MOST_NOTES]]


def _range(values: np.ndarray) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{low:.4g}" if f"{low:.4g}" == f"{high:.4g}" else f"{low:.4g} to {high:.4g}"

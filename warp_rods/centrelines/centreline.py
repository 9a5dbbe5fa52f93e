"""Centre lines as rods: ``from_centreline`` in Python, and ``read_line`` for scenes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from warp_rods import arguments
from warp_rods.centrelines.curve import DEFAULT, Curve, check_smoothing, fitted_curve
from warp_rods.centrelines.on_membrane import CentrelineOnMembrane, on_membrane
from warp_rods.centrelines.points import Points, cleaned
from warp_rods.centrelines.readers import READERS, read_track
from warp_rods.centrelines.rod import PARTS, bishop_strains, distances, laid_out
from warp_rods.centrelines.track import Track, TrackError
from warp_rods.documented import Documented
from warp_rods.errors import SceneError

if TYPE_CHECKING:
    from warp_rods.membranes.surface import Surface

__all__ = ["Centreline", "Line", "from_centreline", "line_of", "read_line"]


@dataclass(frozen=True)
class Centreline(metaclass=Documented):
    """A free rod along a measured centre line, of length 1 and without twist, which a centre line does not tell.

    strain [node, 3]: for ``shape`` of ``FreeRods``; zero at the ends, which are free. position [3], rotation [3, 3]: of
    its middle node, in lengths of the rod. line [node, 3]: the rod in units of the points. length: of the smooth line.
    smoothing: the wavelength that was halved. rms, largest: distances of the points from the rod. All four are in units
    of the points. notes: what was done with the points.
    """

    strain: np.ndarray = field(repr=False)
    position: np.ndarray = field(repr=False)
    rotation: np.ndarray = field(repr=False)
    line: np.ndarray = field(repr=False)
    length: float
    smoothing: float
    rms: float
    largest: float
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Line:
    """A smooth curve, the points along it, and lines about them. metres: one unit of the points, where it is known."""

    curve: Curve
    points: Points
    metres: float | None
    notes: tuple[str, ...]

    def rod(self, nodes: int) -> Centreline:
        """The free rod along it."""
        strain, rotation = bishop_strains(self.curve, nodes)
        strain[[0, -1]] = 0.0
        length = self.curve.length
        middle = self.curve.place(np.array([length * (nodes // 2) / (nodes - 1)]))[0] / length
        line = length * laid_out(strain, middle, rotation, PARTS)
        off = distances(self.points.points, line)
        return Centreline(
            strain, middle, rotation, line[::PARTS], length, self.curve.wavelength, float(np.sqrt(np.mean(off**2))),
            float(off.max()), self.notes,
        )  # fmt: skip


def line_of(track: Track, smoothing: Any = DEFAULT, reverse: bool = False, unit: float | None = None) -> Line:
    """The smooth curve along a track; raises TrackError, and SceneError for a wrong smoothing."""
    points = cleaned(track.points[::-1] if reverse else track.points)
    notes = ([track.chosen] if track.chosen else []) + list(points.notes)
    return Line(fitted_curve(points.points, smoothing, unit), points, track.metres, tuple(notes))


def read_line(
    path: str, choice: Mapping[str, Any], smoothing: Any, reverse: bool, scale: float = 1.0, unit: float | None = None
) -> Line:
    """The line in a file, its points multiplied by ``scale``; raises TrackError, whose message follows the path."""
    track = read_track(Path(path), choice)
    metres = None if track.metres is None else track.metres / scale
    return line_of(Track(track.points * scale, metres, track.chosen), smoothing, reverse, unit)


def from_centreline(
    points: Any,
    nodes: int = 65,
    *,
    smoothing: float | str = DEFAULT,
    reverse: bool = False,
    surface: Surface | None = None,
    length: float | None = None,
    scale: float = 1.0,
    frame: int | None = None,
    time: float | None = None,
    worm: str | int | None = None,
    branch: int | None = None,
) -> Centreline | CentrelineOnMembrane:
    """The rod along a measured centre line: a free one of length 1, or with ``surface`` a filament on that membrane.

    points: [point, 2 or 3] in order, NaN where one is missing, or the path of a file (``READERS``; frame, time, worm,
    branch choose one of its lines). smoothing: the wavelength that is halved, as a length (of a free rod in lengths of
    the rod, on a membrane in its units) or in mean distances of points; 0: through every point. reverse: from the last
    point to the first. scale: what one unit of the points is, in units of the membrane; length: of the filament,
    otherwise that of the line. Raises SceneError for points that are no line, and for one far from the membrane.
    """
    nodes, scale = arguments.whole("nodes", nodes, 3), arguments.real("scale", scale)
    check_smoothing(smoothing)
    reverse = arguments.truth("reverse", reverse)
    choice = {"frame": frame, "time": time, "worm": worm, "branch": branch}
    unit = None if surface is None else 1.0
    is_path = isinstance(points, (str, os.PathLike))
    try:
        if is_path:
            line = read_line(os.fspath(points), choice, smoothing, reverse, scale, unit)
        else:
            if given := [name for name, value in choice.items() if value is not None]:
                raise SceneError(f"{given[0]}: chooses a line of a file; points are given: leave it out")
            line = line_of(Track(arguments.reals("points", points) * scale), smoothing, reverse, unit)
        if surface is None:
            return line.rod(nodes)
        return on_membrane(line.curve, line.points.points, surface, nodes, length, line.notes)
    except TrackError as fault:
        raise SceneError(f"points: {points if is_path else 'the line'} {fault}") from None


FORMATS = tuple(READERS)
"""Suffixes of files that can be read."""

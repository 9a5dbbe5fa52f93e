"""What is drawn of a run: its chosen ensembles, frames and colours, membrane and box; for all exporters the same.

    shown = content("runs/proteins", Selection(frames=slice(0, None, 10)))
    for frame in range(shown.frames):
        for rods in shown.rods:
            colours = shown.scale(frame).rgb(rods.values(frame))  # of rods.positions(frame)

A frame is given by its number among the chosen ones, from 0.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr

from warp_rods.draw.colours import COLOURS, Colour
from warp_rods.draw.labels import named
from warp_rods.draw.rods import Rods
from warp_rods.draw.room import edges_of, sides_of
from warp_rods.draw.scale import Scale, scale_of
from warp_rods.draw.selection import Selection
from warp_rods.draw.sheet import Sheet
from warp_rods.errors import RunFolderError
from warp_rods.scene.scene import Scene
from warp_rods.scene.units import dimension_of
from warp_rods.simulation.reading import open_run

__all__ = ["Content", "content"]

_SLENDERNESS = 60
"""Length over radius of rods that are drawn without a steric core."""
ROUND_OFF = 1e-12
"""Numbers of order one that are smaller are none: of sums and differences, and of equations that were solved."""
_SAMPLED = 100
"""Largest number of frames from which a range of values, or a view, is estimated."""


class Content:
    """What is drawn of a run.

    title, scene, selection (with the name of a colour), attributes (of the run); colour: the row of ``COLOURS``;
    numbers: the chosen frames of the trajectory, a range; times [frame]; frames: their count; all_times: of all frames
    of the trajectory; rods: the chosen ensembles; membrane, container: surfaces or None; box: sides [3] of the box, or
    None where there are none to draw; period [3], 0 where it is open.
    """

    def __init__(self, run: xr.DataTree, selection: Selection) -> None:
        self.attributes = dict(run.attrs)
        self.scene, self.title = Scene.parse(run.attrs["scene"]), str(run.attrs.get("title", ""))
        chosen = {name: run[name].to_dataset() for name in selection.names(list(run.children))}
        self.selection = replace(selection, colour=_colour(selection.colour, chosen))
        self.colour: Colour = COLOURS[self.selection.colour]
        every = next(iter(chosen.values()))
        self.numbers = selection.numbers(every.sizes["frame"])
        self.frames = len(self.numbers)
        self.all_times: np.ndarray = every["time"].values
        self.times: np.ndarray = self.all_times[np.asarray(self.numbers)]
        self.period, self.box = np.array(self.scene.period), sides_of(self.scene)
        self.rods = self._rods_at(chosen, self.numbers)
        self._chosen = chosen
        walls = self.scene.box.surface if self.scene.box else None
        duration = float(self.all_times[-1] - self.all_times[0]) or self.spacing
        self._round_off = max(_round_off(self.colour, data, duration) for data in chosen.values())
        self.membrane = Sheet(self.scene.surface, self.all_times, self.numbers) if self.scene.surface else None
        self.container = Sheet(walls, self.all_times, self.numbers) if walls else None

    def _rods_at(self, chosen: dict[str, xr.Dataset], numbers: range) -> list[Rods]:
        """The chosen ensembles at frames of the trajectory."""
        return [
            Rods(name, data, numbers, self.colour, _radius(self.scene, data), self.period)
            for name, data in chosen.items()
        ]

    @property
    def metres(self) -> float:
        """One unit of length in metres; 1 where the scene has no units."""
        return self.scene.units.metres if self.scene.units else 1.0

    @property
    def seconds(self) -> float | None:
        """One unit of time in seconds; None where the scene does not say."""
        units = self.scene.units
        return float(units.scale.units["time"]) if units and units.time else None

    def named(self, name: str, product: str) -> str:
        """A name and units such as "length/time" as on plots: in SI where the scene has these units."""
        return named(name, self.in_si(product))

    def in_si(self, product: str) -> str:
        """Units such as "length/time" as a number and a unit in SI, where the scene has these units."""
        return self.scene.units.scale.in_si(product) if self.scene.units else product

    @property
    def label(self) -> str:
        """What is written beside the bar of the colours: the quantity and its units."""
        return self.named(self.colour.label, self.colour.unit)

    @property
    def spacing(self) -> float:
        """The time between frames of the trajectory."""
        steps = np.diff(self.all_times)
        return float(np.median(steps)) if len(steps) else float(self.scene.time.save_every)

    @property
    def edges(self) -> np.ndarray:
        """Both ends [line, 2, 3] of the lines along the edges of the box; none where there are none to draw."""
        return edges_of(self.scene)

    def scale(self, frame: int) -> Scale:
        """The scale of the colours at a frame: that of the whole run, of this frame, or the given one."""
        span = self.selection.span
        if span == "frame":
            return scale_of(self.colour, _values(self.rods, [frame]), self._round_off)
        return self._of_run if span == "run" else self._given

    @cached_property
    def _of_run(self) -> Scale:
        """That of a sample of all frames of the trajectory, so that stills and films of one run can be compared."""
        return scale_of(self.colour, self._values_of_run, self._round_off)

    @cached_property
    def _given(self) -> Scale:
        span = self.selection.span
        assert not isinstance(span, str)
        return Scale(self.colour, *span).marked(self._values_of_run)

    @cached_property
    def _values_of_run(self) -> np.ndarray:
        """The values of the colour at a sample of all frames of the trajectory, [frame, value]."""
        numbers = _spaced(len(self.all_times), _SAMPLED)
        every = self._rods_at(self._chosen, numbers)
        return np.stack([_values(every, [frame]) for frame in range(len(numbers))])

    def sample(self, most: int = _SAMPLED) -> range:
        """At most so many of the chosen frames, evenly spaced from the first."""
        return _spaced(self.frames, most)

    def bounds(self, frames: range | list[int] | None = None) -> np.ndarray:
        """Lower and upper corner [2, 3] of what is drawn at these frames (default: at a sample of all).

        Rods with their thickness, membrane, container and box.
        """
        frames, corners = self.sample() if frames is None else frames, []
        for rods in self.rods:
            for frame in frames:
                points = rods.positions(frame).reshape(-1, 3)
                corners += [points.min(axis=0) - rods.radius, points.max(axis=0) + rods.radius]
        for sheet in (self.membrane, self.container):
            if sheet is not None:
                for frame in frames if sheet.moving else [0]:
                    points = sheet.mesh(frame).points
                    corners += [points.min(axis=0), points.max(axis=0)]
        if self.box is not None:
            corners += [-self.box / 2, self.box / 2]
        return np.array([np.min(corners, axis=0), np.max(corners, axis=0)])


def content(run_dir: str | Path, selection: Selection | None = None) -> Content:
    """What is drawn of the run in a folder.

    Raises RunFolderError where there is no run, no complete frame, or not the quantity of the colour that is named;
    SceneError for ensembles and frames that the run does not have.
    """
    run = open_run(run_dir)
    if not any(data.sizes["frame"] for data in run.children.values()):
        raise RunFolderError(f"{run_dir} has no complete frame: resume the run, or run the scene again.")
    return Content(run, selection or Selection())


def _spaced(count: int, most: int) -> range:
    """At most so many of ``count`` frames, evenly spaced from the first."""
    return range(0, count, -(-count // most))


def _values(every: list[Rods], frames: list[int]) -> np.ndarray:
    """All values of the colour of these rods at these frames."""
    return np.concatenate([rods.values(frame).ravel() for rods in every for frame in frames])


def _radius(scene: Scene, data: xr.Dataset) -> float:
    """Half the steric core where there is one, so that rods in contact touch as drawn; else that of a slender rod."""
    if scene.steric:
        return scene.steric.core / 2
    return _length(data) / _SLENDERNESS


def _length(data: xr.Dataset) -> float:
    """Mean length of the rods at the end, where growing ones are longest."""
    steps = np.diff(data.position.isel(frame=-1).values, axis=1)
    return float(np.linalg.norm(steps, axis=-1).sum(axis=1).mean()) or 1.0


def _round_off(colour: Colour, data: xr.Dataset, duration: float) -> float:
    """The size up to which values of a colour are round-off: 1e-12 of one in units of the rods themselves.

    Their unit of length is that of a rod, of time the run, of force B/L².
    """
    dimension = dimension_of(colour.unit)
    if dimension is None:
        return 0.0
    length = _length(data)
    stiffness = next((float(data[key].min()) for key in ("stiffness", "bending_stiffness") if key in data), 0.0)
    one = length ** dimension[0] * duration ** dimension[1] * (stiffness / length**2) ** dimension[2]
    return one * (ROUND_OFF**2 if colour.quadratic else ROUND_OFF)


def _colour(name: str, chosen: dict[str, xr.Dataset]) -> str:
    """The name of a colour, by default of the first that any of these ensembles has; position is enough for some.

    Raises RunFolderError where none has the one that is named.
    """
    has = [key for key, row in COLOURS.items() if any(row.is_in(data) for data in chosen.values())]
    if not name or name in has:
        return name or has[0]
    row, whose = COLOURS[name], f"colour = {name!r}: the trajectory of {', '.join(chosen)}"
    if all(need in data for data in chosen.values() for need in row.needs):
        raise RunFolderError(
            f"{whose} has one frame, and {row.label} needs {row.frames}; its rods can have the colours "
            f"{', '.join(has)}; or run the scene with a smaller time.save_every"
        )
    raise RunFolderError(
        f"{whose} has no {', '.join(row.needs)}; its rods can have the colours {', '.join(has)}; or run the scene "
        "with it among output.variables"
    )

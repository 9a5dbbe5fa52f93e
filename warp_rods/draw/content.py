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
from warp_rods.draw.rods import Rods
from warp_rods.draw.room import edges_of, sides_of
from warp_rods.draw.scale import Scale, scale_of
from warp_rods.draw.selection import Selection
from warp_rods.draw.sheet import Sheet
from warp_rods.errors import RunFolderError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.reading import open_run

__all__ = ["Content", "content"]

_SLENDERNESS = 60
"""Length over radius of rods that are drawn without a steric core."""
_SAMPLED = 100
"""Largest number of frames from which a range of values, or a view, is estimated."""


class Content:
    """What is drawn of a run.

    title, scene, selection (with the name of a colour), attributes (of the run); colour: the row of ``COLOURS``;
    numbers: the chosen frames of the trajectory, a range; times [frame]; frames: their count; rods: the chosen
    ensembles; membrane, container: surfaces or None; box: sides [3] of the box, or None where there are none to draw;
    period [3], 0 where it is open.
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
        all_times = every["time"].values
        self.times: np.ndarray = all_times[np.asarray(self.numbers)]
        self.period, self.box = np.array(self.scene.period), sides_of(self.scene)
        self.rods = [
            Rods(name, data, self.numbers, self.colour, _radius(self.scene, data), self.period)
            for name, data in chosen.items()
        ]
        walls = self.scene.box.surface if self.scene.box else None
        self.membrane = Sheet(self.scene.surface, all_times, self.numbers) if self.scene.surface else None
        self.container = Sheet(walls, all_times, self.numbers) if walls else None

    @property
    def metres(self) -> float:
        """One unit of length in metres; 1 where the scene has no units."""
        return self.scene.units.metres if self.scene.units else 1.0

    @property
    def edges(self) -> np.ndarray:
        """Both ends [line, 2, 3] of the lines along the edges of the box; none where there are none to draw."""
        return edges_of(self.scene)

    def scale(self, frame: int) -> Scale:
        """The scale of the colours at a frame: that of the run, of this frame, or the given one."""
        span = self.selection.span
        if span == "frame":
            return scale_of(self.colour, self._values([frame]))
        return self._of_run if span == "run" else Scale(self.colour, *span)

    @cached_property
    def _of_run(self) -> Scale:
        return scale_of(self.colour, self._values(self.sample()))

    def sample(self, most: int = _SAMPLED) -> range:
        """At most so many of the frames, evenly spaced from the first."""
        return range(0, self.frames, -(-self.frames // most))

    def _values(self, frames: range | list[int]) -> np.ndarray:
        """All values of the colour at these frames."""
        return np.concatenate([rods.values(frame).ravel() for rods in self.rods for frame in frames])

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


def _radius(scene: Scene, data: xr.Dataset) -> float:
    """Half the steric core where there is one, so that rods in contact touch as drawn; else that of a slender rod."""
    if scene.steric:
        return scene.steric.core / 2
    steps = np.diff(data.position.isel(frame=-1).values, axis=1)  # growing rods are longest at the end
    lengths = np.linalg.norm(steps, axis=-1).sum(axis=1)
    lengths = lengths if np.isfinite(lengths).any() else np.ones(1)
    return float(np.nanmean(lengths) / _SLENDERNESS)  # without failed rods


def _colour(name: str, chosen: dict[str, xr.Dataset]) -> str:
    """The name of a colour, by default of the first that any of these ensembles has; position is enough for some.

    Raises RunFolderError where none has the one that is named.
    """
    has = [key for key, row in COLOURS.items() if any(row.is_in(data) for data in chosen.values())]
    if not name or name in has:
        return name or has[0]
    raise RunFolderError(
        f"colour = {name!r}: the trajectory of {', '.join(chosen)} has no {', '.join(COLOURS[name].needs)}; its rods "
        f"can have the colours {', '.join(has)}; or run the scene with it among output.variables"
    )

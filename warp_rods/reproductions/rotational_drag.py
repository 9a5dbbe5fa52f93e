"""Classes of motion of the four swimmers of Fig 4.3a–d over the rotational drag ηr, which the text does not give."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from warp_rods.analysis.motion import speed
from warp_rods.analysis.motion_class import CLASSES, shape_class
from warp_rods.draw import plots
from warp_rods.reproductions.attractors import PANELS
from warp_rods.reproductions.drawn_classes import CLASS_COLOURS, cells, draw, legend
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.reproductions.swimmers import STARTS, Case, late_times, simulate

DRAG_RANGE = (1e-4, 3e-2)
"""Range of ηr. Slender cells have (0.5…2) ln(L/a)(a/L)², which is 2e-4 … 1.5e-2."""


def class_map(quick: bool) -> Result:
    """Class of the late motion for each panel, ηr and initial shape, in one batch of swimmers."""
    drags = np.geomspace(*DRAG_RANGE, 4 if quick else 16)
    starts = list(STARTS)[:1] if quick else list(STARTS)
    grid = itertools.product(PANELS.values(), drags, starts)
    cases = [Case(panel.bend, panel.twist, panel.moment, drag, start) for panel, drag, start in grid]
    motion = simulate(cases, late_times(16.0 if quick else 30.0))
    classes = shape_class(motion, float(motion["time"][0])).to_numpy().reshape(len(PANELS), len(drags), len(starts))
    as_published = {letter: (classes[i] == panel.motion) for i, (letter, panel) in enumerate(PANELS.items())}
    rows = [_range_row(letter, PANELS[letter].motion, drags, agrees) for letter, agrees in as_published.items()]
    published = "one ηr for all of Fig 4.3"
    for which, some in (("every start", slice(None)), ("the coil alone", slice(1))):
        shared = int(np.logical_and.reduce([agrees[:, some].all(axis=1) for agrees in as_published.values()]).sum())
        name, found = f"values of ηr that give all four from {which}", f"{shared} of {len(drags)}"
        rows.append(Comparison(name, published, found, "the text gives no ηr", shared > 0))
    data = {
        "panel": np.repeat(list(PANELS), len(drags) * len(starts)),
        "rotational_drag": np.array([case.rotational_drag for case in cases]),
        "start": np.array([case.start for case in cases]),
        "class": classes.ravel(),
        "speed": speed(motion).to_numpy(),
    }
    assert set(CLASS_COLOURS) == {*CLASSES, "irregular"}
    return Result(_figure(drags, starts, classes), rows, data, ("U_swim and classes over the last 8 time units",))


def _range_row(letter: str, motion: str, drags: np.ndarray, agrees: np.ndarray) -> Comparison:
    """The values of ηr at which every initial shape [drag, start] leads to the published motion."""
    every = [f"{drag:.1e}" for drag in drags[agrees.all(axis=1)]]
    found = f"{len(every)} of {len(drags)}" + (f", {every[0]} to {every[-1]}" if every else "")
    return Comparison(f"({letter}) ηr with {motion} from every start", motion, found, "", bool(every))


def _figure(drags: np.ndarray, starts: list[str], classes: np.ndarray) -> Any:
    figure = plots.figure(plots.COLUMN, 105)
    panels = figure.subplots(len(PANELS), 1, sharex=True)
    for axes, (letter, panel), found in zip(panels, PANELS.items(), classes, strict=True):
        draw(axes, cells(drags), np.arange(len(starts) + 1), found.T)
        axes.set_yticks(np.arange(len(starts)) + 0.5, starts, fontsize=5)
        axes.tick_params(length=0, axis="y")
        axes.set_xscale("log")
        axes.invert_yaxis()
        plots.panel_title(axes, f"({letter})")
        axes.set_title(f"published: {panel.motion}", loc="right", fontsize=6)
        axes.axvline(panel.rotational_drag, color="black", linewidth=0.8, linestyle=":")
    panels[-1].set_xlabel(
        "rotational drag $\\eta_r$ ($\\zeta_r/\\zeta_\\parallel L^2$); dotted: value used for Fig 4.3"
    )
    legend(figure, classes)
    return figure

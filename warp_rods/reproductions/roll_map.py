"""What becomes of the four swimmers of Fig 4.3a–d over the rotational drag ηr, which the text never gives."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from warp_rods.analysis.motion import speed
from warp_rods.analysis.motion_class import CLASSES, shape_class
from warp_rods.draw import plots
from warp_rods.reproductions.attractors import PANELS
from warp_rods.reproductions.result import Result, Row
from warp_rods.reproductions.swimmers import STARTS, Swimmer, late_times, swim

KINDS = {name: plots.OKABE_ITO[i] for i, name in enumerate(("twisted-U", "flapping", "S", "waving"))}
KINDS |= {"U": "#56B4E9", "straight": "0.85", "irregular": "0.55"}
"""Colours of the classes of motion."""
RANGE = (1e-4, 3e-2)
"""Of ηr: that of slender cells is 2e-4 … 1.5e-2, (0.5…2) ln(L/a)(a/L)²."""


def over_rotational_drag(quick: bool) -> Result:
    """Class of the late motion for each panel, ηr and start: one batch of swimmers."""
    drags = np.geomspace(*RANGE, 4 if quick else 16)
    starts = list(STARTS)[:1] if quick else list(STARTS)
    grid = itertools.product(PANELS.values(), drags, starts)
    swimmers = [Swimmer(panel.bend, panel.twist, panel.moment, drag, start) for panel, drag, start in grid]
    motion = swim(swimmers, late_times(16.0 if quick else 30.0), 1e-3)
    kinds = shape_class(motion, float(motion["time"][0])).to_numpy().reshape(len(PANELS), len(drags), len(starts))
    named = {letter: (kinds[i] == panel.kind) for i, (letter, panel) in enumerate(PANELS.items())}
    rows = [_where(letter, PANELS[letter].kind, drags, holds) for letter, holds in named.items()]
    said = "one ηr for all of Fig 4.3"
    for which, some in (("every start", slice(None)), ("the coil alone", slice(1))):
        shared = int(np.logical_and.reduce([holds[:, some].all(axis=1) for holds in named.values()]).sum())
        found = f"{shared} of {len(drags)}"
        rows.append(Row(f"values of ηr that give all four from {which}", said, found, "not given", shared > 0))
    data = {
        "panel": np.repeat(list(PANELS), len(drags) * len(starts)),
        "rotational_drag": np.array([swimmer.rotational_drag for swimmer in swimmers]),
        "start": np.array([swimmer.start for swimmer in swimmers]),
        "class": kinds.ravel(),
        "speed": speed(motion).to_numpy(),
    }
    assert set(KINDS) == {*CLASSES, "irregular"}
    return Result(_figure(drags, starts, kinds), rows, data, ("U_swim and classes over the last 8 time units",))


def _where(letter: str, kind: str, drags: np.ndarray, holds: np.ndarray) -> Row:
    """The values of ηr at which every start gives the published motion."""
    every = [f"{drag:.1e}" for drag in drags[holds.all(axis=1)]]
    found = f"{len(every)} of {len(drags)}" + (f", {every[0]} to {every[-1]}" if every else "")
    return Row(f"({letter}) ηr with {kind} from every start", kind, found, "", bool(every))


def _figure(drags: np.ndarray, starts: list[str], kinds: np.ndarray) -> Any:
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    figure = plots.figure(plots.COLUMN, 105)
    panels = figure.subplots(len(PANELS), 1, sharex=True)
    order = list(KINDS)
    edges = np.sqrt(drags[:-1] * drags[1:])
    edges = np.concatenate([[drags[0] ** 2 / edges[0]], edges, [drags[-1] ** 2 / edges[-1]]])
    for axes, (letter, panel), found in zip(panels, PANELS.items(), kinds, strict=True):
        numbers = np.vectorize(order.index)(found).T
        colours = ListedColormap(list(KINDS.values()))
        axes.pcolormesh(
            edges, np.arange(len(starts) + 1), numbers, cmap=colours, vmin=-0.5, vmax=len(order) - 0.5,
            edgecolors="white", linewidth=0.4,
        )  # fmt: skip
        axes.set_yticks(np.arange(len(starts)) + 0.5, starts, fontsize=5)
        axes.tick_params(length=0, axis="y")
        axes.set_xscale("log")
        axes.invert_yaxis()
        plots.letter(axes, f"({letter})")
        axes.set_title(f"published: {panel.kind}", loc="right", fontsize=6)
        axes.axvline(panel.rotational_drag, color="black", linewidth=0.8, linestyle=":")
    panels[-1].set_xlabel("rotational drag $\\eta_r$ ($\\zeta_r/\\zeta_\\parallel L^2$); dotted: as in Fig 4.3 here")
    shown = [name for name in order if name in kinds]
    figure.legend(handles=[Patch(color=KINDS[name], label=name) for name in shown], loc="outside lower center", ncols=3)
    return figure

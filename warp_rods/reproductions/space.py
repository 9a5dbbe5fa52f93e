"""§4.4: classes of motion in space over bending stiffness and active moment, and the boundaries that the text gives."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from warp_rods.analysis.motion_class import shape_class
from warp_rods.draw import plots
from warp_rods.reproductions.drawn_classes import cells, draw, legend
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.reproductions.swimmers import Case, late_times, simulate

BENDS, MOMENTS = (3e-5, 2e-3), (0.0, 2.4e-2)
"""Ranges of β⊥ and M: those of the boundaries in the text, and beyond."""
SETTINGS = tuple(itertools.product((1e-4, 1e-3), (1e-3, 3e-3, 1e-2)))
"""β∥, on both sides of the 2.5e-4 of the text, and ηr, which the text does not give."""
QUICK = ((1e-4, 3e-3),)
SOFT_IN_TWIST, LARGE_MOMENT = 2.5e-4, 1.8e-2
ALONG_BEND, ALONG_MOMENT = 1.25e-4, 6e-3
"""β⊥ of Fig 4.3d and M of Fig 4.3a, at which boundaries are read off."""


U = ("U", "twisted-U")


class Phase(NamedTuple):
    """What the text says of a region: its classes, words, and where in (β⊥, M, β∥) it is."""

    classes: tuple[str, ...]
    words: str
    holds: Callable[[np.ndarray, np.ndarray, float], np.ndarray]


PHASES = {
    "straight": Phase(
        ("straight",), "β∥ < 2.5e-4, β⊥ > 7.5e-4, M > 1.4e-2",
        lambda bend, moment, twist: (bend > 7.5e-4) & (moment > 1.4e-2) & (twist < SOFT_IN_TWIST),
    ),
    "U": Phase(
        U, "the rest of β⊥ > 2e-4, M < 1.8e-2",
        lambda bend, moment, twist: (bend > 2e-4) & (moment < LARGE_MOMENT)
        & ~((bend > 7.5e-4) & (moment > 1.4e-2) & (twist < SOFT_IN_TWIST)),
    ),
    "waving": Phase(
        ("waving",), "1e-4 < β⊥ < 2e-4, M < 1.8e-2",
        lambda bend, moment, twist: (bend > 1e-4) & (bend < 2e-4) & (moment < LARGE_MOMENT),
    ),
    "S": Phase(
        ("S",), "β⊥ < 1e-4, M < 1.8e-2", lambda bend, moment, twist: (bend < 1e-4) & (moment < LARGE_MOMENT)
    ),
    "flapping": Phase(
        ("flapping",), "β⊥ < 2.5e-4, M > 1.8e-2",
        lambda bend, moment, twist: (bend < 2.5e-4) & (moment > LARGE_MOMENT),
    ),
}  # fmt: skip
"""§4.4, by name. Of M > 1.8e-2 above β⊥ = 2.5e-4 the text says nothing where β∥ > 2.5e-4."""


def phase_map(quick: bool) -> Result:
    """Class of the late motion for each β⊥, M, β∥ and ηr, in one batch of swimmers that start as the coil."""
    bends, moments = np.geomspace(*BENDS, 6 if quick else 12), np.linspace(*MOMENTS, 5 if quick else 9)
    settings = QUICK if quick else SETTINGS
    grid = itertools.product(settings, moments, bends)
    cases = [Case(bend, twist, moment, drag) for (twist, drag), moment, bend in grid]
    motion = simulate(cases, late_times(16.0 if quick else 30.0))
    found = shape_class(motion, float(motion["time"][0])).to_numpy()
    classes = found.reshape(len(settings), len(moments), len(bends))
    rows = []
    for (twist, drag), here in zip(settings, classes, strict=True):
        rows += _shares(bends, moments, twist, drag, here) + _boundaries(bends, moments, twist, drag, here)
    data = {name: np.array([getattr(case, name) for case in cases]) for name in Case._fields[:4]} | {"class": found}
    note = "N = 64; the coil (C.63)–(C.65) at the start, symmetry of C.4 imposed; classes over the last 8 of "
    return Result(
        _figure(bends, moments, settings, classes), rows, data,
        (note + f"{16 if quick else 30} time units; black: boundaries in the text",),
    )  # fmt: skip


def _shares(bends: np.ndarray, moments: np.ndarray, twist: float, drag: float, classes: np.ndarray) -> list[Comparison]:
    """In how many points of each region of the text the motion is the one that it names."""
    bend, moment = np.meshgrid(bends, moments)
    rows = []
    for name, phase in PHASES.items():
        region = phase.holds(bend, moment, twist)
        if not region.any():
            continue
        agrees = np.isin(classes[region], phase.classes)
        others = sorted(set(classes[region][~agrees].tolist()))
        text = f"{agrees.sum()} of {region.sum()} points" + (f"; else {', '.join(others)}" if others else "")
        rows.append(Comparison(f"{name}, {_at(twist, drag)}", phase.words, text, "", bool(agrees.all())))
    return rows


def _boundaries(
    bends: np.ndarray, moments: np.ndarray, twist: float, drag: float, classes: np.ndarray
) -> list[Comparison]:
    """The boundaries in the text, read off our map along lines of one M or one β⊥."""
    row, column = int(np.argmin(abs(moments - ALONG_MOMENT))), int(np.argmin(abs(np.log(bends / ALONG_BEND))))
    softer, stronger, stiff = classes[row], classes[:, column], classes[:, -1]
    by_bend, by_moment = f"at M = {moments[row]:.2g}", f"at β⊥ = {bends[column]:.2g}"
    found = [
        ("β⊥ below which it is no U", 2e-4, boundary(bends[::-1], ~np.isin(softer, U)[::-1]), by_bend),
        ("β⊥ below which it is an S", 1e-4, boundary(bends[::-1], (softer == "S")[::-1]), by_bend),
        ("M above which it flaps", LARGE_MOMENT, boundary(moments, stronger == "flapping"), by_moment),
    ]
    if twist < SOFT_IN_TWIST:
        straight = boundary(moments, stiff == "straight")
        found.append(("M above which it is straight", 1.4e-2, straight, f"at β⊥ = {bends[-1]:.2g}"))
    return [
        Comparison(f"{name}, {_at(twist, drag)}", published, ours, f"middle of two values, {reading}")
        for name, published, ours, reading in found
    ]


def boundary(values: np.ndarray, holds: np.ndarray) -> float | str:
    """The middle of the two values between which a statement begins to hold up to the last one.

    "nowhere" if it does not hold there, "everywhere" if it holds at all values.
    """
    if not holds[-1]:
        return "nowhere"
    if holds.all():
        return "everywhere"
    last = int(np.flatnonzero(~holds)[-1])
    return float((values[last] + values[last + 1]) / 2)


def _at(twist: float, drag: float) -> str:
    return f"β∥ = {twist:g}, ηr = {drag:g}"


def _figure(bends: np.ndarray, moments: np.ndarray, settings: Any, classes: np.ndarray) -> Any:
    columns = len({twist for twist, _ in settings})
    rows = len(settings) // columns
    figure = plots.figure(plots.COLUMN if columns == 1 else plots.PAGE, 30 + 35 * rows)
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    spacing = moments[1] - moments[0]
    edges = 100 * (np.append(moments, moments[-1] + spacing) - spacing / 2)
    for axes, (twist, drag), here in zip(panels.T.flat, settings, classes, strict=True):
        draw(axes, cells(bends), edges, here)
        _published(axes, twist, edges[-1])
        axes.set_xscale("log")
        axes.set_title(f"$\\beta_\\parallel$ = {twist:g}, $\\eta_r$ = {drag:g}", loc="right")
    for axes in panels[:, 0]:
        axes.set_ylabel("active moment $100\\,M$")
    for axes in panels[-1]:
        axes.set_xlabel("bending stiffness $\\beta_\\perp$")
    legend(figure, classes, 3 if columns == 1 else 7)
    return figure


def _published(axes: Any, twist: float, top: float) -> None:
    """The boundaries in the text."""
    low, high = axes.get_xlim()
    lines = [((low, high), (1.8, 1.8)), ((2.5e-4, 2.5e-4), (1.8, top))]
    lines += [((bend, bend), (0, 1.8)) for bend in (1e-4, 2e-4)]
    if twist < SOFT_IN_TWIST:
        lines += [((7.5e-4, high), (1.4, 1.4)), ((7.5e-4, 7.5e-4), (1.4, top))]
    for x, y in lines:
        axes.plot(x, y, color="black", linewidth=0.8)
    axes.set_xlim(low, high)

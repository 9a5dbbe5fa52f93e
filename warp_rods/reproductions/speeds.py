"""Fig 4.3e, f: swimming speed against active moment and against bending stiffness."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.analysis.motion import instantaneous_speed, speed
from warp_rods.analysis.motion_class import shape_class
from warp_rods.draw import plots
from warp_rods.reproductions.drawn_classes import CLASS_COLOURS
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.reproductions.swimmers import LATE, Case, late_times, simulate

TWIST = 2.5e-4
STIFF, SOFT = 5e-4, 5e-5
MOMENTS = (0.0, 0.002, 0.01)
"""β∥, β⊥ and M of the caption."""
DRAGS = (1e-3, 3e-3, 1e-2)
"""ηr, over the range of slender cells; the text gives none."""
START = "bent, φ₀"
"""Planar at M = 0, so that the soft body flaps as in Fig 4.1i, with which the text begins."""
BALLISTIC = 0.5
"""Ratio of U_swim to the mean |u| above which a trajectory counts as ballistic."""
NOTE = (
    f"β∥ = {TWIST:g}; the text gives no ηr; U_swim over the last {LATE:g} time units of 30 (16 with --quick); "
    "planar bent initial shape; symmetry of C.4 imposed"
)

Table = dict[str, np.ndarray]


def against_moment(quick: bool) -> Result:
    """Fig 4.3e: U_swim against M for a stiff and a soft body and three ηr, in one batch."""
    moments = np.linspace(0.0, 0.024, 5 if quick else 25)
    data = _speeds([(bend, moment) for bend in (STIFF, SOFT) for moment in moments], quick)
    rows = []
    for drag in np.unique(data["rotational_drag"]):
        stiff, soft = (_select(data, drag, bend=bend) for bend in (STIFF, SOFT))
        spread = float(np.ptp(stiff["speed"]) / stiff["speed"].mean())
        straightness = soft["speed"] / soft["midpoint_speed"]
        waves = "waving" in stiff["class"]
        at = f"ηr = {drag:g}"
        rows += [
            Comparison(
                f"stiff: spread of U_swim over its mean, {at}", "roughly unchanged", spread, "§4.4", spread < 0.2
            ),
            Comparison(f"stiff: motions, {at}", "M induces waving", _listed(stiff["class"]), "§4.4", waves),
            Comparison(
                f"soft at M = 0, {at}", "flapping", str(soft["class"][0]), "§4.4", soft["class"][0] == "flapping"
            ),
            _ballistic_row(soft, straightness, at),
            _flapping_row(soft, straightness, at),
        ]
    return Result(_figure_moment(data), rows, data, (NOTE,))


def _ballistic_row(soft: Table, straightness: np.ndarray, at: str) -> Comparison:
    """The fastest soft swimmer, and whether its trajectory is ballistic."""
    best = int(np.argmax(soft["speed"]))
    found = f"U = {soft['speed'][best]:.3f} at M = {soft['moment'][best]:g}, {soft['class'][best]}"
    published = "M leads to a ballistic trajectory"
    is_ballistic = bool(straightness[best] > BALLISTIC)
    return Comparison(f"soft: fastest, {at}", published, found, "U_swim > ½⟨|u|⟩", is_ballistic)


def _flapping_row(soft: Table, straightness: np.ndarray, at: str) -> Comparison:
    """The smallest M above the ballistic range at which the soft swimmer flaps again."""
    ballistic = np.flatnonzero(straightness > BALLISTIC)
    beyond = np.arange(len(straightness)) > (ballistic[-1] if len(ballistic) else len(straightness))
    again = beyond & (soft["class"] == "flapping")
    found = float(soft["moment"][again.argmax()]) if again.any() else f"none up to {soft['moment'][-1]:g}"
    reading = "§4.4: flapping for M > 1.8e-2; resolution: the spacing of M"
    return Comparison(f"soft: M from which it flaps again, {at}", 0.018, found, reading, bool(again.any()))


def against_stiffness(quick: bool) -> Result:
    """Fig 4.3f: U_swim against β⊥ for three moments and three ηr, in one batch."""
    bends = np.geomspace(2.5e-5, 1.2e-2, 12 if quick else 25)
    data = _speeds([(bend, moment) for moment in MOMENTS for bend in bends], quick)
    rows = []
    for drag in np.unique(data["rotational_drag"]):
        softest = {}
        for moment in MOMENTS:
            curve = _select(data, drag, moment=moment)
            flaps = (curve["speed"] < BALLISTIC * curve["midpoint_speed"]) & (curve["bend"] < 5e-3)
            softest[moment] = float(curve["bend"][np.flatnonzero(flaps).max() + 1]) if flaps.any() else float(bends[0])
            name = f"softest β⊥ that still swims, M = {moment:g}, ηr = {drag:g}"
            rows.append(Comparison(name, "", softest[moment], "U_swim > ½⟨|u|⟩; resolution: the spacing of β⊥"))
        delayed = softest[MOMENTS[-1]] < softest[0.0]
        published = "M = 0.01 delays flapping to softer bodies"
        rows.append(
            Comparison(f"delay, ηr = {drag:g}", published, "delayed" if delayed else "not delayed", "§4.4", delayed)
        )
    return Result(_figure_stiffness(data), rows, data, (NOTE,))


def _speeds(pairs: list[tuple[float, float]], quick: bool) -> Table:
    """Late speeds and classes of motion of swimmers with these pairs (β⊥, M), each for every ηr."""
    drags = DRAGS[:1] if quick else DRAGS
    cases = [Case(bend, TWIST, moment, drag, START) for drag in drags for bend, moment in pairs]
    motion = simulate(cases, late_times(16.0 if quick else 30.0))
    data = {name: np.array([getattr(case, name) for case in cases]) for name in ("rotational_drag", "bend", "moment")}
    return data | {
        "speed": speed(motion).to_numpy(),
        "midpoint_speed": instantaneous_speed(motion).mean("frame").to_numpy(),
        "class": shape_class(motion, float(motion["time"][0])).to_numpy(),
    }


def _select(data: Table, drag: float, **fixed: float) -> Table:
    """The rows with this ηr and these values of other columns."""
    kept = np.logical_and.reduce([data[name] == value for name, value in {"rotational_drag": drag, **fixed}.items()])
    return {name: values[kept] for name, values in data.items()}


def _listed(classes: np.ndarray) -> str:
    """The classes that occur, in order."""
    return ", ".join(dict.fromkeys(map(str, classes)))


def _figure_moment(data: Table) -> Any:
    drags = np.unique(data["rotational_drag"])
    figure = plots.figure(plots.COLUMN, 30 + 32 * len(drags))
    panels = figure.subplots(len(drags), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    for axes, drag in zip(panels, drags, strict=True):
        for bend, marker in ((STIFF, "s"), (SOFT, "o")):
            curve = _select(data, drag, bend=bend)
            _curve(axes, curve["moment"], curve, marker)
        axes.set_title(f"$\\eta_r$ = {drag:g}", loc="right")
    panels[-1].set_xlabel("active moment $M$")
    styles = [("s", f"$\\beta_\\perp$ = {STIFF:g}"), ("o", f"$\\beta_\\perp$ = {SOFT:g}")]
    _legend(figure, data, styles)
    return figure


def _figure_stiffness(data: Table) -> Any:
    drags = np.unique(data["rotational_drag"])
    figure = plots.figure(plots.COLUMN, 30 + 32 * len(drags))
    panels = figure.subplots(len(drags), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    markers = ("o", "s", "^")
    for axes, drag in zip(panels, drags, strict=True):
        for moment, marker in zip(MOMENTS, markers, strict=True):
            curve = _select(data, drag, moment=moment)
            _curve(axes, curve["bend"], curve, marker)
        axes.set_xscale("log")
        axes.set_title(f"$\\eta_r$ = {drag:g}", loc="right")
    panels[-1].set_xlabel("bending stiffness $\\beta_\\perp$")
    _legend(figure, data, [(marker, f"M = {moment:g}") for marker, moment in zip(markers, MOMENTS, strict=True)])
    return figure


def _curve(axes: Any, x: np.ndarray, curve: Table, marker: str) -> None:
    """Speeds over x. Each point has the colour of its class; markers distinguish the curves, as in the dissertation."""
    axes.plot(x, curve["speed"], color="0.75", linewidth=0.6, zorder=1)
    axes.scatter(
        x, curve["speed"], c=[CLASS_COLOURS[str(name)] for name in curve["class"]], marker=marker, s=9, linewidths=0
    )
    axes.set_ylabel("$U_{swim}$ ($f^*/\\zeta_\\parallel$)")


def _legend(figure: Any, data: Table, styles: list[tuple[str, str]]) -> None:
    from matplotlib.lines import Line2D

    shapes = [Line2D([], [], color="0.4", linestyle="", marker=marker, label=label) for marker, label in styles]
    shown = [name for name in CLASS_COLOURS if name in data["class"]]
    colours = [Line2D([], [], color=CLASS_COLOURS[name], linestyle="", marker="D", label=name) for name in shown]
    figure.legend(handles=shapes + colours, loc="outside lower center", ncols=4, columnspacing=0.8, handletextpad=0.1)

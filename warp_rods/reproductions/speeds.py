"""Fig 4.3e, f: how fast swimmers are against their active moment, and against their stiffness."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.analysis.motion import instantaneous_speed, speed
from warp_rods.analysis.motion_class import shape_class
from warp_rods.draw import plots
from warp_rods.reproductions.result import Result, Row
from warp_rods.reproductions.roll_map import KINDS
from warp_rods.reproductions.swimmers import LATE, Swimmer, late_times, swim

TWIST = 2.5e-4
STIFF, SOFT = 5e-4, 5e-5
MOMENTS = (0.0, 0.002, 0.01)
"""β∥, β⊥ and M of the caption."""
DRAGS = (1e-3, 3e-3, 1e-2)
"""ηr, over what is plausible of a slender cell: the text gives none."""
START = "bent, φ₀"
"""At M = 0 planar, so that the soft body flaps as in Fig 4.1i, from where the text's account begins."""
BALLISTIC = 0.5
"""U_swim over mean |u| from which on a trajectory leads somewhere."""
NOTE = (
    f"β∥ = {TWIST:g}; the text gives no ηr; U_swim over the last {LATE:g} time units of 30 (16 with --quick); "
    "from a planar bent start; the symmetry of C.4 is kept"
)

Table = dict[str, np.ndarray]


def against_moment(quick: bool) -> Result:
    """Fig 4.3e: U_swim against M for a stiff and a soft body, for three ηr: one batch."""
    moments = np.linspace(0.0, 0.024, 5 if quick else 25)
    data = _speeds([(bend, moment) for bend in (STIFF, SOFT) for moment in moments], quick)
    rows = []
    for drag in np.unique(data["rotational_drag"]):
        stiff, soft = (_of(data, drag, bend=bend) for bend in (STIFF, SOFT))
        drop = float(np.ptp(stiff["speed"]) / stiff["speed"].mean())
        share = soft["speed"] / soft["midpoint_speed"]
        waves = "waving" in stiff["class"]
        at = f"ηr = {drag:g}"
        rows += [
            Row(f"stiff: spread of U_swim over its mean, {at}", "roughly unchanged", drop, "§4.4", drop < 0.2),
            Row(f"stiff: motions, {at}", "M induces waving", _said(stiff["class"]), "§4.4", waves),
            Row(f"soft at M = 0, {at}", "flapping", str(soft["class"][0]), "§4.4", soft["class"][0] == "flapping"),
            _ballistic(soft, share, at),
            _flaps_again(soft, share, at),
        ]
    return Result(_figure_moment(data), rows, data, (NOTE,))


def _ballistic(soft: Table, share: np.ndarray, at: str) -> Row:
    best = int(np.argmax(soft["speed"]))
    found = f"U = {soft['speed'][best]:.3f} at M = {soft['moment'][best]:g}, {soft['class'][best]}"
    said = "M leads to a ballistic trajectory"
    return Row(f"soft: fastest, {at}", said, found, "U_swim > ½⟨|u|⟩", bool(share[best] > BALLISTIC))


def _flaps_again(soft: Table, share: np.ndarray, at: str) -> Row:
    """The least M beyond the ballistic ones from which on flapping undoes the way."""
    ballistic = np.flatnonzero(share > BALLISTIC)
    beyond = np.arange(len(share)) > (ballistic[-1] if len(ballistic) else len(share))
    again = beyond & (soft["class"] == "flapping")
    found = float(soft["moment"][again.argmax()]) if again.any() else f"none up to {soft['moment'][-1]:g}"
    reading = "§4.4: flapping for M > 1.8e-2; to the spacing of M"
    return Row(f"soft: M from which it flaps again, {at}", 0.018, found, reading, bool(again.any()))


def against_stiffness(quick: bool) -> Result:
    """Fig 4.3f: U_swim against β⊥ for three moments, for three ηr: one batch."""
    bends = np.geomspace(2.5e-5, 1.2e-2, 12 if quick else 25)
    data = _speeds([(bend, moment) for moment in MOMENTS for bend in bends], quick)
    rows = []
    for drag in np.unique(data["rotational_drag"]):
        softest = {}
        for moment in MOMENTS:
            curve = _of(data, drag, moment=moment)
            halts = (curve["speed"] < BALLISTIC * curve["midpoint_speed"]) & (curve["bend"] < 5e-3)
            softest[moment] = float(curve["bend"][np.flatnonzero(halts).max() + 1]) if halts.any() else float(bends[0])
            name = f"softest β⊥ that still swims, M = {moment:g}, ηr = {drag:g}"
            rows.append(Row(name, "", softest[moment], "U_swim > ½⟨|u|⟩; to the spacing of β⊥"))
        delayed = softest[MOMENTS[-1]] < softest[0.0]
        said = "M = 0.01 delays flapping to softer bodies"
        rows.append(Row(f"delay, ηr = {drag:g}", said, "delayed" if delayed else "not delayed", "§4.4", delayed))
    return Result(_figure_stiffness(data), rows, data, (NOTE,))


def _speeds(pairs: list[tuple[float, float]], quick: bool) -> Table:
    """Late speeds and classes of swimmers of (β⊥, M), each for every ηr."""
    drags = DRAGS[:1] if quick else DRAGS
    swimmers = [Swimmer(bend, TWIST, moment, drag, START) for drag in drags for bend, moment in pairs]
    motion = swim(swimmers, late_times(16.0 if quick else 30.0), 1e-3 if quick else 5e-4)
    data = {name: np.array([getattr(one, name) for one in swimmers]) for name in ("rotational_drag", "bend", "moment")}
    return data | {
        "speed": speed(motion).to_numpy(),
        "midpoint_speed": instantaneous_speed(motion).mean("frame").to_numpy(),
        "class": shape_class(motion, float(motion["time"][0])).to_numpy(),
    }


def _of(data: Table, drag: float, **fixed: float) -> Table:
    kept = np.logical_and.reduce([data[name] == value for name, value in {"rotational_drag": drag, **fixed}.items()])
    return {name: values[kept] for name, values in data.items()}


def _said(kinds: np.ndarray) -> str:
    return ", ".join(dict.fromkeys(map(str, kinds)))


def _figure_moment(data: Table) -> Any:
    drags = np.unique(data["rotational_drag"])
    figure = plots.figure(plots.COLUMN, 30 + 32 * len(drags))
    panels = figure.subplots(len(drags), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    for axes, drag in zip(panels, drags, strict=True):
        for bend, marker in ((STIFF, "s"), (SOFT, "o")):
            curve = _of(data, drag, bend=bend)
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
            curve = _of(data, drag, moment=moment)
            _curve(axes, curve["bend"], curve, marker)
        axes.set_xscale("log")
        axes.set_title(f"$\\eta_r$ = {drag:g}", loc="right")
    panels[-1].set_xlabel("bending stiffness $\\beta_\\perp$")
    _legend(figure, data, [(marker, f"M = {moment:g}") for marker, moment in zip(markers, MOMENTS, strict=True)])
    return figure


def _curve(axes: Any, x: np.ndarray, curve: Table, marker: str) -> None:
    """Speeds over x, each point in the colour of its class, as the thesis's markers tell the curves apart."""
    axes.plot(x, curve["speed"], color="0.75", linewidth=0.6, zorder=1)
    axes.scatter(x, curve["speed"], c=[KINDS[str(kind)] for kind in curve["class"]], marker=marker, s=9, linewidths=0)
    axes.set_ylabel("$U_{swim}$ ($f^*/\\zeta_\\parallel$)")


def _legend(figure: Any, data: Table, styles: list[tuple[str, str]]) -> None:
    from matplotlib.lines import Line2D

    shapes = [Line2D([], [], color="0.4", linestyle="", marker=marker, label=label) for marker, label in styles]
    shown = [name for name in KINDS if name in data["class"]]
    colours = [Line2D([], [], color=KINDS[name], linestyle="", marker="D", label=name) for name in shown]
    figure.legend(handles=shapes + colours, loc="outside lower center", ncols=4, columnspacing=0.8, handletextpad=0.1)

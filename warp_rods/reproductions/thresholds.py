"""§4.3: the fold and the Hopf point of the U-swimmer, and the stiffnesses at which it can both wave and flap."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw import plots
from warp_rods.reproductions.planar import (
    TWIST,
    WAVING,
    amplitudes,
    bent_strains,
    end_of_motion,
    late_motion,
    stability_segments,
    u_branch,
)
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.theory.continuation import Bifurcation, Branch, follow
from warp_rods.theory.steady import Swimmer, settled

ONSET = 6.8e-5
"""β⊥ at the onset of flapping in the text."""
TWISTED_ONSET = 2e-4
"""β⊥ at which the twisted U starts to oscillate in the text, for M < 1.8e-2."""
STARTS = ((0, 0.1), (0, 1.0), (0, 3.0), (2, 2.0))
"""Beam mode and amplitude of the initial shapes. The text gives f(s, 0) only."""
SOFT = (5e-5, 1e-4)
"""Range of β⊥ of the simulations from the initial shapes."""
UNIT = 1e-5
KINDS = ("waving", "flapping")


def bifurcations(nodes: int) -> tuple[Bifurcation, Bifurcation]:
    """The fold and the Hopf bifurcation of the U."""
    found = []
    for kind, bend, low, high in (("fold", 8e-3, 7.9e-3, 1e-2), ("Hopf", 1.7e-4, 1.4e-4, 1.8e-4)):
        u = settled(Swimmer(nodes, {"bend": bend, "twist": TWIST}, symmetric=True), WAVING, time=4.0)
        found.append(follow(u, "bend", low, high, upwards=kind == "fold").of_kind(kind)[0])
    return found[0], found[1]


def twisted_hopf(nodes: int, rotational_drag: float) -> Bifurcation:
    """The first Hopf bifurcation of the twisted U of Fig 4.3a as its stiffness falls."""
    parameters = {"bend": 3e-4, "twist": 1e-4, "moment": 6e-3, "rotational_drag": rotational_drag}
    swimmer = Swimmer(nodes, parameters, planar=False, symmetric=True)
    u = settled(swimmer, {"kind": "writhe", "amplitude": 6.0}, time=8.0)
    return follow(u, "bend", 1.35e-4, 3e-4, upwards=False).of_kind("Hopf")[0]


def limit(values: Any) -> float:
    """Second-order extrapolation in Δs of values on two grids, the second twice as fine."""
    return float((4 * values[1] - values[0]) / 3)


def bistable_range(nodes: int, quick: bool) -> tuple[float, float]:
    """Stiffnesses between which a swimmer can wave and can flap: where waving ends downwards, and flapping upwards."""
    time, within = (12.0, 2e-2) if quick else (20.0, 4e-3)
    low = end_of_motion("waving", 8.5e-5, nodes, 0.8, time=time, within=within)
    return low, end_of_motion("flapping", 6.5e-5, nodes, 1.2, time=time, within=within)


def classes_from_starts(nodes: int, quick: bool) -> tuple[np.ndarray, np.ndarray]:
    """Stiffnesses [stiffness], and classes of motion from each initial shape with f = −tanh 10s [start, stiffness]."""
    bends = np.geomspace(*SOFT, 7 if quick else 25)
    found = late_motion(
        np.tile(bends, len(STARTS)), nodes, np.repeat(bent_strains(STARTS, nodes), len(bends), axis=0),
        time=16.0 if quick else 30.0,
    )  # fmt: skip
    return bends, found.classes.reshape(len(STARTS), len(bends))


def thresholds(quick: bool) -> Result:
    """Fold, Hopf bifurcation and bistable range, extrapolated from two grids, and the onset of flapping from starts."""
    grids = (33, 65) if quick else (129, 257)
    folds, hopfs = zip(*map(bifurcations, grids), strict=True)
    fold, hopf = (limit([found.value for found in pair]) for pair in (folds, hopfs))
    ranges = {nodes: bistable_range(nodes, quick) for nodes in ((65,) if quick else (65, 129))}
    bends, classes = classes_from_starts(65, quick)
    n = f"N = {grids[0] - 1}, {grids[1] - 1}, extrapolated"
    rows = [
        Comparison("β⊥ above which there is no U", 9.1e-3, fold, f"saddle-node by continuation, {n}"),
        Comparison("β⊥ at which the U appears, approximately", 9e-3, fold, "the same fold"),
        Comparison("β⊥ at which the U starts to wave", "", hopf, f"Hopf bifurcation by continuation, {n}"),
        Comparison("angular frequency there, f*/(ζ∥L)", "", limit([h.frequency for h in hopfs]), n),
    ]  # fmt: skip
    rows += _twisted_rows((1e-2,) if quick else (1e-3, 3e-3, 1e-2), 33 if quick else 65)
    rows += _range_rows(ranges)
    for (mode, amplitude), row in zip(STARTS, classes, strict=True):
        flaps = bends[row == "flapping"]
        reading = f"N = 64, κ = {amplitude:g} φ_{mode} at the start, {len(bends)} stiffnesses from {bends[0]:g}"
        rows.append(
            Comparison(f"stiffest that flaps, start {amplitude:g} φ_{mode}", ONSET, float(flaps.max()), reading)
        )
    up, down = u_branch(65, SOFT[0])
    data = _data(up, down, bends, classes)
    notes = (f"Δt = 1e-3; bistable: the text reports flapping below about {ONSET:g}, but its Fig 4.1i flaps at 7.6e-5",)
    return Result(_figure(up, down, ranges[65], bends, classes), rows, data, notes)


def _twisted_rows(drags: tuple[float, ...], nodes: int) -> list[Comparison]:
    finer = 2 * nodes - 1
    rows = []
    for drag in drags:
        found = limit([twisted_hopf(grid, drag).value for grid in (nodes, finer)])
        reading = f"Hopf bifurcation, β∥ = 1e-4, M = 6e-3; N = {nodes - 1}, {finer - 1}, extrapolated"
        rows.append(
            Comparison(f"β⊥ at which the twisted U starts to oscillate, ηr = {drag:g}", TWISTED_ONSET, found, reading)
        )
    return rows


def _range_rows(ranges: dict[int, tuple[float, float]]) -> list[Comparison]:
    rows = []
    for nodes, (low, high) in ranges.items():
        n = f"N = {nodes - 1}"
        rows += [
            Comparison(f"β⊥ at which slow softening ends waving, {n}", "", low, "followed from 8.5e-5"),
            Comparison(f"β⊥ at which slow stiffening ends flapping, {n}", "", high, "followed from 6.5e-5"),
        ]
    ends = list(ranges.values())
    low, high = ends[0] if len(ends) == 1 else (limit(pair) for pair in zip(*ends, strict=True))
    reading = "depends on the initial shape: both motions are stable in this range"
    if len(ends) == 2:
        rows.append(Comparison("β⊥ at which slow softening ends waving, Δs → 0", "", low, "N = 64, 128, extrapolated"))
        rows.append(
            Comparison("β⊥ at which slow stiffening ends flapping, Δs → 0", "", high, "N = 64, 128, extrapolated")
        )
    published, found = f"approximately {ONSET:g}", f"between {low:.3g} and {high:.3g}"
    rows.append(Comparison("onset of flapping", published, found, reading, low < ONSET < high))
    return rows


def _data(up: Branch, down: Branch, bends: np.ndarray, classes: np.ndarray) -> dict[str, np.ndarray]:
    """One row for each point of the branch, then one for each simulation."""
    rows = []
    for branch in (up, down):
        for bend, shape, stable in zip(branch.values, branch.shapes, branch.stable, strict=True):
            rows.append(("U", bend, amplitudes(shape)[0], "stable" if stable else "unstable"))
    for (mode, amplitude), line in zip(STARTS, classes, strict=True):
        start = f"start {amplitude:g} phi_{mode}"
        rows += [(start, bend, np.nan, name) for bend, name in zip(bends, line, strict=True)]
    names = ("source", "bend", "a_0", "state")
    return {name: np.array(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)}


def _figure(up: Branch, down: Branch, ends: tuple[float, float], bends: np.ndarray, classes: np.ndarray) -> Any:
    figure = plots.figure(plots.COLUMN, 100)
    above, below = figure.subplots(2, 1, height_ratios=(3, 2))
    blue, red = plots.OKABE_ITO[:2]
    for branch in (down, up):
        for stable, values, a in stability_segments(branch):
            name = "U, stable" if stable else "U, unstable"
            above.semilogx(values, a[:, 0], "-" if stable else "--", color=blue, label=name if branch is up else None)
        for found in branch.bifurcations:
            above.plot(found.value, amplitudes(found.shape)[0], "o", color="black", mfc="white")
            at, where = (found.value, amplitudes(found.shape)[0]), (-20, -2) if found.kind == "fold" else (-4, 5)
            above.annotate(found.kind, at, where, textcoords="offset points")
    above.axvspan(*ends, color=red, alpha=0.15, linewidth=0)
    above.text(1.05 * ends[1], 2.6, "waves or flaps", color=red)
    above.axvline(ONSET, color=red, linestyle=":", label="published onset of flapping")
    above.set_xlabel("bending stiffness $\\beta_\\perp$")
    above.set_ylabel("$a_0$ ($1/L$)")
    above.set_ylim(0, 5)
    above.legend(loc="lower center")
    for name, marker, colour in zip((*KINDS, "other"), "osx", (*plots.OKABE_ITO[2:4], "0.5"), strict=True):
        named = classes == name if name in KINDS else ~np.isin(classes, KINDS)
        rows, columns = np.nonzero(named)
        below.plot(bends[columns] / UNIT, rows, marker, color=colour, label=name)
    for end in ends:
        below.axvline(end / UNIT, color=red, linewidth=0.6)
    below.axvline(ONSET / UNIT, color=red, linestyle=":")
    below.set_yticks(range(len(STARTS)), [f"${amplitude:g}\\,\\phi_{mode}$" for mode, amplitude in STARTS])
    below.set_ylim(-0.6, len(STARTS) + 0.3)
    below.set_ylabel("start")
    below.set_xlabel("bending stiffness $10^5\\beta_\\perp$")
    below.legend(loc="upper center", ncols=3)
    return figure

"""Fig 4.1g–i: what a planar swimmer comes to as it gets softer, in the plane of its first two even beam modes."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw import plots
from warp_rods.reproductions.planar import (
    FLAPPING,
    LATE,
    WAVING,
    Motion,
    amplitudes,
    arcs,
    bent,
    filmed,
    modes,
    motion,
    swimmers,
    u_branch,
)
from warp_rods.reproductions.result import Result, Row
from warp_rods.theory.continuation import Branch

Ways = list[tuple[Motion, Motion]]
"""Motions on the way down and on the way up, at each stiffness."""
NODES = 65
FRAME = 0.02
"""Between frames: smooth curves even where flapping is fast."""
STIFF, SOFT = 4e-4, 5e-5
"""Range of β⊥ that is followed down and up, in which the swimmer moves."""
STRAIGHT = 1e-2
TIME = 16.0
"""At each stiffness."""
SEQUENCE = "straight, U, waving, flapping"
COLOURS = {"straight": "0.5", "U": "black"} | dict(zip(("waving", "flapping"), plots.OKABE_ITO, strict=False))
STARTS = ((0, 0.5), (0, 6.0), (2, 2.0), (2, -4.0))
"""Beam mode and amplitude of the shapes from which the cross-sections are reached."""
ROUND = 2.7
"""Time shown of a motion that recurs: a little more than a period of flapping."""


def followed(bends: np.ndarray) -> Ways:
    """Motions at each stiffness, of descending ones: on the way down from a U, and on the way up from flapping.

    Both are steps from one stiffness to the next, each from where the last one ended.
    """
    down = [motion(bends[:1], NODES, WAVING, time=TIME, frame=FRAME)]
    up = [motion(bends[-1:], NODES, FLAPPING, time=TIME, frame=FRAME)]
    for softer, stiffer in zip(bends[1:], bends[-2::-1], strict=True):
        strain = np.concatenate([down[-1].strain, up[-1].strain])
        activity = np.concatenate([down[-1].activity, up[-1].activity])
        both = motion([softer, stiffer], NODES, strain, activity, time=TIME, frame=FRAME)
        down.append(both.rod(0))
        up.append(both.rod(1))
    return list(zip(down, up[::-1], strict=True))


def portrait(quick: bool) -> Result:
    """Fig 4.1g: fixed shapes by continuation, periodic motions by runs followed down and up."""
    bends = np.geomspace(STIFF, SOFT, 9 if quick else 25)
    both = followed(bends)
    straight = motion([STRAIGHT], NODES, WAVING, time=30.0)
    branches = u_branch(NODES, SOFT)
    down, up = ([str(ways[way].classes[0]) for ways in both] for way in (0, 1))
    seen = list(dict.fromkeys([str(straight.classes[0]), *down]))
    sequence, percent = ", ".join(seen), 100 * (bends[0] / bends[1] - 1)
    reading = f"steps of {percent:.0f} %, each a jump that may throw a motion off; Hopf point at 1.5e-4 on this grid"
    rows = [Row("as β⊥ falls", SEQUENCE, sequence, f"followed from {STIFF:g} to {SOFT:g}", sequence == SEQUENCE)]
    for name, way in (("down", down), ("up", up)):
        for kind in ("waving", "flapping"):
            found = bends[np.array(way) == kind]
            text = f"{found.min():.3g} to {found.max():.3g}" if len(found) else "nowhere"
            rows.append(Row(f"{kind} on the way {name}, β⊥", "", text, reading))
    stable = [shape for shape, good in zip(branches[0].shapes, branches[0].stable, strict=True) if good]
    share = [abs(amplitudes(shape)[0]) / np.linalg.norm(amplitudes(shape, 8)) for shape in stable]
    rows.append(Row("a₀ dominates all other modes of the U", "true", f"{min(share):.3f} of the norm or more",
                    "along the U from β⊥ = 5e-3 up", min(share) > 0.9))  # fmt: skip
    notes = (f"N = {NODES - 1}, Δt = 1e-3; f(s, 0) = −tanh 10s; two motions at one stiffness: both are stable there",)
    return Result(_portrait(branches, bends, both), rows, _table(branches, bends, both), notes)


def _table(branches: tuple[Branch, Branch], bends: np.ndarray, both: Ways) -> dict[str, np.ndarray]:
    """One row a fixed shape, and one a frame of a motion."""
    rows: list[tuple[str, float, float, float, float, str]] = []
    for branch in branches:
        for bend, shape, stable in zip(branch.values, branch.shapes, branch.stable, strict=True):
            a = amplitudes(shape)
            rows.append(("fixed", bend, np.nan, a[0], a[2], "stable" if stable else "unstable"))
    for bend, ways in zip(bends, both, strict=True):
        for name, way in zip(("down", "up"), ways, strict=True):
            for number, a in enumerate(way.coefficients[:, 0]):
                rows.append((name, bend, FRAME * number, a[0], a[2], str(way.classes[0])))
    names = ("way", "bend", "time", "a_0", "a_2", "found")
    return {name: np.array(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)}


def _portrait(branches: tuple[Branch, Branch], bends: np.ndarray, both: Ways) -> Any:
    figure = plots.figure(plots.COLUMN, 82)
    axes = figure.add_subplot(projection="3d", computed_zorder=False)
    shown = round(ROUND / FRAME)
    for bend, ways in zip(bends, both, strict=True):
        for way in ways:
            kind = str(way.classes[0])
            if kind not in ("waving", "flapping"):
                continue
            a = way.coefficients[-shown:, 0]
            axes.plot(np.full(len(a), bend ** (-1 / 3)), a[:, 0], a[:, 2], color=COLOURS[kind], linewidth=0.6)
    for branch in branches:
        for stable, values, a in arcs(branch):
            style = "-" if stable else ":"
            axes.plot(values ** (-1 / 3), a[:, 0], a[:, 2], style, color=COLOURS["U"], linewidth=1.2)
    fold = branches[0].named("fold")[0].value ** (-1 / 3)
    axes.plot([3.5, fold], [0, 0], [0, 0], color=COLOURS["straight"], linewidth=1.2)
    for kind, colour in COLOURS.items():
        axes.plot([], [], color=colour, label=kind)
    axes.set_xlabel("$\\beta_\\perp^{-1/3}$", labelpad=-6)
    axes.set_ylabel("$a_0$ ($1/L$)", labelpad=-6)
    axes.set_zlabel("$a_2$ ($1/L$)", labelpad=-6)
    axes.tick_params(pad=-3)
    axes.view_init(elev=22, azim=-62)
    axes.set_box_aspect((1.6, 1, 1), zoom=0.88)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


def waving(quick: bool) -> Result:
    """Fig 4.1h."""
    return _section(1.3e-4, "waving", quick)


def flapping(quick: bool) -> Result:
    """Fig 4.1i."""
    return _section(7.6e-5, "flapping", quick)


def _section(bend: float, published: str, quick: bool) -> Result:
    """What swimmers of one stiffness come to from several starts, and on the way there."""
    time = 12.0 if quick else 24.0
    strain = bent(STARTS, NODES)
    early = modes(filmed(swimmers([bend] * len(STARTS), NODES, strain), FRAME * np.arange(round(4.0 / FRAME))))
    late = motion([bend] * len(STARTS), NODES, strain, time=time, frame=FRAME)
    fixed = u_branch(NODES, bend)[1].shapes[-1]
    found = list(dict.fromkeys(map(str, late.classes)))
    rows = [Row(f"motion at β⊥ = {bend:g}", published, " or ".join(found), "depends on the start", published in found)]
    for name in found:
        rod = int(np.argmax(late.classes == name))
        a = late.coefficients[:, rod]
        rows += [
            Row(f"period of {name}, ζ∥L/f*", "", float(late.periods[rod]), "recurrence of the shape"),
            Row(f"a₀ in {name}, least", "", float(a[:, 0].min()), f"N = {NODES - 1}, either sign of a₀ is as good"),
            Row(f"a₀ in {name}, most", "", float(a[:, 0].max()), f"N = {NODES - 1}"),
            Row(f"range of a₂ in {name}", "", float(np.ptp(a[:, 2])), f"N = {NODES - 1}"),
        ]
    leading = fixed.eigenvalues(1)[0]
    rows.append(Row("growth rate about the U, f*/(ζ∥L)", "", float(leading.real), "by continuation"))
    rows.append(Row("period of growing oscillations about the U", "", float(2 * np.pi / abs(leading.imag)), "the same"))
    data = {"start": np.repeat([f"{a:g} phi_{m}" for m, a in STARTS], len(late.coefficients)),
            "found": np.repeat(late.classes.astype(str), len(late.coefficients)),
            "time": np.tile(time - LATE + FRAME * np.arange(len(late.coefficients)), len(STARTS)),
            "a_0": late.coefficients[..., 0].T.ravel(), "a_2": late.coefficients[..., 2].T.ravel()}  # fmt: skip
    starts = ", ".join(f"{amplitude:g} φ_{mode}" for mode, amplitude in STARTS)
    notes = (f"N = {NODES - 1}, Δt = 1e-3; f(s, 0) = −tanh 10s, κ(s, 0) = {starts}: the text does not give κ(s, 0)",)
    return Result(_section_figure(early, late, amplitudes(fixed)), rows, data, notes)


def _section_figure(early: np.ndarray, late: Motion, fixed: np.ndarray) -> Any:
    figure = plots.figure(plots.COLUMN, 70)
    axes = figure.subplots()
    for rod in range(early.shape[1]):
        axes.plot(early[:, rod, 0], early[:, rod, 2], color="0.7", linewidth=0.5, label=None if rod else "approach")
    for rod, kind in enumerate(map(str, late.classes)):
        a = late.coefficients[-round(ROUND / FRAME) :, rod]
        first = kind not in late.classes[:rod]
        axes.plot(a[:, 0], a[:, 2], color=COLOURS[kind], linewidth=1.4, label=kind if first else None)
    for sign in (1, -1):
        label = "U, unstable" if sign > 0 else None
        axes.plot(sign * fixed[0], sign * fixed[2], "o", color="black", mfc="white", label=label)
    axes.set_xlabel("$a_0$ ($1/L$)")
    axes.set_ylabel("$a_2$ ($1/L$)")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure

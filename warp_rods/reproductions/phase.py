"""Fig 4.1g–i: motions of planar swimmers over bending stiffness, in the plane of the first two even beam modes."""

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
    bent_strains,
    integrated,
    late_motion,
    modes,
    stability_segments,
    swimmers,
    u_branch,
)
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.theory.continuation import Branch

Sweeps = list[tuple[Motion, Motion]]
"""Two motions at each stiffness: reached with falling and with rising stiffness."""
DIRECTIONS = ("falling", "rising")
NODES = 65
FRAME = 0.02
"""Time between frames; gives smooth curves even for fast flapping."""
STIFF, SOFT = 4e-4, 5e-5
"""Range of β⊥ of the sweeps, in which swimmers wave or flap."""
STRAIGHT = 1e-2
TIME = 16.0
"""Duration at each stiffness."""
SEQUENCE = "straight, U, waving, flapping"
COLOURS = {"straight": "0.5", "U": "black"} | dict(zip(("waving", "flapping"), plots.OKABE_ITO, strict=False))
STARTS = ((0, 0.5), (0, 6.0), (2, 2.0), (2, -4.0))
"""Beam mode and amplitude of the initial shapes of the cross-sections."""
SHOWN_TIME = 2.7
"""Duration of the periodic motion that is drawn, a little more than one period of flapping."""


def sweeps(bends: np.ndarray) -> Sweeps:
    """Motions at each of the descending stiffnesses, in a sweep down from the U and in a sweep up from flapping.

    Each simulation of a sweep starts from the final state of the one before.
    """
    down = [late_motion(bends[:1], NODES, WAVING, time=TIME, frame=FRAME)]
    up = [late_motion(bends[-1:], NODES, FLAPPING, time=TIME, frame=FRAME)]
    for softer, stiffer in zip(bends[1:], bends[-2::-1], strict=True):
        strain = np.concatenate([down[-1].strain, up[-1].strain])
        activity = np.concatenate([down[-1].activity, up[-1].activity])
        both = late_motion([softer, stiffer], NODES, strain, activity, time=TIME, frame=FRAME)
        down.append(both.rod(0))
        up.append(both.rod(1))
    return list(zip(down, up[::-1], strict=True))


def portrait(quick: bool) -> Result:
    """Fig 4.1g: fixed shapes by continuation, periodic motions by sweeps down and up in stiffness."""
    bends = np.geomspace(STIFF, SOFT, 9 if quick else 25)
    both = sweeps(bends)
    straight = late_motion([STRAIGHT], NODES, WAVING, time=30.0)
    branches = u_branch(NODES, SOFT)
    found = [[str(pair[index].classes[0]) for pair in both] for index in (0, 1)]
    sequence = ", ".join(dict.fromkeys([str(straight.classes[0]), *found[0]]))
    percent = 100 * (bends[0] / bends[1] - 1)
    reading = f"steps of {percent:.0f} %, which may trigger a jump to another motion; Hopf point at 1.5e-4 on this grid"
    rows = [Comparison("as β⊥ falls", SEQUENCE, sequence, f"sweep from {STIFF:g} to {SOFT:g}", sequence == SEQUENCE)]
    for direction, classes in zip(DIRECTIONS, found, strict=True):
        for kind in ("waving", "flapping"):
            where = bends[np.array(classes) == kind]
            text = f"{where.min():.3g} to {where.max():.3g}" if len(where) else "nowhere"
            rows.append(Comparison(f"β⊥ of {kind}, {direction} stiffness", "", text, reading))
    stable = [shape for shape, good in zip(branches[0].shapes, branches[0].stable, strict=True) if good]
    share = [abs(amplitudes(shape)[0]) / np.linalg.norm(amplitudes(shape, 8)) for shape in stable]
    rows.append(Comparison("a₀ dominates all other modes of the U", "true", f"{min(share):.3f} of the norm or more",
                    "along the U from β⊥ = 5e-3 upwards", min(share) > 0.9))  # fmt: skip
    notes = (f"N = {NODES - 1}, Δt = 1e-3; f(s, 0) = −tanh 10s; two motions at one stiffness are both stable",)
    return Result(_portrait(branches, bends, both), rows, _table(branches, bends, both), notes)


def _table(branches: tuple[Branch, Branch], bends: np.ndarray, both: Sweeps) -> dict[str, np.ndarray]:
    """One row for each fixed shape, and one for each frame of a motion."""
    rows: list[tuple[str, float, float, float, float, str]] = []
    for branch in branches:
        for bend, shape, stable in zip(branch.values, branch.shapes, branch.stable, strict=True):
            a = amplitudes(shape)
            rows.append(("fixed", bend, np.nan, a[0], a[2], "stable" if stable else "unstable"))
    for bend, pair in zip(bends, both, strict=True):
        for direction, motion in zip(DIRECTIONS, pair, strict=True):
            for number, a in enumerate(motion.coefficients[:, 0]):
                rows.append((direction, bend, FRAME * number, a[0], a[2], str(motion.classes[0])))
    names = ("branch", "bend", "time", "a_0", "a_2", "state")
    return {name: np.array(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)}


def _portrait(branches: tuple[Branch, Branch], bends: np.ndarray, both: Sweeps) -> Any:
    figure = plots.figure(plots.COLUMN, 68)
    axes = figure.add_subplot(projection="3d", computed_zorder=False)
    shown = round(SHOWN_TIME / FRAME)
    for bend, pair in zip(bends, both, strict=True):
        for motion in pair:
            kind = str(motion.classes[0])
            if kind not in ("waving", "flapping"):
                continue
            a = motion.coefficients[-shown:, 0]
            axes.plot(np.full(len(a), bend ** (-1 / 3)), a[:, 0], a[:, 2], color=COLOURS[kind], linewidth=0.6)
    for branch in branches:
        for stable, values, a in stability_segments(branch):
            style = "-" if stable else ":"
            axes.plot(values ** (-1 / 3), a[:, 0], a[:, 2], style, color=COLOURS["U"], linewidth=1.2)
    fold = branches[0].of_kind("fold")[0].value ** (-1 / 3)
    axes.plot([3.5, fold], [0, 0], [0, 0], color=COLOURS["straight"], linewidth=1.2)
    for kind, colour in COLOURS.items():
        axes.plot([], [], color=colour, label=kind)
    axes.set_xlabel("$\\beta_\\perp^{-1/3}$", labelpad=-6)
    axes.set_ylabel("$a_0$ ($1/L$)", labelpad=-6)
    axes.set_zlabel("$a_2$ ($1/L$)", labelpad=-6)
    axes.tick_params(pad=-3)
    axes.view_init(elev=22, azim=-62)
    axes.set_box_aspect((1.6, 1, 1), zoom=1.02)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


def waving(quick: bool) -> Result:
    """Fig 4.1h."""
    return _section(1.3e-4, "waving", quick)


def flapping(quick: bool) -> Result:
    """Fig 4.1i."""
    return _section(7.6e-5, "flapping", quick)


def _section(bend: float, published: str, quick: bool) -> Result:
    """Motions of swimmers with one stiffness from several initial shapes, and the approach to them."""
    time = 12.0 if quick else 24.0
    strain = bent_strains(STARTS, NODES)
    early = modes(integrated(swimmers([bend] * len(STARTS), NODES, strain), FRAME * np.arange(round(4.0 / FRAME))))
    late = late_motion([bend] * len(STARTS), NODES, strain, time=time, frame=FRAME)
    fixed = u_branch(NODES, bend)[1].shapes[-1]
    rows = _section_rows(bend, published, late)
    leading = fixed.eigenvalues(1)[0]
    period, reading = float(2 * np.pi / abs(leading.imag)), "by continuation"
    rows.append(Comparison("growth rate about the U, f*/(ζ∥L)", "", float(leading.real), reading))
    rows.append(Comparison("period of growing oscillations about the U", "", period, reading))
    frames = len(late.coefficients)
    data = {
        "start": np.repeat([f"{amplitude:g} phi_{mode}" for mode, amplitude in STARTS], frames),
        "motion": np.repeat(late.classes.astype(str), frames),
        "time": np.tile(time - LATE + FRAME * np.arange(frames), len(STARTS)),
        "a_0": late.coefficients[..., 0].T.ravel(),
        "a_2": late.coefficients[..., 2].T.ravel(),
    }
    starts = ", ".join(f"{amplitude:g} φ_{mode}" for mode, amplitude in STARTS)
    notes = (f"N = {NODES - 1}, Δt = 1e-3; f(s, 0) = −tanh 10s, κ(s, 0) = {starts}; the text does not give κ(s, 0)",)
    return Result(_section_figure(early, late, amplitudes(fixed)), rows, data, notes)


def _section_rows(bend: float, published: str, late: Motion) -> list[Comparison]:
    """The motions found at one stiffness, with period and range of the coefficients of each."""
    found = list(dict.fromkeys(map(str, late.classes)))
    name, reading, grid = f"motion at β⊥ = {bend:g}", "depends on the initial shape", f"N = {NODES - 1}"
    rows = [Comparison(name, published, " or ".join(found), reading, published in found)]
    for kind in found:
        rod = int(np.argmax(late.classes == kind))
        a = late.coefficients[:, rod]
        low, high = float(a[:, 0].min()), float(a[:, 0].max())
        rows += [
            Comparison(f"period of {kind}, ζ∥L/f*", "", float(late.periods[rod]), "recurrence of the shape"),
            Comparison(f"a₀ in {kind}, smallest", "", low, f"{grid}, the sign of a₀ is arbitrary"),
            Comparison(f"a₀ in {kind}, largest", "", high, grid),
            Comparison(f"range of a₂ in {kind}", "", float(np.ptp(a[:, 2])), grid),
        ]
    return rows


def _section_figure(early: np.ndarray, late: Motion, fixed: np.ndarray) -> Any:
    figure = plots.figure(plots.COLUMN, 70)
    axes = figure.subplots()
    for rod in range(early.shape[1]):
        axes.plot(early[:, rod, 0], early[:, rod, 2], color="0.7", linewidth=0.5, label=None if rod else "approach")
    for rod, kind in enumerate(map(str, late.classes)):
        a = late.coefficients[-round(SHOWN_TIME / FRAME) :, rod]
        first = kind not in late.classes[:rod]
        axes.plot(a[:, 0], a[:, 2], color=COLOURS[kind], linewidth=1.4, label=kind if first else None)
    for sign in (1, -1):
        label = "U, unstable" if sign > 0 else None
        axes.plot(sign * fixed[0], sign * fixed[2], "o", color="black", mfc="white", label=label)
    axes.set_xlabel("$a_0$ ($1/L$)")
    axes.set_ylabel("$a_2$ ($1/L$)")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure

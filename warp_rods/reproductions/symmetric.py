"""Appendix C.4: the symmetry under rotation by π is conserved, and a change of gauge changes nothing, as checks."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from warp_rods.draw import plots
from warp_rods.reproductions.result import Result, Row
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import initial_strain
from warp_rods.theory.symmetry import axis_residual, gauge_frame, gauge_strain, parity_residual

BEND, TWIST, MOMENT, ROLL = 2.5e-4, 1e-4, 6e-3, 3e-3
"""Of Fig 4.3a, started from the coil of (C.63)–(C.68); C.4 gives no parameters."""
ANGLES = 2 * np.pi * np.arange(3) / 3
"""Phases of (C.72)."""
STEP = 1e-3


def check(quick: bool) -> Result:
    """Three swimmers that differ by a gauge angle (C.72), (C.73), nothing imposed: residuals of C.49–C.53, C.77."""
    times = np.linspace(0.0, 2.0 if quick else 8.0, 21 if quick else 81)
    columns = {"bend": np.array([BEND]), "twist": np.array([TWIST]), "moment": np.array([MOMENT])}
    coil = initial_strain({"kind": "writhe", "amplitude": 6.0}, 65, columns)
    frames = gauge_frame(np.tile(np.eye(3), (3, 1, 1, 1)), ANGLES)[:, 0]
    rods = FreeRods(
        3, bend=BEND, twist=TWIST, moment=MOMENT, rotational_drag=ROLL,
        shape=gauge_strain(np.tile(coil, (3, 1, 1)), ANGLES), rotation=frames, device="cpu",
    )  # fmt: skip
    seen = [_look(rods)]
    for before, time in pairwise(times):
        steps = round((time - before) / STEP)
        rods.step((time - before) / steps, steps)
        seen.append(_look(rods))
    data = {"time": times, **{name: np.array([one[name] for one in seen]) for name in seen[0]}}
    worst = {name: float(values.max()) for name, values in data.items() if name != "time"}
    reading = "largest over the run, the symmetry not imposed"
    rows = [
        Row("parities of Ω₀, Ω₁, Ω₂, f over max |Ω| (C.50)", 0.0, worst["parity"], reading),
        Row("turn of q₁ at the middle, rad (C.51)", 0.0, worst["axis_turn"], "q₁ and the axis of the start"),
        Row("distance from the line turned by π, L (C.52)", 0.0, worst["turned_by_pi"]),
        Row("velocity of the middle off the axis, f*/ζ∥ (C.53)", 0.0, worst["velocity_off_axis"]),
        Row("phases between gauges, strains over max |Ω| (C.77)", 0.0, worst["gauge"], "j = 1, 2 against j = 0"),
        Row("the same for centre lines, L (C.78)", 0.0, worst["gauge_line"]),
    ]
    notes = ("(C.72)'s second row is read as (sin, cos), without which it is no rotation; parameters of Fig 4.3a",)
    return Result(_figure(data), rows, data, notes)


def _look(rods: FreeRods) -> dict[str, float]:
    """Residuals at this moment; the gauge of rod 0 is that of (C.49), its axis e₁."""
    strain, position = rods.strain, rods.position
    size = float(np.abs(strain).max())
    axis, middle = np.eye(3)[1], rods.nodes // 2
    back = gauge_strain(strain, -ANGLES)
    q1 = _directors(rods.orientation[0, middle].astype(float))[:, 1]
    way = position[0, middle]
    return {
        "parity": float(parity_residual(strain[0], rods.activity[0]) / size),
        "axis_turn": float(np.linalg.norm(np.cross(q1, axis))),
        "turned_by_pi": float(axis_residual(position[0], axis)),
        "velocity_off_axis": float(np.linalg.norm(way - axis * (axis @ way))) / max(rods.time, STEP),
        "gauge": float(np.abs(back - back[:1]).max()) / size,
        "gauge_line": float(np.abs(position - position[:1]).max()),
    }


def _directors(quaternion: np.ndarray) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(quaternion).as_matrix()


def _figure(data: dict[str, np.ndarray]) -> Any:
    labels = {
        "parity": "parities (C.50)",
        "turned_by_pi": "turned by π (C.52)",
        "velocity_off_axis": "velocity off the axis (C.53)",
        "gauge": "gauges, strains (C.77)",
        "gauge_line": "gauges, centre lines (C.78)",
    }
    figure = plots.figure(plots.COLUMN, 58)
    axes = figure.subplots()
    for (name, label), colour in zip(labels.items(), plots.OKABE_ITO, strict=False):
        axes.semilogy(data["time"], np.maximum(data[name], 1e-17), color=colour, label=label)
    axes.set_xlabel("time ($\\zeta_\\parallel L/f^*$)")
    axes.set_ylabel("residual")
    axes.axhline(np.finfo(float).eps, color="0.6", linewidth=0.6, linestyle=":")
    figure.legend(loc="outside lower center", ncols=2)
    return figure

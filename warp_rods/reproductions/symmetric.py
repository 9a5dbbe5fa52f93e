"""Appendix C.4: conservation of the symmetry under rotation by π, and invariance under a change of gauge."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from warp_rods.draw import plots
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import initial_strain
from warp_rods.theory.symmetry import axis_residual, gauge_frame, gauge_strain, parity_residual

BEND, TWIST, MOMENT, ROTATIONAL_DRAG = 2.5e-4, 1e-4, 6e-3, 3e-3
"""Parameters of Fig 4.3a, as C.4 gives none; the initial shape is the coil (C.63)–(C.68)."""
ANGLES = 2 * np.pi * np.arange(3) / 3
"""Gauge angles of (C.72)."""
STEP = 1e-3


def check(quick: bool) -> Result:
    """Residuals of C.49–C.53 and C.77 for three swimmers that differ by a gauge angle, without imposed symmetry."""
    times = np.linspace(0.0, 2.0 if quick else 8.0, 21 if quick else 81)
    columns = {"bend": np.array([BEND]), "twist": np.array([TWIST]), "moment": np.array([MOMENT])}
    coil = initial_strain({"kind": "writhe", "amplitude": 6.0}, 65, columns)
    frames = gauge_frame(np.tile(np.eye(3), (3, 1, 1, 1)), ANGLES)[:, 0]
    rods = FreeRods(
        3, bend=BEND, twist=TWIST, moment=MOMENT, rotational_drag=ROTATIONAL_DRAG,
        shape=gauge_strain(np.tile(coil, (3, 1, 1)), ANGLES), rotation=frames, device="cpu",
    )  # fmt: skip
    residuals = [_residuals(rods)]
    for before, time in pairwise(times):
        steps = round((time - before) / STEP)
        rods.step((time - before) / steps, steps)
        residuals.append(_residuals(rods))
    data = {"time": times, **{name: np.array([now[name] for now in residuals]) for name in residuals[0]}}
    worst = {name: float(values.max()) for name, values in data.items() if name != "time"}
    reading = "maximum over the simulation, symmetry not imposed"
    rows = [
        Comparison("parities of Ω₀, Ω₁, Ω₂, f over max |Ω| (C.50)", 0.0, worst["parity"], reading),
        Comparison("rotation of q₁ at the middle, rad (C.51)", 0.0, worst["axis_rotation"], "against the initial axis"),
        Comparison("distance from the line turned by π, L (C.52)", 0.0, worst["rotated_by_pi"]),
        Comparison("velocity of the middle normal to the axis, f*/ζ∥ (C.53)", 0.0, worst["velocity_normal_to_axis"]),
        Comparison("phases between gauges, strains over max |Ω| (C.77)", 0.0, worst["gauge"], "j = 1, 2 against j = 0"),
        Comparison("the same for centre lines, L (C.78)", 0.0, worst["gauge_line"]),
    ]
    notes = ("the second row of (C.72) is read as (sin, cos), which makes it a rotation; parameters of Fig 4.3a",)
    return Result(_figure(data), rows, data, notes)


def _residuals(rods: FreeRods) -> dict[str, float]:
    """Residuals of the present state. Rod 0 has the gauge of (C.49), and its axis is e₁."""
    strain, position = rods.strain, rods.position
    size = float(np.abs(strain).max())
    axis, middle = np.eye(3)[1], rods.nodes // 2
    back = gauge_strain(strain, -ANGLES)
    q1 = _directors(rods.orientation[0, middle].astype(float))[:, 1]
    displacement = position[0, middle]
    return {
        "parity": float(parity_residual(strain[0], rods.activity[0]) / size),
        "axis_rotation": float(np.linalg.norm(np.cross(q1, axis))),
        "rotated_by_pi": float(axis_residual(position[0], axis)),
        "velocity_normal_to_axis": float(np.linalg.norm(displacement - axis * (axis @ displacement)))
        / max(rods.time, STEP),
        "gauge": float(np.abs(back - back[:1]).max()) / size,
        "gauge_line": float(np.abs(position - position[:1]).max()),
    }


def _directors(quaternion: np.ndarray) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(quaternion).as_matrix()


def _figure(data: dict[str, np.ndarray]) -> Any:
    labels = {
        "parity": "parities (C.50)",
        "rotated_by_pi": "rotated by π (C.52)",
        "velocity_normal_to_axis": "velocity normal to the axis (C.53)",
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

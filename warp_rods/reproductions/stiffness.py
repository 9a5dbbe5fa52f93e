"""Appendix C.2: the bending stiffness below which a swarmer cell buckles under its own flagella, in SI units."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import brentq

from warp_rods.draw import plots
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.theory import stability

DIAMETER, VISCOSITY, SPEED = 1e-6, 1e-3, 13e-6
"""a in m, μ in Pa s, u* in m/s, from C.2."""
MEASURED = 5.5e-22
"""Measured bending stiffness of swarmer cells in N m², as cited in C.2."""
PUBLISHED = {10e-6: 3.6e-25, 50e-6: 2.6e-23, 100e-6: 1.8e-22}
"""Length in m → critical stiffness in N m², from C.2."""
UNIT = 1e-6


def critical(length: float, bend: float) -> float:
    """Critical stiffness β⊥ f* L³ in N m² of a cell of this length in m, for a dimensionless value β⊥ = ``bend``."""
    published = stability.physical_critical_stiffness(length, DIAMETER, VISCOSITY, SPEED)
    return published * bend / stability.CRITICAL_STIFFNESS


def real_cell(quick: bool) -> Result:
    """Critical stiffness for three lengths, its ratio to the measured one, and the length at which they are equal."""
    beam, linear = stability.beam_mode_critical_stiffness("tanh"), float(stability.marginal_stiffnesses(1, "tanh")[0])
    reading = "β* where beam mode 0 neither grows nor decays, from this package; ζ∥ = 2πμ/ln(L/a)"
    rows = [Comparison("dimensionless β*", 0.0101, beam, "beam mode 0 under f = −tanh 10s (C.2: .0101)")]
    rows += [
        Comparison(f"critical B⊥, L = {length / UNIT:g} µm, N m²", published, critical(length, beam), reading)
        for length, published in PUBLISHED.items()
    ]
    ratio = MEASURED / critical(50e-6, beam)
    about = "approximately one order of magnitude"
    rows.append(
        Comparison(
            "measured B⊥ over critical, L = 50 µm", about, ratio, "chapter 6; measured 5.5e-22 N m²", 5 <= ratio <= 50
        )
    )
    equal = brentq(lambda length: critical(length, beam) - MEASURED, 10e-6, 1e-3)
    rows.append(Comparison("length at which the measured B⊥ is critical, µm", "", equal / UNIT, "not in the text"))
    lengths = np.geomspace(8e-6, 2e-4, 60)
    data = {
        "length_um": lengths / UNIT,
        "critical_stiffness_Nm2": np.array([critical(length, beam) for length in lengths]),
        "critical_stiffness_linear_Nm2": np.array([critical(length, linear) for length in lengths]),
    }
    return Result(_figure(data, equal), rows, data)


def _figure(data: dict[str, np.ndarray], equal: float) -> Any:
    figure = plots.figure(plots.COLUMN, 62)
    axes = figure.subplots()
    blue, red = plots.OKABE_ITO[:2]
    axes.loglog(data["length_um"], data["critical_stiffness_Nm2"], color=blue, label="critical, this package")
    linear = data["critical_stiffness_linear_Nm2"]
    axes.loglog(data["length_um"], linear, "--", color=blue, linewidth=0.7, label="critical, linear operator")
    lengths = np.array(list(PUBLISHED)) / UNIT
    axes.loglog(lengths, list(PUBLISHED.values()), "o", color=blue, mfc="white", label="critical, published (C.2)")
    axes.axhline(MEASURED, color=red, label="measured")
    axes.plot(equal / UNIT, MEASURED, "s", color=red)
    axes.text(0.94 * equal / UNIT, 1.3 * MEASURED, f"{equal / UNIT:.0f} µm", color=red, ha="right")
    low = data["critical_stiffness_Nm2"].min()
    axes.fill_between(data["length_um"], low, data["critical_stiffness_Nm2"], color=blue, alpha=0.08, linewidth=0)
    axes.text(60, 2e-24, "buckles", color=blue)
    axes.text(13, 1e-23, "stays straight", color="0.3")
    axes.set_xlim(data["length_um"][0], data["length_um"][-1])
    axes.set_ylim(low, 1e-19)
    axes.set_xlabel("length of the cell L (µm)")
    axes.set_ylabel("bending stiffness $B_\\perp$ (N m²)")
    axes.legend(loc="upper left")
    return figure

"""Appendix C.1: the perturbation series of the tension against the direct solution, for shapes of swimmers."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw import plots
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.rods.free.rods import FreeRods
from warp_rods.theory.tension import planar_tension, series_ratio, tension_series

DRAG_RATIO = 2.0
ORDERS = 40
BENDS = (8e-3, 5e-3, 2e-3, 1e-3)
"""β⊥ of steady U-swimmers, from weakly to strongly bent."""
WEAK = 1.0
"""Amplitude a₀ of a weakly bent shape, for the order in ε."""


def check(quick: bool) -> Result:
    """Error of (C.9) truncated at each power of ε, for steady U shapes; and the order in ε of (C.10), (C.11)."""
    nodes = 65 if quick else 129
    bent = {"kind": "mode", "amplitude": 3.0}
    rods = FreeRods(len(BENDS), nodes, bend=BENDS, twist=1e-3, shape=bent, symmetric=True, device="cpu")
    rods.advance_to(4.0 if quick else 12.0)
    curvature, activity, simulated = rods.strain[..., 2], rods.activity, rods.tension
    shapes = list(zip(BENDS, curvature, activity, strict=True))
    direct = [planar_tension(κ, f, bend, DRAG_RATIO) for bend, κ, f in shapes]
    sums = [tension_series(κ, f, bend, DRAG_RATIO, ORDERS) for bend, κ, f in shapes]
    ratios = [series_ratio(κ, DRAG_RATIO) for κ in curvature]
    scale = [np.abs(λ).max() for λ in direct]
    errors = np.array([np.abs(s - λ).max(axis=1) / m for s, λ, m in zip(sums, direct, scale, strict=True)])
    rows = [_convergence_row(*each) for each in zip(BENDS, ratios, errors, strict=True)]
    difference = max(float(np.abs(a - b).max() / m) for a, b, m in zip(simulated, direct, scale, strict=True))
    reading = "the same discrete equation, solved by NumPy and by the kernels"
    rows.append(Comparison("(4.34) against the swimmers' own tension, over max |λ|", 0.0, difference, reading))
    slope = _order(curvature[1] * WEAK / 3.0, activity[1])
    reading = "ε = 1/η; the U of β⊥ = 5e-3 scaled to a₀ ≈ 1"
    rows.append(Comparison("order in ε of λ₀ + ελ₁, (C.10), (C.11)", 2.0, slope, reading))
    data = {f"error_bend_{bend:g}": error for bend, error in zip(BENDS, errors, strict=True)}
    figure = _figure(errors, ratios, direct, sums)
    note = "the text does not state where the series converges"
    return Result(figure, rows, {"order": np.arange(ORDERS + 1), **data}, (note,))


def _convergence_row(bend: float, ratio: float, error: np.ndarray) -> Comparison:
    """The spectral radius of εK, and the ratio of the errors of (C.9) at two successive orders."""
    late = float(error[20] / error[19])
    name = f"ratio of late terms of the series, U at β⊥ = {bend:g}"
    reading = f"spectral radius of εK (C.7); error of order 20 over that of 19: {late:.3f}"
    return Comparison(name, "(C.9) is the solution", ratio, reading, bool(ratio < 1))


def _order(curvature: np.ndarray, activity: np.ndarray) -> float:
    """Fitted order in ε of the error of the first two terms."""
    drags = np.array([20.0, 40.0, 80.0])
    given = (curvature, activity, BENDS[1])
    errors = [np.abs(tension_series(*given, η, 1)[-1] - planar_tension(*given, η)).max() for η in drags]
    return float(-np.polyfit(np.log(drags), np.log(errors), 1)[0])


def _figure(errors: np.ndarray, ratios: list[float], direct: list[np.ndarray], sums: list[np.ndarray]) -> Any:
    figure = plots.figure(plots.COLUMN, 92)
    top, bottom = figure.subplots(2, 1)
    for bend, error, ratio, colour in zip(BENDS, errors, ratios, plots.OKABE_ITO, strict=False):
        top.semilogy(error, color=colour, label=f"$\\beta_\\perp$ = {bend:g}, ratio {ratio:.2f}")
        top.semilogy(error[5] * ratio ** (np.arange(ORDERS + 1) - 5.0), ":", color=colour, linewidth=0.6)
    top.set_ylim(1e-22, 1e5)
    top.set_xlabel("highest power of $\\varepsilon = 1/\\eta$ kept in (C.9)")
    top.set_ylabel("error over max $|\\lambda|$")
    top.legend(loc="lower left")
    plots.panel_title(top, "(a)")
    s = np.linspace(-0.5, 0.5, len(direct[0]))
    for index, colour in ((0, plots.OKABE_ITO[0]), (1, plots.OKABE_ITO[1])):
        bottom.plot(s, direct[index], color=colour, label=f"direct, $\\beta_\\perp$ = {BENDS[index]:g}")
        bottom.plot(s, sums[index][1], "--", color=colour, linewidth=0.7, label="$\\lambda_0 + \\varepsilon\\lambda_1$")
    bottom.set_xlabel("arc length s (L)")
    bottom.set_ylabel("tension $\\lambda$ ($f^* L$)")
    bottom.set_ylim(-0.55, 0.02)
    bottom.legend(ncols=2, loc="lower center")
    plots.panel_title(bottom, "(b)")
    return figure

"""§4.3: the first ten critical stiffnesses from Airy functions, the linear operator and the full equations."""

from __future__ import annotations

from typing import Any

import numpy as np

from warp_rods.draw import plots
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.modes import beam_mode, coefficients
from warp_rods.theory import stability

COUNT = 10
AMPLITUDE = 1e-3
"""a_n(0) of the text."""
BENDS = (1e-4, 1e-2)
"""Two stiffnesses. Growth rates are linear in β⊥ up to the square of the amplitude."""
PUBLISHED_RANGE = (0.5, 15.0)
"""Difference between the full system and the Airy conditions in the text, per cent."""


def growth_rates(bends: Any, nodes: int, modes: int = COUNT) -> np.ndarray:
    """σ_n = ∂t a_n / a_n of the full equations at a_n(0) = 1e-3, f = −tanh 10s and M = 0 [stiffness, mode]."""
    bends, s = np.asarray(bends, dtype=float), np.linspace(-0.5, 0.5, nodes)
    shapes = np.array([beam_mode(mode, s) for mode in range(modes)])
    strain = np.zeros((len(bends), modes, nodes, 3))
    strain[..., 2] = AMPLITUDE * shapes
    rods = FreeRods(
        len(bends) * modes, nodes, bend=np.repeat(bends, modes), twist=1e-3, shape=strain.reshape(-1, nodes, 3),
        device="cpu",
    )  # fmt: skip
    rate = coefficients(rods.rates()["bending_rate"].imag, s, modes).reshape(len(bends), modes, modes)
    return np.diagonal(rate, axis1=1, axis2=2) / AMPLITUDE


def neutral_stiffnesses(nodes: int) -> np.ndarray:
    """Stiffness at which each beam mode neither grows nor decays, extrapolated from two grids."""
    found = []
    for grid in (nodes, 2 * nodes - 1):
        low, high = growth_rates(BENDS, grid)
        found.append(BENDS[0] - low * (BENDS[1] - BENDS[0]) / (high - low))
    return (4 * found[1] - found[0]) / 3


def stiffnesses(quick: bool) -> Result:
    """Ten stiffnesses from each of the three theories, and their differences."""
    airy, linear = stability.airy_stiffnesses(COUNT), stability.marginal_stiffnesses(COUNT, "tanh")
    full = neutral_stiffnesses(65 if quick else 129)
    from_full, from_linear = 100 * np.abs(airy / full - 1), 100 * np.abs(airy / linear - 1)
    low, high = PUBLISHED_RANGE
    published, reading = f"{low:g} to {high:g}", "the other reading of “full system”"
    rows = [
        Comparison("first critical β⊥, full system", 1.0e-2, full[0], "σ₀ = 0 in the full equations, a₀ = 1e-3"),
        Comparison("first critical β⊥, linearised", 1.1e-2, airy[0], "(4.45), f = 1 − 2H(s)"),
        Comparison("first critical β⊥, linear operator, tanh", "", linear[0], "eigenvalue 0 of (4.37), f = −tanh 10s"),
        Comparison("Airy against full, smallest, %", published, from_full.min(), "ten modes", from_full.min() >= low),
        Comparison("Airy against full, largest, %", published, from_full.max(), "ten modes", from_full.max() <= high),
        Comparison("Airy against tanh operator, smallest, %", "", from_linear.min(), reading),
        Comparison("Airy against tanh operator, largest, %", "", from_linear.max(), reading),
    ]  # fmt: skip
    rows += [Comparison(f"critical β⊥ of mode {n}, full system", "", full[n]) for n in range(1, COUNT)]
    data = {"mode": np.arange(COUNT), "airy": airy, "linear_tanh": linear, "mode_growth": full}
    note = "the text does not list the ten; full system: σ_n = 0, the only reading that gives the published 1.0e-2"
    return Result(_figure(data), rows, data, (note,))


def _figure(data: dict[str, np.ndarray]) -> Any:
    figure = plots.figure(plots.COLUMN, 80)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    series = {"airy": "Airy (4.45), (4.47)", "linear_tanh": "operator, tanh", "mode_growth": "full equations"}
    for (name, label), marker, colour in zip(series.items(), "os^", plots.OKABE_ITO, strict=False):
        above.semilogy(data["mode"], data[name], marker, color=colour, mfc="none", label=label)
        difference = 100 * (data[name] / data["airy"] - 1)
        below.plot(data["mode"], difference, marker + "-", color=colour, mfc="none", linewidth=0.6)
    above.set_ylabel("critical stiffness $\\beta_\\perp$")
    above.legend()
    below.set_ylabel("difference from Airy (%)")
    below.set_xlabel("mode $n$")
    below.set_xticks(data["mode"])
    return figure

"""Fig 4.2: the straight swimmer's linear stability, without and with an active moment."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from warp_rods.draw import plots
from warp_rods.reproductions.critical import AMPLITUDE, growth_rates
from warp_rods.reproductions.result import Result, Row
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import from_midpoint, initial_strain
from warp_rods.rods.modes import beam_mode, coefficients
from warp_rods.theory import stability
from warp_rods.theory.twisted_stability import growth_rates as wound_rates

LENGTHS = (3.0, 14.0)
"""Range of β⊥^(−1/3), which is proportional to L."""
LENGTH = "$\\beta_\\perp^{-1/3}$, proportional to the length"
MODES = 4
MOMENT = 0.01
TWIST = 1e-3
"""β∥ of the dashed lines of Fig 4.2b: not in the text."""
THREE_UNSTABLE = 1.5e-3
"""β⊥ between the third and the fourth critical stiffness, for Fig 4.2c: not in the text."""


def _lengths(quick: bool) -> np.ndarray:
    return np.linspace(*LENGTHS, 23 if quick else 111)


def spectrum(quick: bool) -> Result:
    """Fig 4.2a: leading eigenvalues of (4.37) under f = 1 − 2H(s), and where the first vanishes."""
    lengths = _lengths(quick)
    values = np.array([stability.eigenvalues(x**-3, "piecewise", count=MODES).real for x in lengths])
    first = float(stability.critical_bends(1, "piecewise")[0])
    reading = "caption of Fig 4.2; the text after (4.47) says 1.1e-2"
    rows = [
        Row("first β⊥ at which μ vanishes", 1.0e-2, first, reading),
        Row("β⊥^(−1/3) there", 4.6, first ** (-1 / 3), reading),
        Row("first β⊥, text after (4.47)", 1.1e-2, first, "the caption's 1.0e-2 is that of the full system"),
        Row("unstable modes at β⊥^(−1/3) = 10", "", int(np.sum(stability.eigenvalues(1e-3, "piecewise").real > 0))),
    ]
    figure = plots.figure(plots.COLUMN, 60)
    axes = figure.subplots()
    for n, colour in zip(range(MODES), plots.OKABE_ITO, strict=False):
        axes.plot(lengths, values[:, n], color=colour, label=f"$n={n}$")
    for critical in stability.airy_stiffnesses(MODES):
        axes.plot(critical ** (-1 / 3), 0, "o", color="black", mfc="white", markersize=3)
    axes.axhline(0, color="0.6", linewidth=0.6, zorder=0)
    axes.set_xlim(*LENGTHS)
    axes.set_xlabel(LENGTH)
    axes.set_ylim(-12, 8)
    axes.set_ylabel("Re $\\mu_n$ ($f^*/\\zeta_\\parallel L$)")
    axes.legend(loc="lower right")
    data = {"length": lengths, "bend": lengths**-3, **{f"mu_{n}": values[:, n] for n in range(MODES)}}
    return Result(figure, rows, data, ("circles: zeros by Airy functions, (4.45) and (4.47)",))


def growth(quick: bool) -> Result:
    """Fig 4.2b: growth of beam modes in the full equations with M = 0 and M = 0.01, and the spectra of both rods."""
    lengths, nodes = _lengths(quick), 65 if quick else 129
    bends = lengths**-3
    beam = {0.0: growth_rates(bends, nodes, MODES), MOMENT: mode_growth_wound(bends, nodes)}
    own = {moment: np.array([pairs(bend, moment) for bend in bends]) for moment in (0.0, MOMENT)}
    beam_zeros = {moment: [_zero(bends, column) for column in rates.T] for moment, rates in beam.items()}
    zeros = {m: [_root(bends, rates[:, n], n, m, nodes) for n in range(MODES)] for m, rates in own.items()}
    figure = plots.figure(plots.COLUMN, 95)
    panels = figure.subplots(2, 1, sharex=True)
    for axes, rates, text in zip(panels, (beam, own), ("beam modes, full equations", "eigenmodes"), strict=True):
        for n, colour in zip(range(MODES), plots.OKABE_ITO, strict=False):
            axes.plot(lengths, rates[0.0][:, n], color=colour, label=f"$n={n}$")
            axes.plot(lengths, rates[MOMENT][:, n], "--", color=colour)
        axes.axhline(0, color="0.6", linewidth=0.6, zorder=0)
        axes.set_ylim(-12, 8)
        axes.set_ylabel("growth rate ($f^*/\\zeta_\\parallel L$)")
        plots.letter(axes, text)
    panels[0].legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.12), ncols=4, title="solid: $M=0$, dashed: $M=0.01$", title_fontsize=6
    )
    panels[1].set_xlim(*LENGTHS)
    panels[1].set_xlabel(LENGTH)
    data = {"length": lengths, "bend": bends}
    for name, rates in (("sigma", beam), ("eigenvalue", own)):
        data |= {f"{name}_{n}_M{moment:g}": rates[moment][:, n] for moment in rates for n in range(MODES)}
    return Result(figure, _growth_rows(beam_zeros, zeros), data, (
        "with M, a beam mode of the Bishop frame grows as without; dashed above is one of the material frame, wound up",
        "eigenvalues with M come in pairs and do not depend on β∥: torque balance fixes β∥τ, and only that enters",
    ))  # fmt: skip


def _growth_rows(beam: dict[float, list[float]], own: dict[float, list[float]]) -> list[Row]:
    wound = f"β∥ = {TWIST:g}, τ in torque balance with f"
    claim = "an active moment can decrease the force that excites higher modes"
    rows = [Row("β⊥ at which mode 0 grows, M = 0", 1.0e-2, beam[0.0][0], "zero of σ₀ with a₀(0) = 1e-3")]
    framed = f"mode of the material frame, {wound}"
    for zeros, what, reading in ((own, "eigenmodes", "eigenvalues of the wound rod"), (beam, "beam modes", framed)):
        easier = [n for n in range(1, MODES) if zeros[MOMENT][n] > zeros[0.0][n]]
        said = f"of {what}, {'number ' + ', '.join(map(str, easier)) if easier else 'none of 1 to 3'}"
        rows.append(Row(f"{claim} ({what})", "true", said, reading, bool(easier)))
        for n in range(MODES):
            ratio = 100 * (zeros[MOMENT][n] / zeros[0.0][n] - 1)
            rows.append(Row(f"change of critical β⊥ by M = 0.01, {what} {n}, %", "", ratio, reading))
    return rows


def pairs(bend: float, moment: float, nodes: int = 65) -> np.ndarray:
    """Leading growth rates [mode] of a straight rod in space, each of which comes twice."""
    return wound_rates(bend=bend, twist=TWIST, moment=moment, nodes=nodes, count=2 * MODES)[::2].real


def _root(bends: np.ndarray, rates: np.ndarray, n: int, moment: float, nodes: int) -> float:
    """The stiffness at which growth rate ``n`` vanishes, between those of ``bends`` where it changes sign."""
    after = int(np.argmax(rates > 0))
    return float(brentq(lambda bend: pairs(bend, moment, nodes)[n], 0.98 * bends[after], 1.02 * bends[after - 1]))


def mode_growth_wound(bends: np.ndarray, nodes: int) -> np.ndarray:
    """σ_n with M = 0.01 [stiffness, mode]: of a_n(0) φ_n in the frame of the material, wound up as M f balances."""
    s = np.linspace(-0.5, 0.5, nodes)
    shapes = np.array([beam_mode(mode, s) for mode in range(MODES)])
    one = {"bend": np.ones(1), "twist": np.array([TWIST]), "moment": np.array([MOMENT])}
    twist = initial_strain({"kind": "writhe", "amplitude": 0.0}, nodes, one)[0, :, 0]
    strain = np.zeros((len(bends), MODES, nodes, 3))
    strain[..., 0], strain[..., 2] = twist, AMPLITUDE * shapes
    rods = FreeRods(
        len(bends) * MODES, nodes, bend=np.repeat(bends, MODES), twist=TWIST, moment=MOMENT, flagella=Flagella(),
        shape=strain.reshape(-1, nodes, 3), device="cpu",
    )  # fmt: skip
    material = rods.rates()["bending_rate"] * np.exp(-1j * from_midpoint(twist[None]))
    rate = coefficients(material.imag, s, MODES).reshape(len(bends), MODES, MODES)
    return np.diagonal(rate, axis1=1, axis2=2) / AMPLITUDE


def modes(quick: bool) -> Result:
    """Fig 4.2c: the first three unstable modes as each sets in and where all three grow, and the beam modes."""
    s = np.linspace(-0.5, 0.5, 101 if quick else 401)
    values, shapes = stability.eigenmodes(THREE_UNSTABLE, s, "piecewise", count=MODES)
    onset = np.array([stability.airy_mode(n, s) for n in range(3)])
    softer = f"β⊥ = {THREE_UNSTABLE:g}, in the order of their growth"
    rows = [Row("unstable modes, softer", "", float(np.sum(values.real > 0)), f"f = 1 − 2H(s), {softer}")]
    for n in range(3):
        rows.append(Row(f"overlap of mode {n} with φ_{n}, at onset", "", overlap(onset[n], n, s), "(4.44), (4.46)"))
        rows.append(Row(f"overlap of mode {n} with φ_{n}, softer", "", overlap(shapes[n].real, n, s), softer))
    figure = plots.figure(plots.COLUMN, 85)
    stiffness = f"$\\beta_\\perp={1e3 * THREE_UNSTABLE:g}\\times10^{{-3}}$"
    for n, (axes, colour) in enumerate(zip(figure.subplots(3, 1, sharex=True), plots.OKABE_ITO, strict=False)):
        axes.plot(s, onset[n], color=colour, label="at onset")
        axes.plot(s, shapes[n].real, ":", color=colour, label=stiffness)
        axes.plot(s, beam_mode(n, s), "--", color="black", linewidth=0.8, label="beam mode")
        axes.set_ylabel(f"$\\kappa_{n}$ ($1/L$)")
        axes.axhline(0, color="0.8", linewidth=0.5, zorder=0)
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    figure.axes[-1].set_xlabel("arc length $s/L$")
    data = {"s": s}
    for name, curves in (("onset", onset), ("softer", shapes.real[:3]), ("beam", [beam_mode(n, s) for n in range(3)])):
        data |= {f"{name}_{n}": curve for n, curve in enumerate(curves)}
    return Result(figure, rows, data, ("modes of a clamped beam are no eigenmodes: softer rods mix them",))


def overlap(shape: np.ndarray, n: int, s: np.ndarray) -> float:
    """∫ κ φ_n ds."""
    return float(coefficients(shape, s, n + 1)[n])


def _zero(bends: np.ndarray, rates: np.ndarray) -> float:
    """Where rates that are straight lines in β⊥ vanish."""
    slope, constant = np.polyfit(bends, rates, 1)
    return float(-constant / slope)

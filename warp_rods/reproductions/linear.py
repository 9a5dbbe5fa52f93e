"""Fig 4.2: linear stability of a straight swimmer, without and with an active moment."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from warp_rods.draw import plots
from warp_rods.reproductions.critical import AMPLITUDE, growth_rates
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import from_midpoint, initial_strain
from warp_rods.rods.modes import beam_mode, coefficients
from warp_rods.theory import stability, twisted_stability

LENGTHS = (3.0, 14.0)
"""Range of β⊥^(−1/3), which is proportional to L."""
LENGTH = "$\\beta_\\perp^{-1/3}$, proportional to the length"
MODES = 4
MOMENT = 0.01
TWIST = 1e-3
"""β∥ of the dashed lines of Fig 4.2b; the text does not give it."""
THREE_UNSTABLE = 1.5e-3
"""β⊥ of Fig 4.2c, between the third and the fourth critical stiffness; the text does not give it."""


def _lengths(quick: bool) -> np.ndarray:
    return np.linspace(*LENGTHS, 23 if quick else 111)


def spectrum(quick: bool) -> Result:
    """Fig 4.2a: leading eigenvalues of (4.37) with f = 1 − 2H(s), and the stiffness at which the first is zero."""
    lengths = _lengths(quick)
    values = np.array([stability.eigenvalues(x**-3, "piecewise", count=MODES).real for x in lengths])
    first = float(stability.marginal_stiffnesses(1, "piecewise")[0])
    reading = "caption of Fig 4.2; the text after (4.47) says 1.1e-2"
    rows = [
        Comparison("first β⊥ at which μ vanishes", 1.0e-2, first, reading),
        Comparison("β⊥^(−1/3) there", 4.6, first ** (-1 / 3), reading),
        Comparison(
            "first β⊥, text after (4.47)", 1.1e-2, first, "the 1.0e-2 of the caption is that of the full system"
        ),
        Comparison(
            "unstable modes at β⊥^(−1/3) = 10", "", int(np.sum(stability.eigenvalues(1e-3, "piecewise").real > 0))
        ),
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
    return Result(figure, rows, data, ("circles: zeros from the Airy functions, (4.45) and (4.47)",))


def growth(quick: bool) -> Result:
    """Fig 4.2b: growth rates of beam modes in the full equations and of eigenmodes, for M = 0 and M = 0.01."""
    lengths, nodes = _lengths(quick), 65 if quick else 129
    bends = lengths**-3
    beam = {0.0: growth_rates(bends, nodes, MODES), MOMENT: twisted_beam_mode_rates(bends, nodes)}
    eigen = {moment: np.array([eigenmode_rates(bend, moment) for bend in bends]) for moment in (0.0, MOMENT)}
    beam_zeros = {moment: [_zero(bends, column) for column in rates.T] for moment, rates in beam.items()}
    zeros = {m: [_root(bends, rates[:, n], n, m, nodes) for n in range(MODES)] for m, rates in eigen.items()}
    figure = plots.figure(plots.COLUMN, 95)
    panels = figure.subplots(2, 1, sharex=True)
    for axes, rates, text in zip(panels, (beam, eigen), ("beam modes, full equations", "eigenmodes"), strict=True):
        for n, colour in zip(range(MODES), plots.OKABE_ITO, strict=False):
            axes.plot(lengths, rates[0.0][:, n], color=colour, label=f"$n={n}$")
            axes.plot(lengths, rates[MOMENT][:, n], "--", color=colour)
        axes.axhline(0, color="0.6", linewidth=0.6, zorder=0)
        axes.set_ylim(-12, 8)
        axes.set_ylabel("growth rate ($f^*/\\zeta_\\parallel L$)")
        plots.panel_title(axes, text)
    panels[0].legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.12), ncols=4, title="solid: $M=0$, dashed: $M=0.01$", title_fontsize=6
    )
    panels[1].set_xlim(*LENGTHS)
    panels[1].set_xlabel(LENGTH)
    data = {"length": lengths, "bend": bends}
    for name, rates in (("sigma", beam), ("eigenvalue", eigen)):
        data |= {f"{name}_{n}_M{moment:g}": rates[moment][:, n] for moment in rates for n in range(MODES)}
    return Result(figure, _growth_rows(beam_zeros, zeros), data, (
        "beam modes in the Bishop frame grow as for M = 0; the dashed ones above are in the twisted material frame",
        "eigenvalues with M are double and do not depend on β∥: moment balance fixes β∥τ, and only that enters",
    ))  # fmt: skip


def _growth_rows(beam: dict[float, list[float]], eigen: dict[float, list[float]]) -> list[Comparison]:
    """Critical stiffnesses {moment: [mode]} of beam modes and eigenmodes: how the moment changes them."""
    claim = "an active moment can decrease the force that excites higher modes"
    rows = [Comparison("β⊥ at which mode 0 grows, M = 0", 1.0e-2, beam[0.0][0], "σ₀ = 0 with a₀(0) = 1e-3")]
    in_material_frame = f"mode of the material frame, β∥ = {TWIST:g}, τ in moment balance with f"
    cases = ((eigen, "eigenmodes", "eigenvalues of the twisted rod"), (beam, "beam modes", in_material_frame))
    for zeros, what, reading in cases:
        easier = [n for n in range(1, MODES) if zeros[MOMENT][n] > zeros[0.0][n]]
        found = f"for {what} {', '.join(map(str, easier)) if easier else '1 to 3: none'}"
        rows.append(Comparison(f"{claim} ({what})", "true", found, reading, bool(easier)))
        for n in range(MODES):
            ratio = 100 * (zeros[MOMENT][n] / zeros[0.0][n] - 1)
            rows.append(Comparison(f"change of critical β⊥ by M = 0.01, {what} {n}, %", "", ratio, reading))
    return rows


def eigenmode_rates(bend: float, moment: float, nodes: int = 65) -> np.ndarray:
    """Leading growth rates [mode] of a straight rod in space; each is double and is given once."""
    return twisted_stability.growth_rates(bend=bend, twist=TWIST, moment=moment, nodes=nodes, count=2 * MODES)[::2].real


def _root(bends: np.ndarray, rates: np.ndarray, n: int, moment: float, nodes: int) -> float:
    """The stiffness at which growth rate ``n`` is zero, between two of ``bends`` where it changes sign."""
    after = int(np.argmax(rates > 0))
    return float(
        brentq(lambda bend: eigenmode_rates(bend, moment, nodes)[n], 0.98 * bends[after], 1.02 * bends[after - 1])
    )


def twisted_beam_mode_rates(bends: np.ndarray, nodes: int) -> np.ndarray:
    """σ_n for M = 0.01 [stiffness, mode] of a_n(0) φ_n in the material frame, whose twist balances M f."""
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
    """Fig 4.2c: the first three unstable modes at their onset and where all three grow, and the beam modes."""
    s = np.linspace(-0.5, 0.5, 101 if quick else 401)
    values, shapes = stability.eigenmodes(THREE_UNSTABLE, s, "piecewise", count=MODES)
    onset = np.array([stability.airy_mode(n, s) for n in range(3)])
    softer = f"β⊥ = {THREE_UNSTABLE:g}, in the order of growth rates"
    rows = [Comparison("unstable modes, softer", "", float(np.sum(values.real > 0)), f"f = 1 − 2H(s), {softer}")]
    for n in range(3):
        rows.append(
            Comparison(f"overlap of mode {n} with φ_{n}, at onset", "", overlap(onset[n], n, s), "(4.44), (4.46)")
        )
        rows.append(Comparison(f"overlap of mode {n} with φ_{n}, softer", "", overlap(shapes[n].real, n, s), softer))
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
    return Result(
        figure, rows, data, ("beam modes are not eigenmodes of active rods, and differ more from them in softer rods",)
    )


def overlap(shape: np.ndarray, n: int, s: np.ndarray) -> float:
    """∫ κ φ_n ds."""
    return float(coefficients(shape, s, n + 1)[n])


def _zero(bends: np.ndarray, rates: np.ndarray) -> float:
    """The stiffness at which rates that are linear in β⊥ are zero."""
    slope, constant = np.polyfit(bends, rates, 1)
    return float(-constant / slope)

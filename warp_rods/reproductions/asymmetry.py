"""§4.4: perturbations without the symmetry of C.4 grow about motions that have it: linear theory, and runs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from warp_rods.analysis.motion_class import period
from warp_rods.draw import plots
from warp_rods.reproductions.attractors import PANELS
from warp_rods.reproductions.integrate import integrate
from warp_rods.reproductions.result import Comparison, Result
from warp_rods.rods.free.rods import FreeRods
from warp_rods.theory import floquet
from warp_rods.theory.steady import Swimmer, settled, start

PLANAR_TWIST = 1e-3
"""β∥, which has no effect in a plane."""
COIL = {"kind": "writhe", "amplitude": 6.0}
PERTURBED = 1e-9
"""Size of the perturbation at the start of a run, 1/L."""
FITTED = (1e-7, 1e-3)
"""Sizes between which the growth in a run is fitted: faster modes than the leading one have died out, all are small."""
SAMPLES = 400
"""Times at which the size is measured."""
STEP, STEP_OF_GROWTH = 5e-4, 0.005
"""Longest step, and longest one times the growth rate. Steps by error would not see what is as small as this."""


class Motion(NamedTuple):
    """A motion with the symmetry: β⊥, β∥, M, ηr, the shape at the start, when it has settled, what the text says."""

    bend: float
    twist: float
    moment: float
    rotational_drag: float
    shape: Any
    settled: float
    published: str = ""

    def swimmer(self, nodes: int) -> Swimmer:
        """In space, with the symmetry imposed."""
        names = ("bend", "twist", "moment", "rotational_drag")
        return Swimmer(nodes, dict(zip(names, self[:4], strict=True)), planar=False, symmetric=True)


UNSTABLE = "generically unstable to asymmetric perturbations"
FIXED = {
    "U, planar": Motion(5e-3, PLANAR_TWIST, 0.0, 3e-3, {"kind": "mode", "amplitude": 3.0}, 4.0),
    "S, planar": Motion(2.5e-3, PLANAR_TWIST, 0.0, 3e-3, {"bend1": "15*sin(2*pi*s)"}, 4.0),
    "twisted S, Fig 4.3c": Motion(*PANELS["c"][:4], COIL, 30.0, UNSTABLE),
}
"""Fixed shapes: the U and the S of Fig 4.1f, and Fig 4.3c."""
FLAPPING = Motion(*PANELS["d"][:4], COIL, 30.0, UNSTABLE)
NAMES = (*FIXED, "flapping, Fig 4.3d")


def instability(quick: bool) -> Result:
    """Growth rates of asymmetric perturbations of the four motions, each by linear theory and in a run without it."""
    nodes = 65 if quick else 129
    rows, curves = [], {}
    for name, motion in FIXED.items():
        shape = settled(motion.swimmer(nodes), motion.shape, time=motion.settled)
        leading = shape.released().eigenvalues(1)[0]
        curves[name] = grown(shape.swimmer, shape.fields, leading.real)
        rows += _rows(name, motion, leading, slope(*curves[name]), f"N = {nodes - 1}; Re μ of the Jacobian")
    cycle, time = flapping_cycle(FLAPPING, 65, 200 if quick else 800)
    swimmer = FLAPPING.swimmer(65)
    coarse, fine = (floquet.asymmetric_exponents(swimmer, cycle[1::part], time, 1)[0] for part in (4, 2))
    leading = (4 * fine - coarse) / 3
    curves[NAMES[-1]] = grown(swimmer, cycle[0], leading.real, time)
    rows += _rows(
        NAMES[-1], FLAPPING, leading, slope(*curves[NAMES[-1]], time),
        f"N = 64; Floquet exponent, {len(cycle) // 4} and {len(cycle) // 2} parts of a period, extrapolated",
    )  # fmt: skip
    data = {
        "motion": np.repeat(NAMES, SAMPLES),
        "time": np.concatenate([curve[0] for curve in curves.values()]),
        "asymmetry": np.concatenate([curve[1] for curve in curves.values()]),
    }
    rates = {row.quantity.removeprefix(RATE): row.ours for row in rows if row.quantity.startswith(RATE)}
    note = "ηr of Figs 4.3c, d as there; a perturbation of 1e-9/L without the symmetry was added to each"
    return Result(_figure(curves, rates), rows, data, (note,))


RATE = "growth rate of asymmetry, linear theory: "


def _rows(name: str, motion: Motion, leading: complex, fitted: float, reading: str) -> list[Comparison]:
    rows = [
        Comparison(f"{RATE}{name}", "", float(leading.real), reading),
        Comparison(f"growth rate of asymmetry in a run: {name}", "", fitted, "fitted slope of log size"),
    ]
    if motion.published:
        text = f"grows at {leading.real:.3g}"
        rows.append(Comparison(f"{name}, with body symmetry assumed", motion.published, text, "§4.4", leading.real > 0))
    return rows


def grown(swimmer: Swimmer, fields: np.ndarray, rate: float, period: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Times and sizes √∫|k|² ds of what is asymmetric in k [time], in a run from symmetric fields with a perturbation.

    ``rate``: about how fast it grows; the run ends when it should be of order 0.1, or after a number of periods.
    """
    free = replace(swimmer, planar=False, symmetric=False)
    s = np.linspace(-0.5, 0.5, swimmer.nodes)
    perturbation = PERTURBED * np.cos(np.pi * s) ** 2 * np.stack([1 + 0 * s, np.sin(2 * np.pi * s), 0 * s, 0 * s])
    rods = free.rods((fields + perturbation)[None], free.parameters)
    end = np.log(0.1 / PERTURBED) / rate
    times = np.linspace(0.0, np.ceil(end / period) * period if period else end, SAMPLES + 1)[1:]
    steps = int(np.ceil(times[0] / min(STEP, STEP_OF_GROWTH / rate)))
    sizes = []
    for _ in times:
        rods.step(times[0] / steps, steps)
        k = rods.rates()["bending"][0]
        forbidden = (k + k[::-1].conj()) / 2  # (C.49): Re k is odd, Im k even
        sizes.append(np.sqrt(np.sum(abs(forbidden) ** 2) / (swimmer.nodes - 1)))
    return times, np.array(sizes)


def slope(times: np.ndarray, sizes: np.ndarray, period: float = 0.0) -> float:
    """Growth rate between the sizes of ``FITTED``; of a periodic motion over a whole number of periods."""
    within = np.flatnonzero((sizes > FITTED[0]) & (sizes < FITTED[1]))
    first, last = within[0], within[-1]
    if not period:
        return float(np.polyfit(times[first : last + 1], np.log(sizes[first : last + 1]), 1)[0])
    whole = np.floor((times[last] - times[first]) / period) * period
    later = np.interp(times[first] + whole, times, np.log(sizes))
    return float((later - np.log(sizes[first])) / whole)


def flapping_cycle(motion: Motion, nodes: int, frames: int) -> tuple[np.ndarray, float]:
    """Re k, Im k, τ, f [frame, 4, node] at equal times of one period, and the period."""
    swimmer = motion.swimmer(nodes)
    given: dict[str, Any] = {name: swimmer.parameters[name] for name in ("bend", "twist", "moment", "rotational_drag")}
    rods = FreeRods(1, nodes, **given, shape=motion.shape, symmetric=True, device="cpu")
    late = integrate(rods, motion.settled + np.arange(801) * 0.01, ("strain", "activity", "status"))
    time = float(period(late, motion.settled)[0])
    if not np.isfinite(time):
        raise ArithmeticError(f"the motion at ηr = {motion.rotational_drag:g} is not periodic: take another ηr")
    once = integrate(rods, rods.time + time * np.arange(1, frames + 1) / frames, ("strain", "activity", "status"))
    shapes = zip(once["strain"].to_numpy()[:, 0], once["activity"].to_numpy()[:, 0], strict=True)
    return np.array([start(swimmer, strain, activity).fields for strain, activity in shapes]), time


def _figure(curves: dict[str, tuple[np.ndarray, np.ndarray]], rates: dict[str, Any]) -> Any:
    figure = plots.figure(plots.PAGE, 48)
    panels = figure.subplots(1, len(curves), sharey=True)
    for axes, (name, (times, sizes)), colour in zip(panels, curves.items(), plots.OKABE_ITO, strict=False):
        axes.semilogy(times, sizes, color=colour, label="run")
        middle = int(np.argmin(abs(np.log(sizes / 1e-5))))
        line = sizes[middle] * np.exp(rates[name] * (times - times[middle]))
        shown = (line > 1e-11) & (line < 1.0)
        law = f"$e^{{{rates[name]:.3g}t}}$"
        axes.semilogy(times[shown], line[shown], "--", color="black", linewidth=0.8, label=law)
        axes.set_title(name, fontsize=7)
        axes.set_xlabel("time ($\\zeta_\\parallel L/f^*$)")
        axes.legend(loc="upper left")
    panels[0].set_ylabel("asymmetric bending ($1/L$)")
    return figure

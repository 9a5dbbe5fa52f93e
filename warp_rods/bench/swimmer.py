"""Time to solution at equal error: the planar active swimmer (docs/model.md §2), against other codes."""

from __future__ import annotations

from typing import Any

from warp_rods.bench import swimmer_elastica
from warp_rods.bench.curves import Curve, compared, draw
from warp_rods.bench.peers import pyelastica
from warp_rods.bench.peers.optional import missing
from warp_rods.bench.result import Section, Settings
from warp_rods.bench.swimmer_elastica import FINE, Elastica
from warp_rods.bench.swimmer_methods import METHODS
from warp_rods.bench.swimmer_problem import AMPLITUDE, EXACT, FULL, QUICK, SPREAD, TARGETS, Problem, Size
from warp_rods.bench.timing import Work, in_turns
from warp_rods.draw import plots


def run(settings: Settings) -> Section:
    """All stiffnesses; a table for each, and a figure of work against precision."""
    size = QUICK if settings.quick else FULL
    page = plots.figure(plots.PAGE, 70)
    panels = page.subplots(1, len(size.bends), squeeze=False, sharey=True)[0]
    tables, names = [], dict[str, Any]()
    for bend, axes in zip(size.bends, panels, strict=True):
        curves, others = measured(Problem(bend, size), settings)
        over = (curves[0].name, f"ours, B = {size.counts[-2]}")
        extra = [row for e in others for row in rows_of(e, size)]
        tables.append(compared(f"β⊥ = {bend:g}", curves, TARGETS, over, extra))
        draw(axes, curves, f"β⊥ = {bend:g}", "error of the curvature")
        for e in others:
            marker = "P" if e.mass == size.masses[0] else "X"
            axes.loglog(e.error, 1e3 * e.alone, marker, color="k", ms=3, label=f"PyElastica, mass {e.mass:g}")
        names |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    panels[0].set_ylabel("CPU time of a rod (ms)")
    page.legend(names.values(), names.keys(), loc="outside lower center", ncols=5, fontsize=5)
    return Section(tables, {"swimmer": page}, notes(size))


def measured(problem: Problem, settings: Settings) -> tuple[list[Curve], list[Elastica]]:
    """Curves of all methods, and PyElastica's runs."""

    def tell(what: str) -> None:
        settings.tell(f"β⊥ = {problem.bend:g}: {what}")

    works = dict[str, Work]()
    curves = [curve for make in METHODS for curve in make(problem, works)]
    times = in_turns(works, problem.size.repeats, tell=tell)
    for curve in curves:
        curve.take(times)
    tell("PyElastica")
    return curves, [] if missing("elastica") else swimmer_elastica.runs(problem)


def rows_of(e: Elastica, size: Size) -> list[list[Any]]:
    """Rows of the table: a name, the error, and milliseconds a rod, alone and in a batch."""
    what = f"mass {e.mass:g}, Δt = {e.step:.2g}, stretched {100 * e.strain:.1f} %"
    rows = (("", e.alone), (f" in a batch of {size.batch}", e.batched))
    return [[f"PyElastica{how}, {what}", e.error, 1e3 * seconds] for how, seconds in rows]


def notes(size: Size) -> list[str]:
    return [
        f"N = {size.nodes}, beam mode 0 of amplitude {AMPLITUDE:g} at the start, until t = {size.times[-1]:g}; η = 2, "
        f"τf = 1e-2, D = 1e-3. Error: the largest difference of the curvature at any node and any of "
        f"{len(size.times)} times, over the largest curvature, from Radau at {EXACT:g} on the same equations in space. "
        f"In a batch β⊥ varies by ±{100 * SPREAD:g} %, and the error is the root mean square over some rods. Times "
        "between two runs by powers; – where no run is so precise. Where the quickest run is more precise, its time.",
        "Ours: steps chosen by error, at tolerances "
        f"{size.ours[0]:g} to {size.ours[-1]:g}; making the ensemble and reading frames are not counted.",
        "SciPy's expert: planar, halved by symmetry, right side and Jacobian compiled by Numba; banded: the part of "
        "the Jacobian at given tension. User: NumPy, in space, dense Jacobian by differences. Both solve one rod after "
        "another, so that their time a rod holds for any number of rods.",
        "Dissertation: implicit BDF2 at equal steps, each solved by scipy.optimize.root(method='hybr'); with the "
        "expert's right side, on half the rod, which is quicker than the text's.",
        "PyElastica: its largest stable step; mass: that of a length over its drag, in units of time, where τf = 1e-2; "
        f"EA = {pyelastica.STRETCH:g} f*L. It solves other equations in space; its error is that against a rod of "
        f"{FINE} times the cells, and its time stands at the larger error without having reached it (never). Its time "
        "in a batch is that of a step in the batch times the number of steps.",
        *filter(None, [missing("numba"), missing("elastica")]),
        published(),
    ]


def published() -> str:
    return (
        "Published, not measured here: PyElastica-JAX 7e5 rod-steps/s (GH200, 4096 rods, 20–50 elements); "
        "dismech-newton 1.37e5 rod-steps/s (RTX 2070 Super, 2560 rods). Neither is on PyPI."
    )

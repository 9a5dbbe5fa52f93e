"""The main job, a filament on a membrane, as users of other methods would do it: a penalty chain, projected beads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np

from warp_rods.bench.curves import Curve, compared, draw
from warp_rods.bench.peers import chain
from warp_rods.bench.peers.chain import Chain
from warp_rods.bench.peers.optional import missing
from warp_rods.bench.result import Section, Settings
from warp_rods.bench.timing import Work, cpu_seconds, in_turns
from warp_rods.draw import plots
from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods

STIFFNESS, DRAG = (1.0, 1.0, 1.0), (1.0, 2.0)
ROLLING = 1e-5
"""Drag of rotation ζr, which chains of nodes do not have: it changes velocities by less than this share."""
HOLD = 100.0
"""The penalty of the distance to the membrane over that of stretching."""
STABLE = 0.5
"""Explicit steps over the stability bounds of bending, Δs⁴ζ⊥/8B, and of stretching, Δs²ζ∥/2k."""
TARGETS = (1e-2, 1e-3)


@dataclass(frozen=True)
class Case:
    """A filament: membrane (``chain.Chain``), length, σ, where its middle is and points, until when."""

    name: str
    membrane: tuple[float, float]
    length: float
    intrinsic: tuple[float, float, float]
    position: tuple[float, float, float]
    direction: tuple[float, float, float]
    end: float

    def rods(self, nodes: int, count: int = 1) -> BoundRods:
        """Ours: ``count`` filaments whose intrinsic strains vary by a tenth; the middle one is the case."""
        a, b = self.membrane
        surface = surfaces.make("cassini", {"a": a, "b": b}) if b else surfaces.make("sphere", {"radius": a})
        share = np.linspace(0.9, 1.1, count)[:, None] if count > 1 else np.ones((1, 1))
        given: dict[str, Any] = {"length": self.length, "intrinsic": share * self.intrinsic, "stiffness": STIFFNESS}
        start = np.tile(self.position, (count, 1)), np.tile(self.direction, (count, 1))
        return BoundRods(surface, *start, nodes=nodes, drag=(*DRAG, ROLLING), **given)

    def chain(self, nodes: int, stretch: float, hold: float) -> Chain:
        """The same for nodes that springs hold together."""
        spacing = self.length / (nodes - 1)
        return Chain(*self.membrane, STIFFNESS, self.intrinsic, DRAG, spacing, stretch, hold)


CASES = (
    Case("sphere", (1.0, 0.0), 1.0, (0.0, 0.0, 2.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.3), 0.05),
    Case("dumbbell", (1.0, 1.1), 0.5, (0.0, 1.5, 0.0), (0.458, 0.0, 0.1), (0.0, 1.0, 0.6), 0.1),
)


@dataclass(frozen=True)
class Size:
    """How much is measured; ``limit``: seconds that a run of beads may take."""

    nodes: Sequence[int] = (17, 33, 65)
    tolerances: Sequence[float] = (1.0, 0.1, 0.01)
    batch: int = 100
    finest: int = 257
    chain_nodes: Sequence[int] = (9, 17, 33)
    stretch: Sequence[float] = (1e3, 1e4, 1e5, 1e6)
    chain_tolerances: Sequence[float] = (1e-3, 1e-5)
    bead_nodes: Sequence[int] = (9, 17, 33)
    bead_stretch: float = 1e3
    limit: float = 10.0
    repeats: int = 3


FULL = Size()
QUICK = Size((17,), (0.1,), 2, 33, (9,), (1e3,), (1e-3,), (9,), limit=0.01, repeats=1)


def run(settings: Settings) -> Section:
    """A table for each membrane, and a figure."""
    size = QUICK if settings.quick else FULL
    page = plots.figure(plots.COLUMN, 60)
    tables = []
    panels = page.subplots(1, len(CASES), squeeze=False, sharey=True)[0]
    for case, axes in zip(CASES, panels, strict=True):
        curves, extra = measured(case, size, settings)
        tables.append(compared(f"{case.name}, until t = {case.end:g}", curves, TARGETS, ("ours, B = 1",), extra))
        draw(axes, curves, case.name, "error of places (L)")
    panels[0].set_ylabel("CPU time of a filament (ms)")
    page.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=5)
    return Section(tables, {"filament": page}, [*NOTES, *filter(None, [missing("numba")])])


NOTES = (
    "Error: the largest distance of a node at the end, in lengths, from ours with 257 nodes at tolerance 1e-3. Each "
    "method with several numbers of nodes, tolerances and penalties; times between its best runs by powers.",
    "Ours: 17 to 65 nodes; in a batch intrinsic strains vary by a tenth, and the error is that of the filament alone.",
    "Penalty chain: positions, springs k, a penalty of 100 k/L² on the distance to the membrane; SciPy's BDF, banded "
    "Jacobian by differences. Its ends leave the membrane over a length (B/penalty)^(1/4), so that its error falls "
    "slowly with k. Beads: explicit steps at half the stability bound, each projected onto the membrane; "
    "springs k = 1e3. Both compiled by Numba; their forces are exact derivatives by complex steps; written out "
    "by hand they would be a few times quicker.",
)


def measured(case: Case, size: Size, settings: Settings) -> tuple[list[Curve], list[list[Any]]]:
    """All methods on one membrane; rows for runs that were too long."""
    settings.tell(f"{case.name}: exact")
    fine = case.rods(size.finest)
    fine.advance_to(case.end, 1e-3)
    works, curves = dict[str, Work](), list[Curve]()

    def error(found: np.ndarray) -> float:
        stride = (size.finest - 1) // (len(found) - 1)
        return float(np.linalg.norm(found - fine.position[0, ::stride], axis=1).max() / case.length)

    curves += ours(case, size, works, error)
    extra = list[list[Any]]()
    if not missing("numba"):
        curves.append(chains(case, size, works, error))
        curves.append(beads(case, size, works, error, extra))
    times = in_turns(works, size.repeats, tell=lambda name: settings.tell(f"{case.name}: {name}"))
    for curve in curves:
        curve.take(times)
    return curves, extra


Error = Callable[[np.ndarray], float]


def ours(case: Case, size: Size, works: dict[str, Work], error: Error) -> list[Curve]:
    """This package, one filament and a batch."""
    curves = [Curve("ours, B = 1"), Curve(f"ours, B = {size.batch}", share=size.batch)]
    for nodes in size.nodes:
        alone = case.rods(nodes)
        for curve, rods in zip(curves, (alone, case.rods(nodes, size.batch)), strict=True):
            start = rods.state()
            for tolerance in size.tolerances:
                key = f"{curve.name}, N = {nodes}, {tolerance:g}"
                works[key] = Work(partial(rods.advance_to, case.end, tolerance), partial(rods.restore, start))
                curve.errors[key] = cache(partial(our_error, case, nodes, tolerance, error))
    return curves


def our_error(case: Case, nodes: int, tolerance: float, error: Error) -> float:
    rods = case.rods(nodes)
    rods.advance_to(case.end, tolerance)
    return error(rods.position[0])


def error_of(found: dict[str, np.ndarray], key: str, error: Error) -> float:
    """The error of a run that was made."""
    return error(found[key])


def chains(case: Case, size: Size, works: dict[str, Work], error: Error) -> Curve:
    """Chains with penalties of several stiffnesses."""
    curve, found = Curve("penalty chain, SciPy BDF"), dict[str, np.ndarray]()

    def work(key: str, start: np.ndarray, made: Chain, tolerance: float) -> None:
        try:
            found[key] = chain.solve(start, made, case.end, tolerance)
        except ArithmeticError:
            found[key] = np.full_like(start, np.inf)

    for nodes in size.chain_nodes:
        start = case.rods(nodes).position[0]
        for stretch in size.stretch:
            for tolerance in size.chain_tolerances:
                key = f"chain, N = {nodes}, k = {stretch:g}, {tolerance:g}"
                made = case.chain(nodes, stretch, HOLD * stretch)
                works[key] = Work(partial(work, key, start, made, tolerance), slow=True)
                curve.errors[key] = partial(error_of, found, key, error)
    chain.solve(start, case.chain(nodes, 1e3, 1e5), 1e-9, 1e-3)  # compiles
    return curve


def beads(case: Case, size: Size, works: dict[str, Work], error: Error, extra: list[list[Any]]) -> Curve:
    """Projected beads; those that would take too long are only told."""
    curve = Curve("projected beads, explicit")
    for nodes in size.bead_nodes:
        start, made = case.rods(nodes).position[0], case.chain(nodes, size.bead_stretch, 0.0)
        h = made.spacing
        bound = min(h**4 * DRAG[1] / 8 / max(STIFFNESS), h**2 * DRAG[0] / 2 / size.bead_stretch)
        steps = int(np.ceil(case.end / bound / STABLE))
        few = Work(partial(chain.projected_steps, start.copy(), made, 1e-12, 100))
        cpu_seconds(few)
        if (seconds := cpu_seconds(few) * steps / 100) > size.limit:
            extra.append([f"beads, N = {nodes}: {steps:,} steps, about {seconds:,.0f} s, not run"])
            continue
        key, x = f"beads, N = {nodes}", np.empty_like(start)
        before = partial(np.copyto, x, start)
        works[key] = Work(partial(chain.projected_steps, x, made, case.end / steps, steps), before, slow=True)
        curve.errors[key] = partial(error, x)
    return curve

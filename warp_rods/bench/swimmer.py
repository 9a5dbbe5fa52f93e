"""Time to solution at equal error: the planar active swimmer (docs/model.md §2), against other codes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from warp_rods.bench.peers import dissertation, in_space, planar, pyelastica
from warp_rods.bench.peers.optional import missing
from warp_rods.bench.precision import time_at
from warp_rods.bench.result import Section, Settings, Table
from warp_rods.bench.timing import Times, Work, in_turns
from warp_rods.draw import plots
from warp_rods.rods.free.rods import FreeRods

AMPLITUDE, TWIST = 3.0, 1e-3
"""Amplitude of beam mode 0 at the start; twist stiffness, which a planar rod does not feel."""
SPREAD = 0.1
"""Stiffnesses of the rods of a batch lie this far on each side of β⊥, so that no two do the same."""
EXACT = 1e-10
TARGETS = (1e-3, 1e-5)
FINE = 4
"""The rod that PyElastica is compared with has this many times its cells."""
BATCHED_STEPS, BATCHED_TIME = 40, 1e-6
"""Steps of PyElastica that are timed in a batch, and their length: they cost the same at any length."""


@dataclass(frozen=True)
class Size:
    """How much is measured."""

    bends: Sequence[float] = (1e-2, 5e-3, 1e-3, 1e-4)
    nodes: int = 65
    times: Sequence[float] = tuple(np.linspace(0.1, 1.0, 10).tolist())
    ours: Sequence[float] = (10.0, 1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
    counts: Sequence[int] = (1, 100, 1000, 10_000)
    whole: int = 100
    """Batches up to this size are measured at every tolerance, larger ones around the errors asked for, and once."""
    largest_at: float = 1e-3
    """The largest batch is measured at this stiffness only."""
    expert: Sequence[float] = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
    user: Sequence[float] = (1e-3, 1e-5, 1e-7)
    user_methods: Sequence[str] = ("BDF", "Radau")
    steps: Sequence[float] = (1e-2, 5e-3, 2e-3, 1e-3)
    masses: Sequence[float] = (1e-2, 1e-3)
    longest: float = 4e-4
    batch: int = 100
    sampled: int = 5
    repeats: int = 3


FULL = Size()
QUICK = Size(
    bends=(1e-3,), nodes=17, times=(0.05, 0.1), ours=(1.0, 1e-2), counts=(1, 2, 3), expert=(1e-3, 1e-5), user=(1e-3,),
    user_methods=("BDF",), steps=(1e-2,), masses=(1e-2,), longest=2e-4, batch=2, sampled=1, repeats=1,
)  # fmt: skip


@dataclass
class Problem:
    """One stiffness: the start and exact curvatures [time, node], of the half rod and of a fine one."""

    bend: float
    size: Size
    nodes: int = 0

    def __post_init__(self) -> None:
        self.nodes = self.nodes or self.size.nodes
        self.times = np.array(self.size.times)
        self.swimmer = planar.Swimmer(self.bend)
        rod = self.rods(1)
        self.curvature, self.activity = rod.strain[0, :, 2], rod.activity[0]
        middle = self.nodes // 2
        self.half = planar.packed(self.curvature[middle:], self.activity[middle:])

    def rods(self, count: int) -> FreeRods:
        """Ours, on this problem or on as many nearby ones."""
        share = np.linspace(1 - SPREAD, 1 + SPREAD, count) if count > 1 else np.ones(1)
        shape = {"kind": "mode", "amplitude": AMPLITUDE}
        return FreeRods(count, self.nodes, bend=self.bend * share, twist=TWIST, shape=shape, symmetric=True)

    def exact(self, bend: float | None = None) -> np.ndarray:
        """κ [time, node] of the half rod, of the same equations in space."""
        swimmer = self.swimmer._replace(bend=bend or self.bend)
        return planar.solve(swimmer, self.half, self.times, "Radau, dense", EXACT)


def error(found: np.ndarray, exact: np.ndarray) -> float:
    """The largest difference at any node and time, over the largest curvature."""
    return float(abs(found - exact).max() / abs(exact).max())


@dataclass
class Method:
    """Errors, and seconds a rod, of the runs of one method at different tolerances."""

    name: str
    runs: dict[str, Callable[[], float]] = field(default_factory=dict)
    """Key of a work → its error."""
    share: float = 1.0
    """Rods that one work is for."""
    note: str = ""

    def curve(self, times: dict[str, Times]) -> tuple[list[float], list[float]]:
        return [error() for error in self.runs.values()], [times[key].median / self.share for key in self.runs]


def run(settings: Settings) -> Section:
    """All stiffnesses; a table for each, and a figure of work against precision."""
    size = QUICK if settings.quick else FULL
    page = plots.figure(plots.PAGE, 60)
    panels = page.subplots(1, len(size.bends), squeeze=False, sharey=True)[0]
    tables = []
    for bend, axes in zip(size.bends, panels, strict=True):
        problem, works, methods = Problem(bend, size), dict[str, Work](), list[Method]()
        for make in (ours, experts, users, dissertations):
            methods += make(problem, works)
        tell = partial(_tell, settings, bend)
        times = in_turns(works, size.repeats, tell=tell)
        tell("PyElastica")
        rows = [] if missing("elastica") else elasticas(problem, times)
        tables.append(table(problem, methods, times, rows))
        draw(axes, problem, methods, times, rows)
    panels[0].set_ylabel("CPU time of a rod (ms)")
    page.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=6, fontsize=5)
    return Section(tables, {"swimmer": page}, notes(size))


def _tell(settings: Settings, bend: float, what: str) -> None:
    settings.tell(f"β⊥ = {bend:g}: {what}")


# --- methods ----------------------------------------------------------------------------------------------------------


def ours(problem: Problem, works: dict[str, Work]) -> list[Method]:
    """This package, in batches, at several tolerances."""
    size, methods = problem.size, list[Method]()
    counts = size.counts if problem.bend == size.largest_at else size.counts[:-1]
    for count in counts:
        rods = problem.rods(count)
        method = Method(f"ours, B = {count}", share=count)
        start, sample = rods.state(), np.linspace(0, count - 1, min(size.sampled, count)).astype(int)
        exact = [problem.exact(bend) for bend in rods.bend[sample]]
        alone = [error() for error in methods[0].runs.values()] if methods else []
        for tolerance in size.ours if count <= size.whole else around(size.ours, alone):
            key = f"{method.name}, {tolerance:g}"
            before = partial(rods.restore, start)
            works[key] = Work(partial(rods.advance_to, problem.times[-1], tolerance), before, slow=count > size.whole)
            value = our_error(problem, rods, start, tolerance, sample, exact)
            method.runs[key] = lambda value=value: value
        methods.append(method)
    return methods


def around(tolerances: Sequence[float], errors: Sequence[float]) -> list[float]:
    """The tolerances, falling, on both sides of each error asked for, by the errors at them."""
    kept = set[int]()
    for target in TARGETS:
        above = [i for i, error in enumerate(errors) if error > target]
        kept |= {max(above, default=0), min(max(above, default=-1) + 1, len(errors) - 1)}
    return [tolerances[i] for i in sorted(kept)]


def our_error(
    problem: Problem, rods: FreeRods, start: Any, tolerance: float, sample: np.ndarray, exact: list[np.ndarray]
) -> float:
    """The root mean square of the errors of some rods."""
    middle, few = problem.nodes // 2, rods
    if rods.count > len(sample):  # the bits of a rod do not depend on its batch
        shape = {"kind": "mode", "amplitude": AMPLITUDE}
        few = FreeRods(len(sample), problem.nodes, bend=rods.bend[sample], twist=TWIST, shape=shape, symmetric=True)
    else:
        rods.restore(start)
    found = []
    for time in problem.times:
        few.advance_to(time, tolerance)
        found.append(few.strain[:, middle:, 2])
    each = [error(curvature, wanted) for curvature, wanted in zip(np.swapaxes(found, 0, 1), exact, strict=True)]
    return float(np.sqrt(np.mean(np.square(each))))


def experts(problem: Problem, works: dict[str, Work]) -> list[Method]:
    """SciPy as an expert would use it; without Numba the right side would be Python."""
    if missing("numba"):
        return []
    exact = problem.exact()
    return [
        _method(
            f"SciPy, expert, {name}", works, problem.size.expert, exact,
            lambda tolerance, name=name: planar.solve(problem.swimmer, problem.half, problem.times, name, tolerance),
        )
        for name in planar.METHODS
    ]  # fmt: skip


def users(problem: Problem, works: dict[str, Work]) -> list[Method]:
    """SciPy as a user would."""
    exact, middle = problem.exact(), problem.nodes // 2

    def solve(tolerance: float, name: str) -> np.ndarray:
        start = problem.curvature, problem.activity
        return in_space.solve(problem.swimmer, *start, problem.times, name, tolerance)[:, middle:]

    return [
        _method(f"SciPy, user, {name}", works, problem.size.user, exact, partial(solve, name=name), slow=True)
        for name in problem.size.user_methods
    ]


def dissertations(problem: Problem, works: dict[str, Work]) -> list[Method]:
    """The dissertation's method with the expert's right side."""
    if missing("numba"):
        return []

    def solve(step: float) -> np.ndarray:
        return dissertation.solve(problem.swimmer, problem.half, problem.times, step)

    return [_method("dissertation, BDF2 + hybrid", works, problem.size.steps, problem.exact(), solve, slow=True)]


def _method(
    name: str,
    works: dict[str, Work],
    values: Sequence[float],
    exact: np.ndarray,
    solve: Callable[[float], np.ndarray],
    slow: bool = False,
) -> Method:
    """Runs at several tolerances or steps; one that fails has an infinite error."""
    method, found = Method(name), dict[float, np.ndarray]()

    def work(value: float) -> None:
        try:
            found[value] = solve(value)
        except ArithmeticError:
            found[value] = np.full_like(exact, np.inf)

    for value in values:
        key = f"{name}, {value:g}"
        works[key] = Work(partial(work, value), slow=slow)
        method.runs[key] = lambda value=value: error(found[value], exact)
    return method


@dataclass(frozen=True)
class Elastica:
    """A run of PyElastica: mass over drag, its largest stable step, CPU seconds, error, the largest strain."""

    mass: float
    step: float
    alone: float
    batched: float
    error: float
    strain: float


def elasticas(problem: Problem, times: dict[str, Times]) -> list[Elastica]:
    """PyElastica for each mass, at its largest stable step among those that divide the time in powers of √2."""
    fine = Problem(problem.bend, problem.size, FINE * (problem.nodes - 1) + 1)
    half = fine.exact()[:, ::FINE]
    exact = np.concatenate([half[:, :0:-1], half], axis=1)[:, 1:-1]
    return [found for mass in problem.size.masses if (found := elastica(problem, mass, exact)) is not None]


def elastica(problem: Problem, mass: float, exact: np.ndarray) -> Elastica | None:
    """The first step that is stable, from the longest downwards."""
    made_of = problem.swimmer, problem.curvature, problem.activity, mass
    between = problem.times[0]
    pyelastica.run(pyelastica.make(*made_of), BATCHED_TIME, BATCHED_STEPS, BATCHED_STEPS)  # compiles
    for halvings in range(13):
        shown = int(np.ceil(between / (problem.size.longest * 2 ** (-halvings / 2))))
        made, found = pyelastica.make(*made_of), list[Any]()
        steps = shown * len(problem.times)
        work = Work(lambda made=made, n=steps, k=shown, out=found: out.append(pyelastica.run(made, between / k, n, k)))
        seconds = in_turns({"alone": work._replace(slow=True)})["alone"].median
        if found[0] is not None and error(found[0], exact) < 0.5:
            batch = pyelastica.make(*made_of, count=problem.size.batch)
            together = Work(lambda: pyelastica.run(batch, BATCHED_TIME, BATCHED_STEPS, BATCHED_STEPS))
            batched = in_turns({"batch": together}, 3)["batch"].median / BATCHED_STEPS / problem.size.batch * steps
            return Elastica(mass, between / shown, seconds, batched, error(found[0], exact), made.stretched)
    return None


# --- tables and figure ------------------------------------------------------------------------------------------------


def table(problem: Problem, methods: list[Method], times: dict[str, Times], rows: list[Elastica]) -> Table:
    """Milliseconds a rod at the errors asked for, over ours of one rod and over ours in the largest common batch."""
    reached = {m.name: [time_at(*m.curve(times), target) for target in TARGETS] for m in methods}
    batch = problem.size.counts[-2]
    ones, many = reached[f"ours, B = {problem.size.counts[0]}"], reached[f"ours, B = {batch}"]
    columns = ["", "least error"]
    for target in TARGETS:
        columns += [f"ms a rod at {target:g}", "over ours, B = 1", f"over ours, B = {batch}"]
    lines: list[list[Any]] = []
    for method in methods:
        line: list[Any] = [method.name, min(method.curve(times)[0])]
        for time, one, of_many in zip(reached[method.name], ones, many, strict=True):
            line += [time and 1e3 * time, time and one and time / one, time and of_many and time / of_many]
        lines.append(line)
    for e in rows:
        for name, seconds in (("alone", e.alone), (f"in a batch of {problem.size.batch}", e.batched)):
            what = f"PyElastica {name}, mass {e.mass:g}, Δt = {e.step:.2g}, stretched {100 * e.strain:.1f} %"
            over = [base and seconds / base for base in (ones[0], many[0])]
            lines.append([what, e.error, f"{1e3 * seconds:.3g} (never)", *over, None, None, None])
    return Table(f"β⊥ = {problem.bend:g}", columns, lines)


def draw(axes: Any, problem: Problem, methods: list[Method], times: dict[str, Times], rows: list[Elastica]) -> None:
    """Time against error of each method."""
    markers = "osd^vx+*<>"
    for number, method in enumerate(methods):
        errors, seconds = method.curve(times)
        mine = method.name.startswith("ours")
        colour = plots.OKABE_ITO[0 if mine else 1 + number % 6]
        axes.loglog(
            errors, 1e3 * np.array(seconds), marker=markers[number % 10], ls="-" if mine else "--", lw=0.8, ms=2.5,
            color=colour, label=method.name,
        )  # fmt: skip
    for e in rows:
        axes.loglog(e.error, 1e3 * e.alone, "P", color="k", ms=3, label=f"PyElastica, mass {e.mass:g}")
    axes.set_title(f"β⊥ = {problem.bend:g}")
    axes.set_xlabel("error of the curvature")
    axes.grid(True)


def notes(size: Size) -> list[str]:
    return [
        f"N = {size.nodes}, beam mode 0 of amplitude {AMPLITUDE:g} at the start, until t = {size.times[-1]:g}; η = 2, "
        f"τf = 1e-2, D = 1e-3. Error: the largest difference of the curvature at any node and any of "
        f"{len(size.times)} times, over the largest curvature, from Radau at {EXACT:g} on the same equations in space. "
        f"In a batch β⊥ varies by ±{100 * SPREAD:g} %, and the error is the root mean square over some rods. Times "
        "between two runs by powers; – where no run is so precise. Where the quickest run is more precise, its time.",
        "Ours: steps chosen by error, at tolerances "
        f"{size.ours[0]:g} to {size.ours[-1]:g}; making the ensemble and reading frames are not counted.",
        "SciPy's expert: planar, halved by symmetry, right side and Jacobian compiled by Numba; banded: the part of the "
        "Jacobian at given tension. User: NumPy, in space, dense Jacobian by differences. Both solve one rod after "
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
        "Published, not measured here: PyElastica-JAX 7e5 rod-steps/s (GH200, 4096 rods, 20–50 elements); dismech-newton "
        "1.37e5 rod-steps/s (RTX 2070 Super, 2560 rods). Neither is on PyPI."
    )

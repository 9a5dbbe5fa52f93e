"""The methods that solve the swimmer, each at several tolerances or steps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from warp_rods.bench.curves import Curve
from warp_rods.bench.peers import dissertation, in_space, planar
from warp_rods.bench.peers.optional import missing
from warp_rods.bench.swimmer_problem import AMPLITUDE, TARGETS, TWIST, Problem, error
from warp_rods.bench.timing import Work
from warp_rods.rods.free.rods import FreeRods


def ours(problem: Problem, works: dict[str, Work]) -> list[Curve]:
    """This package, in batches, at several tolerances."""
    size, curves = problem.size, list[Curve]()
    counts = size.counts if problem.bend == size.largest_at else size.counts[:-1]
    for count in counts:
        rods = problem.rods(count)
        curve = Curve(f"ours, B = {count}", share=count)
        start, sample = rods.state(), np.linspace(0, count - 1, min(size.sampled, count)).astype(int)
        exact = [problem.exact(bend) for bend in rods.bend[sample]]
        alone = [error() for error in curves[0].errors.values()] if curves else []
        for tolerance in size.ours if count <= size.whole else around(size.ours, alone):
            key = f"{curve.name}, {tolerance:g}"
            before = partial(rods.restore, start)
            works[key] = Work(partial(rods.advance_to, problem.times[-1], tolerance), before, slow=count > size.whole)
            value = our_error(problem, rods, start, tolerance, sample, exact)
            curve.errors[key] = partial(float, value)
        curves.append(curve)
    return curves


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


def experts(problem: Problem, works: dict[str, Work]) -> list[Curve]:
    """SciPy as an expert would use it; without Numba the right side would be Python."""
    if missing("numba"):
        return []
    exact = problem.exact()
    return [
        _curve(
            f"SciPy, expert, {name}", works, problem.size.expert, exact,
            partial(planar.solve, problem.swimmer, problem.half, problem.times, name),
        )
        for name in planar.METHODS
    ]  # fmt: skip


def users(problem: Problem, works: dict[str, Work]) -> list[Curve]:
    """SciPy as a user would."""
    exact, middle = problem.exact(), problem.nodes // 2

    def solve(tolerance: float, name: str) -> np.ndarray:
        start = problem.curvature, problem.activity
        return in_space.solve(problem.swimmer, *start, problem.times, name, tolerance)[:, middle:]

    return [
        _curve(f"SciPy, user, {name}", works, problem.size.user, exact, partial(solve, name=name), slow=True)
        for name in problem.size.user_methods
    ]


def dissertations(problem: Problem, works: dict[str, Work]) -> list[Curve]:
    """The dissertation's method with the expert's right side."""
    if missing("numba"):
        return []

    def solve(step: float) -> np.ndarray:
        return dissertation.solve(problem.swimmer, problem.half, problem.times, step)

    return [_curve("dissertation, BDF2 + hybrid", works, problem.size.steps, problem.exact(), solve, slow=True)]


def error_of(found: dict[float, np.ndarray], value: float, exact: np.ndarray) -> float:
    """The error of a run that was made."""
    return error(found[value], exact)


def _curve(
    name: str,
    works: dict[str, Work],
    values: Sequence[float],
    exact: np.ndarray,
    solve: Callable[[float], np.ndarray],
    slow: bool = False,
) -> Curve:
    """Runs at several tolerances or steps; one that fails has an infinite error."""
    curve, found = Curve(name), dict[float, np.ndarray]()

    def work(value: float) -> None:
        try:
            found[value] = solve(value)
        except ArithmeticError:
            found[value] = np.full_like(exact, np.inf)

    for value in values:
        key = f"{name}, {value:g}"
        works[key] = Work(partial(work, value), slow=slow)
        curve.errors[key] = partial(error_of, found, value, exact)
    return curve


METHODS = (ours, experts, users, dissertations)
"""Each adds works, and returns their curves; one whose package is missing none."""

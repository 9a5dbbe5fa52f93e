"""PyElastica on the swimmer, at its largest stable step."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from warp_rods.bench.peers import pyelastica
from warp_rods.bench.peers.pyelastica import Made
from warp_rods.bench.swimmer_problem import Problem, error
from warp_rods.bench.timing import Work, cpu_seconds, in_turns

FINE = 4
"""The rod that it is compared with has this many times its cells."""
BATCHED_STEPS, BATCHED_TIME = 40, 1e-6
"""Steps that are timed in a batch, and their length: they cost the same at any length."""
WRONG = 0.5
"""A run with a larger error is unstable."""
TRIES = 13


@dataclass(frozen=True)
class Elastica:
    """A run of PyElastica: mass over drag, its largest stable step, CPU seconds, error, the largest strain."""

    mass: float
    step: float
    alone: float
    batched: float
    error: float
    strain: float


def runs(problem: Problem) -> list[Elastica]:
    """PyElastica for each mass, at its largest stable step among those that divide the time in powers of √2."""
    fine = Problem(problem.bend, problem.size, FINE * (problem.nodes - 1) + 1)
    half = fine.exact()[:, ::FINE]
    exact = np.concatenate([half[:, :0:-1], half], axis=1)[:, 1:-1]
    return [found for mass in problem.size.masses if (found := stable(problem, mass, exact)) is not None]


def stable(problem: Problem, mass: float, exact: np.ndarray) -> Elastica | None:
    """The first step that is stable, from the longest downwards."""
    made_of = problem.swimmer, problem.curvature, problem.activity, mass
    between = problem.times[0]
    pyelastica.run(pyelastica.make(*made_of), BATCHED_TIME, BATCHED_STEPS, BATCHED_STEPS)  # compiles
    for halvings in range(TRIES):
        shown = int(np.ceil(between / (problem.size.longest * 2 ** (-halvings / 2))))
        steps, step = shown * len(problem.times), between / shown
        made, found = pyelastica.make(*made_of), list[Any]()
        alone = cpu_seconds(Work(partial(_run, made, step, steps, shown, found)))
        if found[0] is not None and error(found[0], exact) < WRONG:
            of_step = in_a_batch(pyelastica.make(*made_of, count=problem.size.batch))
            return Elastica(mass, step, alone, of_step * steps, error(found[0], exact), made.stretched)
    return None


def _run(made: Made, step: float, steps: int, shown: int, found: list[Any]) -> None:
    found.append(pyelastica.run(made, step, steps, shown))


def in_a_batch(made: Made) -> float:
    """Seconds of a rod-step."""
    work = Work(partial(pyelastica.run, made, BATCHED_TIME, BATCHED_STEPS, BATCHED_STEPS))
    return in_turns({"": work}, 3)[""].median / BATCHED_STEPS / len(made.rods)

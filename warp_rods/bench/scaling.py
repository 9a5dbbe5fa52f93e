"""How the cost of a step grows with rods, nodes, cores and cells that touch."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from warp_rods.bench import crowd, machine, rods
from warp_rods.bench.result import Section, Settings, Table
from warp_rods.bench.timing import Work, in_turns, times_of
from warp_rods.draw import plots
from warp_rods.rods.ensemble import Ensemble

BRIEF = 1e-3
"""The time for which rods are stepped from their start, in about ten steps of their own, in units of a swimmer's."""
BRIEF_BOUND = 1e-5
ONCE_ABOVE = 5000
"""Ensembles of more rods are measured once."""


@dataclass(frozen=True)
class Size:
    """How much is measured."""

    rods: Sequence[int] = (1, 10, 100, 1000, 10_000, 100_000)
    bound: Sequence[int] = (1, 10, 100, 1000, 10_000)
    nodes: Sequence[int] = (33, 65, 129, 257, 513, 1025)
    of_many_nodes: int = 10
    shared: Sequence[int] = (16, 100, 1000)
    cores: Sequence[int] = (1, 2)
    crowds: Sequence[int] = (100, 316, 1000, 3162, 10_000)
    crowd_steps: int = 20
    repeats: int = 3


FULL = Size()
QUICK = Size((1, 4), (1, 4), (33, 65), 2, (4,), (1,), (20, 40), 2, 1)


def run(settings: Settings) -> Section:
    """Costs, exponents and a figure."""
    size = QUICK if settings.quick else FULL
    curves = {
        "free rods": (size.rods, [cost(swimmers, n, size, settings) for n in size.rods]),
        "bound rods": (size.bound, [cost(sensors, n, size, settings) for n in size.bound]),
        "nodes": (size.nodes, [cost(partial(of_nodes, size), n, size, settings) for n in size.nodes]),
        "cells that touch": (size.crowds, [of_crowd(n, size, settings) for n in size.crowds]),
    }
    tables = [table(name, *curve) for name, curve in curves.items()]
    tables.append(shared(size, settings))
    return Section(tables, {"scaling": figure(curves)}, NOTES)


NOTES = (
    "CPU time of a step of all rods on one core; own steps from the start of the rods. Exponent: slope between the "
    "last two sizes, and fitted over the last half. Swimmers in a plane, 33 nodes; sensors on a dumbbell, 33 nodes; 10 "
    "swimmers of more nodes; cells in a film (nematic lanes, area fraction 0.3), steps together with contact.",
    "Cores: wall time, which other work on the machine disturbs. Each core's rods are a slice of the batch.",
)


def swimmers(count: int) -> Ensemble:
    return rods.swimmers(count, False, rods.BOUND_NODES)


def sensors(count: int) -> Ensemble:
    return rods.sensors(count, rods.dumbbell)


def of_nodes(size: Size, nodes: int) -> Ensemble:
    return rods.swimmers(size.of_many_nodes, False, nodes)


def brief(ensemble: Ensemble) -> tuple[Work, Callable[[], int]]:
    """A few steps from the start, and the number of steps in them, of a rod on the average."""
    start = ensemble.state()
    end = BRIEF_BOUND if hasattr(ensemble, "surface") else BRIEF

    def steps() -> int:
        return int((ensemble.steps_taken + ensemble.steps_rejected).mean().round())

    return Work(lambda: ensemble.advance_to(end), lambda: ensemble.restore(start)), steps


def cost(make: Callable[[int], Ensemble], number: int, size: Size, settings: Settings) -> float:
    """Seconds of a step of all rods."""
    settings.tell(f"{getattr(make, '__name__', 'nodes')}, {number}")
    ensemble = make(number)
    work, steps = brief(ensemble)
    times = in_turns({"": work._replace(slow=ensemble.count > ONCE_ABOVE)}, size.repeats)
    return times[""].median / steps()


def of_crowd(count: int, size: Size, settings: Settings) -> float:
    """Seconds of a step of cells that touch, lists and all."""
    settings.tell(f"{count} cells that touch")
    return crowd.seconds_per_step(count, size.crowd_steps)


def table(name: str, sizes: Sequence[int], seconds: Sequence[float]) -> Table:
    """Costs and exponents."""
    rows = [[float(n), 1e6 * t, 1e6 * t / n] for n, t in zip(sizes, seconds, strict=True)]
    columns = [name, "µs a step", "µs a step, over their number"]
    local, fitted = exponent(sizes, seconds)
    return Table(f"{name}: exponent {local:.2f} at the end, {fitted:.2f} fitted", columns, rows)


def exponent(sizes: Sequence[int], seconds: Sequence[float]) -> tuple[float, float]:
    """The slope of log(seconds) against log(size) between the last two, and over the last half."""
    x, y = np.log(sizes), np.log(seconds)
    half = max(2, (len(x) + 1) // 2)
    return float((y[-1] - y[-2]) / (x[-1] - x[-2])), float(np.polyfit(x[-half:], y[-half:], 1)[0])


def shared(size: Size, settings: Settings) -> Table:
    """Wall time on one and more cores."""
    rows: list[list[Any]] = []
    for count in size.shared:
        settings.tell(f"{count} rods on {max(size.cores)} cores")
        works = {n: on_cores(count, n) for n in size.cores if machine.use_cores(n)}
        seconds: dict[int, list[float]] = {n: [] for n in works}
        for _ in range(size.repeats + 1):
            for n, work in works.items():
                assert work.before is not None
                work.before()
                start = time.perf_counter()
                work.run()
                seconds[n].append(time.perf_counter() - start)
        median = {n: times_of(values[1:]).median for n, values in seconds.items()}
        first = median.get(size.cores[0])
        rows.append([f"{count} swimmers", *(first / median[n] if first and n in median else None for n in size.cores)])
    machine.use_one_core()
    return Table("cores: wall time on one over that on", ["", *(f"{n} cores" for n in size.cores)], rows)


def on_cores(count: int, number: int) -> Work:
    """Steps of swimmers in space, whose slices are for this number of cores."""
    stepped = rods.Stepped(rods.swimmers(count, True), "own")

    def before() -> None:
        machine.use_cores(number)
        stepped.restore()

    return Work(stepped.run, before)


def figure(curves: Mapping[str, tuple[Sequence[int], Sequence[float]]]) -> Any:
    """Costs against sizes, and lines of slope 1."""
    page = plots.figure(plots.PAGE, 50)
    for axes, (name, (sizes, seconds)) in zip(page.subplots(1, len(curves)), curves.items(), strict=True):
        axes.loglog(sizes, 1e6 * np.array(seconds), "o-", ms=3)
        axes.loglog(sizes, 1e6 * seconds[-1] * np.array(sizes) / sizes[-1], color="0.6", lw=0.8)
        axes.set_xlabel(name)
    page.axes[0].set_ylabel("µs a step; grey: slope 1")
    return page

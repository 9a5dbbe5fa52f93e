"""Error against the number of steps, in steps of equal length and by error, against tolerance, and against nodes.

Errors are the largest of any node at the end, in lengths of a rod, against a run with a hundredth of the tolerance.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from warp_rods.bench import rods
from warp_rods.bench.random_rods import random_errors
from warp_rods.bench.result import Cell, Section, Settings, Table
from warp_rods.draw import plots
from warp_rods.rods.free.rods import FreeRods

BENT = {"kind": "mode", "amplitude": 3.0}
Make = Callable[[int], Any]


@dataclass(frozen=True)
class Size:
    """How much is measured; ``random``: random swimmers, and filaments on each membrane."""

    tolerances: Sequence[float] = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.001)
    steps: Sequence[float] = (2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4)
    nodes: Sequence[int] = (17, 25, 33, 49, 65, 97, 129)
    finest: int = 257
    random: tuple[int, int] = (120, 16)


FULL = Size()
QUICK = Size((0.1,), (2e-2,), (17, 33), 33, (3, 1))


def swimmer(nodes: int, bend: float) -> FreeRods:
    return FreeRods(1, nodes, bend=bend, twist=1e-3, shape=BENT, symmetric=True)


def sensors(nodes: int) -> Any:
    """Sixteen sensors of ``proteins.toml`` without contact."""
    return rods.sensors(16, rods.dumbbell, nodes)


CASES: dict[str, tuple[Make, int, float]] = {
    "U swimmer, bend 5e-3": (partial(swimmer, bend=5e-3), 65, 8.0),
    "waving swimmer, bend 1.3e-4": (partial(swimmer, bend=1.3e-4), 141, 10.0),
    "sensors on a neck": (sensors, 33, 6.0),
}
"""Name → rods with this many nodes, the number, and the time at the end."""


def run(settings: Settings) -> Section:
    """The figure of docs/steps.md, its numbers, and errors over tolerances of random rods."""
    log, size = logging.getLogger("warp_rods"), QUICK if settings.quick else FULL
    before = log.level
    log.setLevel(logging.ERROR)  # equal steps that are too long are meant to be
    try:
        page = plots.figure(plots.PAGE, 75)
        panels = page.subplots(1, 3)
        tables = [
            case(name, size, panels, colour, settings) for colour, name in zip(plots.OKABE_ITO, CASES, strict=False)
        ]
        label(page, panels, size)
        tables.append(random_errors(*size.random, settings))
    finally:
        log.setLevel(before)
    return Section(tables, {"steps": page})


def case(name: str, size: Size, panels: Any, colour: str, settings: Settings) -> Table:
    """One kind of rod: a table, and its curves in the three panels."""
    make, nodes, end = CASES[name]
    settings.tell(f"{name}: exact run")
    exact, _, _ = by_error(make, nodes, end, min(size.tolerances) / 10)
    rows: list[list[Cell]] = []
    for how, run, values, marker in (
        ("by error", by_error, size.tolerances, "o-"),
        ("equal", equal, size.steps, "s--"),
    ):
        found = []
        for value in values:
            settings.tell(f"{name}: steps {how}, {value:g}")
            ensemble, steps, seconds = run(make, nodes, end, value)
            if not ensemble.status.any():
                found.append((value, steps, error(ensemble, exact), 1e3 * seconds))
        rows += [[how, *line] for line in found]
        column = np.array(found).reshape(-1, 4).T
        panels[0].loglog(column[1], column[2], marker, color=colour, ms=3, label=f"{name}, {how}")
        if how == "by error":
            panels[1].loglog(column[0], column[2], marker, color=colour, ms=3)
    in_space = errors_of_nodes(make, size, end, settings)
    panels[2].loglog(list(in_space), list(in_space.values()), "o-", color=colour, ms=3)
    rows += [[f"N = {n}", None, None, value, None] for n, value in in_space.items()]
    return Table(f"{name}, until t = {end:g}", ["", "tolerance, or step", "steps", "error (L)", "CPU ms"], rows)


def errors_of_nodes(make: Make, size: Size, end: float, settings: Settings) -> Mapping[int, float]:
    """Number of nodes → error against the finest rod."""
    settings.tell(f"{size.finest} nodes")
    finest, _, _ = by_error(make, size.finest, end, 1e-3)
    nested = [n for n in size.nodes if (size.finest - 1) % (n - 1) == 0]
    return {n: error(by_error(make, n, end, 1e-3)[0], finest) for n in nested}


def label(page: Any, panels: Any, size: Size) -> None:
    """Axes and legend."""
    panels[1].loglog(size.tolerances, size.tolerances, color="0.6", linewidth=0.8)
    for panel, text in zip(panels, ("steps of a rod", "tolerance", "nodes"), strict=True):
        panel.set_xlabel(text)
    panels[2].set_xticks([17, 33, 65, 129], ["17", "33", "65", "129"])
    panels[2].minorticks_off()
    panels[0].set_ylabel("error at the end ($L$)")
    page.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=2, fontsize=6)


def error(found: Any, exact: Any) -> float:
    """The largest distance of a node, in lengths of a rod; nodes of the finer rods that both have."""
    stride = (exact.nodes - 1) // (found.nodes - 1)
    length = getattr(found, "length", np.ones(found.count))
    distance = np.linalg.norm(found.position - exact.position[:, ::stride], axis=-1).max(axis=1)
    return float((distance / length).max())


def by_error(make: Make, nodes: int, end: float, tolerance: float) -> tuple[Any, float, float]:
    """Rods, mean number of steps, and seconds."""
    ensemble, start = make(nodes), time.process_time()
    ensemble.advance_to(end, tolerance)
    return ensemble, float((ensemble.steps_taken + ensemble.steps_rejected).mean()), time.process_time() - start


def equal(make: Make, nodes: int, end: float, step: float) -> tuple[Any, float, float]:
    """The same in steps of equal length."""
    ensemble, start = make(nodes), time.process_time()
    ensemble.step(step, round(end / step))
    return ensemble, float((ensemble.steps_taken + ensemble.steps_rejected).mean()), time.process_time() - start

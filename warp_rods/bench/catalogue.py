"""The table of benchmarks.

To add one, write a function ``(Settings) -> Section`` in a module of this folder and give it a row of ``BENCHMARKS``.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import NamedTuple

from warp_rods.bench.result import Section, Settings


class Benchmark(NamedTuple):
    """What it measures; the module of this folder whose ``run`` does; about how many minutes it takes."""

    what: str
    module: str
    minutes: float

    def make(self) -> Callable[[Settings], Section]:
        """The function; other codes are imported with it."""
        return import_module(f"warp_rods.bench.{self.module}").run  # type: ignore[no-any-return]


BENCHMARKS: dict[str, Benchmark] = {
    "kernels": Benchmark("kernels and whole steps beside the memory's bandwidth, LAPACK and Numba", "kernels", 2),
    "swimmer": Benchmark("time to solution at equal error: the planar active swimmer", "swimmer", 5),
    "filament": Benchmark("a filament on a membrane, also by a penalty chain and by projected beads", "filament", 2),
    "scenes": Benchmark("scenes end to end: proteins.toml and swarm_2d.toml, also against another commit", "scenes", 6),
    "scaling": Benchmark("cost against rods, nodes, cores and cells that touch", "scaling", 2),
    "gpu": Benchmark("steps on a GPU beside the bandwidth of its memory", "gpu", 1),
    "steps": Benchmark("error against steps, tolerance and nodes (docs/steps.md)", "steps", 2),
}
"""By name, in the order of the results."""

"""The planar active swimmer whose time to solution is measured, and its exact solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from warp_rods.bench.peers import planar
from warp_rods.rods.free.rods import FreeRods

AMPLITUDE, TWIST = 3.0, 1e-3
"""Amplitude of beam mode 0 at the start; twist stiffness, which a planar rod does not feel."""
SPREAD = 0.1
"""Stiffnesses of the rods of a batch lie this far on each side of β⊥, so that no two do the same."""
EXACT = 1e-10
TARGETS = (1e-3, 1e-5)


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

"""Time per step of swarms of 100 to 10 000 cells at area fraction 0.3: ``python benchmarks/swarm.py``.

Cells of N = 33 nodes in a periodic slab, as in scenes/swarm_2d.toml. Rods: frames, tension, velocities, new strains.
Pairs: sums over neighbour lists. Search: construction of the lists, divided by the steps for which they are valid.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import warp as wp

from warp_rods.device import cores
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation

COUNTS = (100, 316, 1000, 3162, 10_000)
NODES = 33
STEP = 2.5e-4
STEPS = 200
REPEATS = 5


def swarm(count: int) -> Scene:
    """Nematic lanes, which are dense, fast to place and soon in contact."""
    cells = {
        "name": "cells", "count": count, "nodes": NODES, "bend": 5e-3, "twist": 1e-3, "placement": "nematic lanes",
        "flagella": {"profile": "uniform"}, "shape": {"kind": "mode", "amplitude": 0.3},
    }  # fmt: skip
    return Scene(
        swimmers=[cells],
        box={"kind": "slab", "height": 0.12, "fraction": 0.3},
        steric={"strength": 1000.0, "range": 0.02, "core": 0.08},
        time={"end": STEP * STEPS, "step": STEP, "save_every": STEP * STEPS},
    )


def shortest_time(work: Callable[[], object]) -> float:
    """Seconds of the fastest of several calls."""
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        wp.synchronize()
        times.append(time.perf_counter() - start)
    return min(times)


def seconds_per_step(count: int, device: str) -> tuple[float, float, float, float]:
    """Seconds per step of rods, pairs and search, and of the whole loop, which also checks how far nodes move."""
    simulation = Simulation(swarm(count), device)
    simulation.warm_up()
    neighbours = simulation._surroundings.neighbours
    assert neighbours is not None
    rebuilds, rebuild_lists = [0], neighbours.rebuild_lists

    def counted() -> None:
        rebuilds[0] += 1
        rebuild_lists()

    neighbours.rebuild_lists = counted  # type: ignore[method-assign]
    start = time.perf_counter()
    for _ in simulation.to_next_frame():
        pass
    wp.synchronize()
    whole = (time.perf_counter() - start) / STEPS
    rods = simulation.ensembles["cells"]
    search = shortest_time(rebuild_lists) * rebuilds[0] / STEPS
    return shortest_time(lambda: rods.step(1e-12)), shortest_time(neighbours.apply), search, whole


def main() -> None:
    """Print a table."""
    device = sys.argv[1] if len(sys.argv) > 1 else "cpu"
    print(f"{cores()} cores; ns per node and step; N = {NODES}, area fraction 0.3")
    print(f"{'cells':>7}{'rods':>8}{'pairs':>8}{'search':>8}{'(p+s)/r':>9}{'loop':>8}{'rod-steps/s':>13}")
    totals = []
    for count in COUNTS:
        rods, pairs, search, whole = seconds_per_step(count, device)
        totals.append(whole)
        node = 1e9 / (count * NODES)
        print(
            f"{count:7}{rods * node:8.0f}{pairs * node:8.0f}{search * node:8.0f}{(pairs + search) / rods:9.2f}"
            f"{whole * node:8.0f}{count / whole:13.0f}",
            flush=True,
        )
    slope = np.polyfit(np.log(COUNTS), np.log(totals), 1)[0]
    local = [np.log(b / a) / np.log(m / n) for (a, b), (n, m) in zip(pairwise(totals), pairwise(COUNTS), strict=True)]
    print(f"cost ~ cells^{slope:.3f}; exponents from one count to the next {', '.join(f'{x:.2f}' for x in local)}")


if __name__ == "__main__":
    main()

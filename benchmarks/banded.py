"""Time per node of the batched banded solvers, compared with SciPy for one rod at a time.

Run as ``python benchmarks/banded.py``. One thread of one CPU core (or the first GPU), 65 nodes per rod, variable
coefficients. A solve is a replayed graph, as in a step of an ensemble; each time is the minimum over repeats.
"""

import time

import numpy as np
import warp as wp
from scipy.linalg import solve_banded

from warp_rods.kernels import banded
from warp_rods.kernels.layout import per_node, real

NODES = 65
BATCHES = (1, 100, 1000, 10_000)
SCIPY_LIMIT = 1000
SECONDS = 0.5


def coefficients(bands: int, rods: int) -> np.ndarray:
    """Diagonally dominant coefficients [band, rod, node]."""
    values = np.random.default_rng(0).normal(size=(bands, rods, NODES))
    values[bands // 2] += 8.0
    return values


def shortest_time(work) -> float:
    """Seconds of the fastest call within a fixed total time; at least five calls."""
    shortest, calls, end = float("inf"), 0, time.perf_counter() + SECONDS
    while calls < 5 or time.perf_counter() < end:
        start = time.perf_counter()
        work()
        shortest = min(shortest, time.perf_counter() - start)
        calls += 1
    return shortest


def warp_time(bands: int, rods: int, pairs: bool) -> float:
    device = wp.get_device()
    dtype = wp.vec2d if pairs else real
    rows = [per_node(rods, NODES) for _ in range(bands)]
    for row, values in zip(rows, coefficients(bands, rods), strict=True):
        row.assign(values)
    right, solution = per_node(rods, NODES, dtype), per_node(rods, NODES, dtype)
    right.fill_(dtype(1.0))
    work = per_node(rods, NODES, real if bands == 3 else wp.vec2d)
    kernel = banded.solve_tridiagonal if bands == 3 else banded.solve_pentadiagonal
    wp.load_module(banded)
    with wp.ScopedCapture() as capture:
        wp.launch(kernel, rods, [*rows, right, work, solution])

    def replay():
        wp.capture_launch(capture.graph)
        wp.synchronize_device(device)

    return shortest_time(replay)


def scipy_time(bands: int, rods: int) -> float:
    packed = np.ascontiguousarray(coefficients(bands, rods).transpose(1, 0, 2)[:, ::-1])
    right, width = np.ones(NODES), bands // 2

    def solve():
        for rod in packed:
            solve_banded((width, width), rod, right, check_finite=False)

    return shortest_time(solve)


def main() -> None:
    wp.config.log_level = wp.LOG_WARNING
    print(f"ns per node, {NODES} nodes per rod, on {wp.get_device().name}")
    print(f"{'':32}" + "".join(f"{f'B={rods}':>10}" for rods in BATCHES))
    for bands, name in ((3, "tridiagonal"), (5, "pentadiagonal")):
        for pairs, kind in ((False, "numbers"), (True, "pairs")):
            figures = [warp_time(bands, rods, pairs) / (rods * NODES) * 1e9 for rods in BATCHES]
            print(f"{name + ', ' + kind:32}" + "".join(f"{figure:10.1f}" for figure in figures))
        figures = [scipy_time(bands, rods) / (rods * NODES) * 1e9 for rods in BATCHES if rods <= SCIPY_LIMIT]
        print(f"{name + ', SciPy':32}" + "".join(f"{figure:10.1f}" for figure in figures))


if __name__ == "__main__":
    main()

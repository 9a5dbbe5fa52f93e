"""Ensembles recorded, stepped and read in several Python threads at the same time: the bits are those of one thread."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from examples.free import in_space

from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods


def run_free(number: int) -> list[np.ndarray]:
    rods = in_space("cpu", nodes=17 + 2 * number, bend=1e-3 * (1 + number))
    return _run(rods)


def run_bound(number: int) -> list[np.ndarray]:
    torus = surfaces.make("torus", {"major": 1.0 + 0.1 * number, "minor": 0.4})
    rods = BoundRods(torus, [[1.5, 0, 0.1]], [[0, 1, 0.3]], nodes=17 + number, intrinsic=(0.7, 1.0, 0), device="cpu")
    return _run(rods)


def _run(rods) -> list[np.ndarray]:
    found = []
    for round_ in range(4):
        rods.force = np.array([0.0, 0.1 * round_, 0.2])
        rods.step(1e-3, 5)
        found += [rods.position, rods.strain, rods.energy, rods.tension]
    state = rods.state()
    rods.step(1e-3, 3)
    rods.restore(state)
    return [*found, rods.position]


def test_threads_do_not_disturb_each_other():
    """Many short runs, so that recording, allocating and replaying coincide in every combination."""
    jobs = [(run, number) for number in range(12) for run in (run_free, run_bound)]
    alone = [run(number) for run, number in jobs]
    with ThreadPoolExecutor(8) as pool:
        for _ in range(3):
            together = list(pool.map(lambda job: job[0](job[1]), jobs))
            for ours, theirs in zip(together, alone, strict=True):
                for a, b in zip(ours, theirs, strict=True):
                    np.testing.assert_array_equal(a, b)

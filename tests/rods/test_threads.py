"""Ensembles stepped by several threads, one for each slice: the bits are those of one thread."""

import numpy as np
import pytest
from examples.steric import STERIC, Held, all_forces, random_walks
from reference.steric import Rods

from warp_rods.contact.neighbours import Neighbours
from warp_rods.kernels.lanes import WIDTH
from warp_rods.rods import slices
from warp_rods.rods.free.rods import FreeRods


def set_cores(monkeypatch, count: int) -> None:
    monkeypatch.setattr(slices, "cores", lambda: count)
    monkeypatch.setattr(slices, "NODES_PER_THREAD", 10)


def swirl(t: float, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    return np.sin(5 * position[..., [1, 2, 0]]) + t


@pytest.mark.parametrize("external", [None, swirl])
def test_several_threads_give_the_bits_of_one(external, monkeypatch, verified):
    found = []
    for count in (1, 3):
        set_cores(monkeypatch, count)
        bend = np.linspace(1e-3, 1e-2, 7)
        shape = {"kind": "writhe", "amplitude": 1.0}
        rods = FreeRods(7, 33, bend=bend, twist=1e-3, moment=1e-3, shape=shape, external=external, device="cpu")
        rods.step(1e-3, 50)
        found.append(rods.variables())
    assert np.ptp(found[0]["energy"]) > 0
    name = f"swimmers in three threads{', with a force' if external else ''}: a frame"
    verified.same(name, found[1], found[0], reference="one thread")


def test_steric_sums_in_several_threads_give_the_bits_of_one(monkeypatch):
    forces = []
    for count in (1, 3):
        set_cores(monkeypatch, count)
        rods: Rods = random_walks(np.random.default_rng(6), 11, 17, 0.4, 0.2)
        held = [Held(rods, "cpu")]
        Neighbours(held, **STERIC, device="cpu").apply()
        forces.append(all_forces(held))
    assert np.abs(forces[0]).max() > 0
    np.testing.assert_array_equal(*forces)


@pytest.mark.parametrize(
    ("count", "size", "expected"), [(1, 33, 1), (1000, 33, 3), (10_000, 33, 8), (3 * WIDTH, 100_000, 3)]
)
def test_each_slice_has_enough_nodes_for_a_thread(count, size, expected, monkeypatch):
    monkeypatch.setattr(slices, "cores", lambda: 8)
    parts = slices.thread_slices(count, size, "cpu")
    assert len(parts) == expected
    assert [i for part in parts for i in range(part.start, part.stop)] == list(range(count))

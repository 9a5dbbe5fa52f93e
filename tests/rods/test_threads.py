"""Slices of an ensemble, a thread each: the same bits as one thread's."""

import numpy as np
import pytest
from examples.steric import STERIC, Held, all_forces, walks
from reference.steric import Rods

from warp_rods.contact.neighbours import Neighbours
from warp_rods.rods import recorded
from warp_rods.rods.free.rods import FreeRods


def cores(monkeypatch, count: int) -> None:
    monkeypatch.setattr(recorded, "cores", lambda: count)
    monkeypatch.setattr(recorded, "WORTH_A_THREAD", 10)


def swirl(t: float, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    return np.sin(5 * position[..., [1, 2, 0]]) + t


@pytest.mark.parametrize("external", [None, swirl])
def test_threads_give_the_bits_of_one(external, monkeypatch):
    found = []
    for count in (1, 3):
        cores(monkeypatch, count)
        bend = np.linspace(1e-3, 1e-2, 7)
        shape = {"kind": "writhe", "amplitude": 1.0}
        rods = FreeRods(7, 33, bend=bend, twist=1e-3, moment=1e-3, shape=shape, external=external, device="cpu")
        rods.step(1e-3, 50)
        found.append(rods.variables())
    assert np.ptp(found[0]["energy"]) > 0
    for name, values in found[0].items():
        np.testing.assert_array_equal(found[1][name], values)


def test_steric_sums_in_threads_give_the_bits_of_one(monkeypatch):
    forces = []
    for count in (1, 3):
        cores(monkeypatch, count)
        rods: Rods = walks(np.random.default_rng(6), 11, 17, 0.4, 0.2)
        held = [Held(rods, "cpu")]
        Neighbours(held, **STERIC, device="cpu").apply()
        forces.append(all_forces(held))
    assert np.abs(forces[0]).max() > 0
    np.testing.assert_array_equal(*forces)


@pytest.mark.parametrize(("count", "size", "expected"), [(1, 33, 1), (1000, 33, 3), (10_000, 33, 8), (3, 100_000, 3)])
def test_a_slice_is_worth_a_thread(count, size, expected, monkeypatch):
    monkeypatch.setattr(recorded, "cores", lambda: 8)
    parts = recorded.slices(count, size, "cpu")
    assert len(parts) == expected
    assert [i for part in parts for i in range(part.start, part.stop)] == list(range(count))

"""Rods in tiles: how they are read and set, and that no rod changes the bits of another one in its tile."""

import numpy as np
import pytest
import warp as wp
from examples.contact_steps import take_one

from warp_rods.kernels.lanes import WIDTH, Lanes, Pair
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.slices import slice_array, thread_slices
from warp_rods.rods.status import Status
from warp_rods.rods.tiles import Tiled, tiled, tiles_of

COUNTS = (1, WIDTH - 1, WIDTH, WIDTH + 1, 3 * WIDTH - 1)


@pytest.mark.parametrize("count", [count for count in COUNTS if count])
@pytest.mark.parametrize("dtype", [Lanes, Pair])
def test_values_of_rods_are_read_as_they_were_set(count, dtype):
    field = Tiled(wp.zeros((tiles_of(count), 5), dtype=dtype), count)
    values = np.random.default_rng(count).normal(size=field.shape)
    assert values.shape == ((count, 5) if dtype is Lanes else (count, 5, 2))
    field.assign(values)
    before = field.numpy()
    np.testing.assert_array_equal(before, values)
    field.assign(2.0 * values)
    np.testing.assert_array_equal(before, values)  # a copy, not a view


@pytest.mark.parametrize("count", [1, WIDTH, WIDTH + 1])
def test_numbers_of_rods_are_copied(count):
    field = Tiled(tiled(np.ones(count)), count)
    before = field.numpy()
    field.assign(np.full(count, 2.0))
    np.testing.assert_array_equal(before, 1.0)


def test_lanes_beyond_the_last_rod_repeat_it():
    values = tiled(np.arange(WIDTH + 1.0)).numpy()
    np.testing.assert_array_equal(values[-1], np.full(WIDTH, float(WIDTH)))


def test_slices_of_threads_hold_whole_tiles_and_every_rod_once(monkeypatch):
    monkeypatch.setattr("warp_rods.rods.slices.cores", lambda: 3)
    count = 40 * WIDTH + 1
    slices = thread_slices(count, 10_000, "cpu")
    assert len(slices) == 3 and all(part.start % WIDTH == 0 for part in slices)
    numbers = Tiled(tiled(np.arange(float(count))), count)
    parts = [Tiled(slice_array(numbers.array, part), part.stop - part.start).numpy() for part in slices]
    np.testing.assert_array_equal(np.concatenate(parts), np.arange(count))


def rods(chosen: list[int]) -> FreeRods:
    """Some of eleven rods: planar ones, twisted ones, one that never moves, one that fails at once."""
    moment = np.where(np.arange(11) % 2, 4e-3, 0.0)
    bend = np.geomspace(4e-4, 4e-2, 11)
    shape = np.zeros((11, 33, 3))
    s = np.linspace(-0.5, 0.5, 33)
    shape[:, :, 1] = 3.0 * np.arange(11)[:, None] * np.cos(np.pi * s) ** 2
    shape[4], shape[7] = 0.0, 60.0 * shape[7]
    return FreeRods(len(chosen), 33, bend=bend[chosen], twist=2e-3, moment=moment[chosen], shape=shape[chosen])


def test_a_rod_has_the_same_bits_alone_and_in_any_company():
    def run(chosen: list[int]) -> FreeRods:
        found = rods(chosen)
        found.advance_to(0.02)
        return found

    together, turned = run(list(range(11))), run(list(range(10, -1, -1)))
    assert together.status[7] != Status.OK and (np.delete(together.status, 7) == Status.OK).all()
    for name in ("strain", "position", "tension", "orientation"):
        found = getattr(together, name)
        np.testing.assert_array_equal(np.delete(getattr(turned, name)[::-1], 7, 0), np.delete(found, 7, 0))
    for rod in (0, 3, 4, 10):
        alone = run([rod])
        for name in ("strain", "position", "tension", "orientation"):
            np.testing.assert_array_equal(getattr(alone, name)[0], getattr(together, name)[rod])


def test_company_changes_no_bits_in_contact():
    """Undivided steps under a stiffness that differs from rod to rod, one of which has none, and one that fails."""
    K = np.einsum("r,ij->rij", np.arange(11.0), np.diag([30.0, 10.0, 5.0]) + 2.0)[:, None] * np.ones((1, 33, 1, 1))

    def run(chosen: list[int]) -> FreeRods:
        found = rods(chosen)
        for _ in range(8):
            take_one(found, 1e-6, stiffness=lambda _places: K[chosen])
        return found

    together, turned = run(list(range(11))), run(list(range(10, -1, -1)))
    for name in ("strain", "position", "tension"):
        np.testing.assert_array_equal(getattr(turned, name)[::-1], getattr(together, name))
    for rod in (0, 3, 4, 10):
        alone = run([rod])
        for name in ("strain", "position", "tension"):
            np.testing.assert_array_equal(getattr(alone, name)[0], getattr(together, name)[rod])

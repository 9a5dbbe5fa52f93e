"""Filaments that share a tile of vector instructions: the bits of each depend on itself alone."""

import numpy as np
import pytest
from examples.contact_steps import take_one

from warp_rods.kernels.lanes import WIDTH
from warp_rods.membranes import surfaces
from warp_rods.rods import slices
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.status import Status

COUNT = 2 * WIDTH + 3
"""Two full tiles and one that is not."""
PICKED = (3, WIDTH + 1, COUNT - 1)
"""Filaments that are also run alone, where each is in the first lane."""


def filaments(picked=slice(None), **changed) -> BoundRods:
    """Some of ``COUNT`` filaments on a dumbbell that differ in everything."""
    rng = np.random.default_rng(5)
    places = rng.normal(size=(COUNT, 3))
    rods = {
        "position": places / np.linalg.norm(places, axis=1, keepdims=True),
        "direction": rng.normal(size=(COUNT, 3)),
        "length": rng.uniform(0.5, 0.9, COUNT),
        "stiffness": rng.uniform(0.5, 1.5, (COUNT, 3)),
        "intrinsic": rng.uniform(-1, 1, (COUNT, 3)),
        "geodesic_curvature": rng.uniform(-1, 1, (COUNT, 17)),
        "force": rng.normal(size=(COUNT, 17, 3)),
    } | changed
    given = {name: values[picked] for name, values in rods.items()}
    position, direction, force = (given.pop(name) for name in ("position", "direction", "force"))
    made = BoundRods(
        surfaces.make("cassini", {"a": 1.0, "b": 1.1}), position, direction, nodes=17, **given, device="cpu"
    )
    made.force = force
    return made


def check_equal(one: dict, other: dict, rod: int) -> None:
    """The state and the readings of a rod, and those of it alone."""
    for name, values in other.items():
        if name not in ("clock", "steps"):
            np.testing.assert_array_equal(one[name][rod], values[0], err_msg=name)


def run(rods: BoundRods) -> None:
    """Steps together, then steps of each rod's own."""
    for _ in range(7):
        take_one(rods, 2e-4)
    rods.gather()
    rods.advance_to(0.01)


def test_bits_do_not_depend_on_neighbours_or_lanes():
    together = filaments()
    run(together)
    assert not together.status.any()
    state, values = together.state(), together.variables()
    for rod in PICKED:
        alone = filaments([rod])
        run(alone)
        check_equal(state, alone.state(), rod)
        check_equal(values, alone.variables(), rod)


def test_bits_do_not_depend_on_threads(monkeypatch):
    one = filaments()
    monkeypatch.setattr(slices, "NODES_PER_THREAD", 17)
    monkeypatch.setattr(slices, "cores", lambda: 2)
    two = filaments()
    assert (one.threads, two.threads) == (1, 2)
    for rods in (one, two):
        run(rods)
    for ours, theirs in ((two.state(), one.state()), (two.variables(), one.variables())):
        for name, values in theirs.items():
            np.testing.assert_array_equal(ours[name], values, err_msg=name)


@pytest.mark.parametrize("broken", ["pulled away", "not a number"])
def test_a_neighbour_that_fails_changes_nothing(broken):
    force = np.random.default_rng(6).normal(size=(COUNT, 17, 3))
    healthy = filaments(force=force)
    changed = force.copy()
    changed[[0, WIDTH + 2]] *= 1e7
    failing = filaments(force=changed)
    if broken == "not a number":
        failing._arrays.f.force.assign(np.where(changed == force, force, np.nan))
    for rods in (healthy, failing):
        for _ in range(10):
            take_one(rods, 1e-3)
    frozen = failing.status != Status.OK
    assert frozen.tolist() == [rod in (0, WIDTH + 2) for rod in range(COUNT)]
    for name, values in healthy.state().items():
        if name not in ("clock", "steps", "force", "force_previous"):
            np.testing.assert_array_equal(failing.state()[name][~frozen], values[~frozen], err_msg=name)

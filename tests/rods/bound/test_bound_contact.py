"""Filaments under contact as drag: order, stability in long steps, states at rest, trial steps, restarts."""

from itertools import pairwise

import numpy as np
import pytest
from examples.contact_steps import take_steps, together, try_one
from examples.free import slope

from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.status import Status
from warp_rods.rods.together import exhaust

ZETA = 2.0
NODES = 17
SHIFT = np.array([0.05, 0.03, 0.0])


def on_plane(**given) -> BoundRods:
    plane = surfaces.make("plane", {})
    return BoundRods(plane, [[0.3, 0, 0]], [[1, 0.2, 0]], nodes=NODES, drag=(1.0, ZETA, 0.1), **given)


def on_torus(**given) -> BoundRods:
    torus = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    parameters = {"length": 0.6, "drag": (1.0, ZETA, 0.1), "intrinsic": (0.5, 0.8, 0.0)} | given
    return BoundRods(torus, [[1.3, 0.1, 0.25]], [[0.3, 1.0, 0.4]], nodes=NODES, **parameters)


KINDS = {"plane": on_plane, "torus": on_torus}


def moved(t):
    """A place that moves smoothly, and starts at rest."""
    return np.array([0.1 * np.sin(5 * t) ** 2, 0.05 * np.cos(3 * t) - 0.05, 0.0])


def trap(start, k, place=moved):
    """Springs k from each node to its place at the start, which is carried along; and their stiffness."""
    return lambda t, r: -k * (r - start - place(t)), lambda r: k * np.eye(3)


@pytest.mark.parametrize("divided", [False, True], ids=["as told", "by error"])
@pytest.mark.parametrize("k", [1e2, 1e5])
def test_second_order_with_a_stiff_trap(k, divided, verified):
    """On the torus; from 12 to 100 kΔt/ζ, or below 0.1. The first steps are those of a simulation, or known."""
    counts, runs = np.array([100, 200, 400, 800]), []
    for count in counts:
        rods = on_torus()
        springs = trap(rods.position, k)
        if divided:
            exhaust(together(rods, *springs).advance(0.2 / count, int(count)))
            rods.show()
        else:
            take_steps(rods, 0.2 / count, int(count), *springs)
        runs.append(rods.variables())
    found = [
        slope(counts[:-1], [np.abs(b[name] - a[name]).max() for a, b in pairwise(runs)])
        for name in ("position", "strain", "orientation")
    ]
    verified.order(
        f"filament held by springs of {k:g}, {'divided start' if divided else 'known steps'}: order in Δt",
        measured=found, reference="successive differences of three readings",
    )  # fmt: skip


def test_between_soft_and_stiff_errors_are_not_larger():
    """As steps shorten drag gives way to explicit contact; errors stay below twice those of second order."""
    counts, places = np.array([50, 100, 200, 400, 800, 1600, 6400]), []
    for count in counts:
        rods = on_torus()
        take_steps(rods, 0.2 / count, int(count), *trap(rods.position, 1e4))
        places.append(rods.position)
    errors = np.array([np.abs(r - places[-1]).max() for r in places[:-1]]) * counts[:-1] ** 2
    assert errors.max() < 2 * errors[0], errors


@pytest.mark.parametrize("ratio", [0.5, 5.0, 50.0, 500.0])
def test_a_trap_is_stable_in_long_steps(ratio):
    """kΔt/ζ up to 500. On a plane the rod comes to rest in the trap; without the stiffness it does so below 1 only."""
    k, dt = 1e4, ratio * ZETA / 1e4
    rods = on_plane()
    springs = trap(rods.position, k, lambda t: SHIFT)
    distances = [np.abs(SHIFT).max()]
    for _ in range(4):
        take_steps(rods, dt, 20, *springs)
        distances.append(np.abs(rods.position - on_plane().position - SHIFT).max())
    assert not rods.status.any()
    assert all(after < 0.01 * before + 1e-12 for before, after in pairwise(distances)), distances
    explicit = on_plane()
    take_steps(explicit, dt, 60, springs[0])
    left = np.abs(explicit.position - on_plane().position - SHIFT).max()
    assert (explicit.status[0] != Status.OK or not left < 1.0) == (ratio > 1)


@pytest.mark.parametrize("dt", [1e-3, 1e-1])
def test_the_rod_at_rest_in_a_trap_does_not_depend_on_the_step(dt, verified):
    """On the torus, where it is bent: forces and bending balance."""
    places = []
    for step in (dt, 1e-2):
        rods = on_torus()
        take_steps(rods, step, 200, *trap(rods.position, 1e4, lambda t: SHIFT))
        assert not rods.status.any()
        places.append(rods.position)
    verified.below(
        "independent", f"filament at rest in a trap, Δt = {dt:g}: places", measured=np.abs(places[0] - places[1]).max(),
        bound=1e-7, reference="Δt = 1e-2: no step in the balance",
    )  # fmt: skip


def test_contact_holds_a_filament_and_lets_it_slide(verified):
    """Springs towards a line add no drag along it: a straight rod sinks in by F/k and slides at F/ζ, whatever k."""
    rods = BoundRods(surfaces.make("plane", {}), [[0, 0, 0]], [[1, 0, 0]], nodes=NODES, drag=(1.0, ZETA, 0.1))
    push, normal = np.array([0.3, -1.0, 0.0]), np.array([0.0, 1.0, 0.0])
    springs = lambda t, r: push - 1e4 * r * normal, lambda r: 1e4 * np.diag(normal)
    take_steps(rods, 0.02, 40, *springs)
    before = rods.position[0, 8]
    take_steps(rods, 0.02, 10, *springs)
    slid = rods.position[0, 8] - before - [0.2 * 0.3, 0.0, 0.0]
    verified.below(
        "exact", "filament on springs towards a line: depth and path",
        measured=[np.abs(rods.position[0, :, 1] + 1e-4).max(), np.abs(slid).max()], bound=1e-9,
        reference="F/k across, F∥/ζ∥ along it",
    )  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_a_restart_has_the_same_bits(kind):
    """Also in an ensemble that knew of no contact before."""
    rods, other = KINDS[kind](), KINDS[kind]()
    springs = trap(rods.position, 1e3)
    take_steps(rods, 1e-3, 5, *springs)
    kept = rods.state()
    assert np.abs(kept["contact_velocity"]).max() > 1e-3
    take_steps(rods, 2e-3, 5, *springs)
    _ = other.contact_stiffness_array
    other.restore(kept)
    take_steps(other, 2e-3, 5, *springs)
    for name, values in rods.state().items():
        np.testing.assert_array_equal(other.state()[name], values, err_msg=name)
    np.testing.assert_array_equal(other.position, rods.position)


def test_a_step_that_is_tried_changes_nothing():
    """Rejected, and repeated with another length: the same bits as without it, and one more step counted."""
    plain, other = on_torus(), on_torus()
    springs = trap(plain.position, 100.0)
    for rods in (plain, other):
        take_steps(rods, 1e-3, 3, *springs)
    before = other.state()
    try_one(other, 7e-3, *springs)
    assert other.error_of_step()[0] > 0
    other.reject_step()
    after = other.state()
    for name in before.keys() - {"clock", "pace_rejected", "pace_step", "pace_order"}:
        np.testing.assert_array_equal(after[name], before[name], err_msg=name)
    for rods in (plain, other):
        take_steps(rods, 1e-3, 3, *springs)
    np.testing.assert_array_equal(other.position, plain.position)


def test_readings_are_those_of_the_drag_of_the_rod():
    """Power and dissipation do not contain the drag of contact."""
    plain, other = on_torus(), on_torus()
    springs = trap(plain.position, 0.0)
    for rods in (plain, other):
        take_steps(rods, 1e-3, 3, *springs)
    other.contact_stiffness_array.assign(np.tile(1e4 * np.eye(3), (1, NODES, 1, 1)))
    for name in ("power", "dissipation", "tension"):
        np.testing.assert_array_equal(getattr(other, name), getattr(plain, name), err_msg=name)

"""External forces of free rods that a function gives: readings have no side effects, and force is the present one."""

from itertools import pairwise

import numpy as np
import pytest
import warp as wp
from examples.contact_steps import take_steps, try_one
from examples.free import in_space, slope

from warp_rods.errors import SceneError

STEP = 1e-3
READINGS = ("force", "energy", "orientation", "position", "power", "tension", "position_array", "force_array")


@wp.func
def field(x: wp.vec3d, tangent: wp.vec3d, t: wp.float64):
    return wp.vec3d(wp.float64(0.0), wp.cos(wp.float64(50.0) * t), x[0])


def function(t, x, R):
    return np.stack([0 * x[..., 0], np.full(x.shape[:2], np.cos(50 * t)), x[..., 0]], axis=-1)


@pytest.fixture(params=[field, function], ids=["kernel", "python"])
def make(request, device):
    return lambda **given: in_space(device, nodes=33, count=2, external=request.param, **given)


def expected(rods) -> np.ndarray:
    return function(rods.time, rods.position, None)


@wp.func
def smooth_field(x: wp.vec3d, tangent: wp.vec3d, t: wp.float64):
    three = wp.float64(3.0)
    return wp.vec3d(wp.sin(three * x[1] - t), wp.cos(wp.float64(5.0) * t) - x[1] * x[2], tangent[0] * x[0])


def smooth_function(t, x, R):
    first, second, third = np.moveaxis(x, -1, 0)
    return np.stack([np.sin(3 * second - t), np.cos(5 * t) - second * third, R[..., 0, 0] * first], axis=-1)


def rough_strain(nodes: int) -> np.ndarray:
    """A start with eight random waves in each strain, which relax at rates from 1 to 1e3."""
    s = np.linspace(-0.5, 0.5, nodes)
    rng = np.random.default_rng(4)
    waves = np.cos(np.pi * np.outer(np.arange(8), s) + rng.uniform(0, 6, (8, 1)))
    return ((1 - 4 * s**2) ** 2 * (rng.normal(size=(3, 8)) @ waves)).T


@pytest.mark.parametrize("shape", [None, rough_strain(33)], ids=["smooth", "rough"])
@pytest.mark.parametrize("external", [smooth_field, smooth_function], ids=["kernel", "python"])
def test_second_order_under_a_force_of_place_and_time(device, external, shape, verified):
    given = {} if shape is None else {"shape": shape}
    steps, runs = np.array([200, 400, 800, 1600]), []
    for count in steps:
        rods = in_space(device, 33, external=external, **given)
        rods.step(0.2 / count, int(count))
        runs.append(rods.variables())
    found = [
        slope(steps[:-1], [abs(b[name] - a[name]).max() for a, b in pairwise(runs)])
        for name in ("position", "orientation", "strain")
    ]
    language = "in Python" if external is smooth_function else "as a kernel"
    verified.order(
        f"swimmer under a force {language}, {'smooth' if shape is None else 'rough'} start: order in Δt",
        measured=found, reference="successive differences of three readings",
    )  # fmt: skip


def test_a_function_is_evaluated_at_the_end_of_the_step(device):
    """Once a step, at the time of its end and at the extrapolated places."""
    times, places = [], []

    def push(t, x, R):
        times.append(t)
        places.append(x)
        return np.full_like(x, t)

    rods = in_space(device, 33, external=push)
    take_steps(rods, 0.01, 2)
    before = rods.position
    places.clear(), times.clear()
    try_one(rods, 0.01)
    np.testing.assert_allclose(times, [0.03], rtol=1e-12)
    foretold = places[0]
    rods.accept_step()
    rods.finish_step()
    assert 0 < abs(rods.position - foretold).max() < 0.2 * abs(rods.position - before).max()


def test_readings_have_no_side_effects(make):
    plain, read = make(), make()
    for _ in range(4):
        for name in READINGS:
            before = read.state()
            getattr(read, name)
            after = read.state()
            assert before.keys() == after.keys()
            for key, values in before.items():
                np.testing.assert_array_equal(after[key], values, err_msg=f"{key} after reading {name}")
        plain.step(STEP)
        read.step(STEP)
    read.variables(), read.rates()
    theirs = plain.state()
    for key, values in read.state().items():
        np.testing.assert_array_equal(values, theirs[key], err_msg=key)


def test_the_force_is_that_of_the_present_state(make):
    """Before the first step, after a step, whatever is read before, and after an earlier state is restored."""
    rods = make()
    np.testing.assert_allclose(rods.force, expected(rods), atol=1e-15)
    kept = rods.state()
    rods.step(STEP, 3)
    before = rods.force
    _ = rods.power
    np.testing.assert_array_equal(rods.force, before)
    np.testing.assert_allclose(before, expected(rods), atol=1e-15)
    rods.restore(kept)
    np.testing.assert_allclose(rods.force, expected(rods), atol=1e-15)


def test_a_restored_rod_continues_with_the_same_bits(make):
    rods = make()
    rods.step(STEP, 3)
    kept, other = rods.state(), make()
    rods.step(2 * STEP, 3)
    other.restore(kept)
    other.step(2 * STEP, 3)
    for key, values in rods.state().items():
        np.testing.assert_array_equal(other.state()[key], values, err_msg=key)


def test_the_force_cannot_be_set(make):
    with pytest.raises(SceneError, match="force: it cannot be set, because external gives it at every step"):
        make().force = [0, 0, 1]


def test_a_rod_whose_force_is_not_finite_is_frozen(device):
    def some(t, x, R):
        return np.where(np.arange(2)[:, None, None] == 1, np.nan, 0 * x)

    rods = in_space(device, nodes=33, count=2, external=some)
    rods.step(STEP, 2)
    assert [failure.rod for failure in rods.failures()] == [1]


def test_a_force_of_another_shape_is_refused(device):
    rods = in_space(device, nodes=33, external=lambda t, x, R: x[..., 0])
    with pytest.raises(SceneError, match=r"force: must be one vector, or \(1, 33, 3\)"):
        rods.step(STEP)


def test_stiffnesses_have_the_names_of_trajectories(device):
    rods = in_space(device, nodes=33, count=2, bend=[1e-3, 2e-3])
    np.testing.assert_array_equal(rods.bending_stiffness, rods.static()["bending_stiffness"])
    np.testing.assert_array_equal(rods.twist_stiffness, rods.static()["twist_stiffness"])
    with pytest.raises(AttributeError, match="is fixed"):
        rods.twist_stiffness = 1.0

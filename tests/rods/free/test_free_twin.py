"""Active rods: kernels against their NumPy twin; batches, restarts, failures and impossible parameters."""

import numpy as np
import pytest
from examples.contact_steps import lengths_of_steps, take_steps
from examples.free import in_space
from reference import free as twin

from warp_rods.errors import SceneError
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.status import Status

H = 1 / 64
STEP = 1e-3


def random_ensemble(device, count=3):
    """Rods with different values of every parameter, and rough shapes."""
    rng = np.random.default_rng(1)
    s = np.linspace(-0.5, 0.5, 65)
    strain = rng.normal(size=(count, 65, 3)) + 4 * np.cos(3 * s)[:, None]
    parameters = {
        name: rng.uniform(*range_, size=count)
        for name, range_ in {
            "bend": (5e-4, 2e-3), "twist": (5e-4, 2e-3), "moment": (-1e-2, 1e-2), "drag_ratio": (1.5, 2.5),
            "rotational_drag": (2e-3, 8e-3), "relaxation": (1e-2, 2e-2), "diffusion": (5e-4, 2e-3),
        }.items()
    }  # fmt: skip
    rest = dict(parameters)
    flagella = Flagella(rest.pop("relaxation"), rest.pop("diffusion"))
    strain *= (1 - 4 * s**2)[:, None] ** 2
    rods = FreeRods(count, **rest, flagella=flagella, shape=strain, device=device)
    return rods, twin.Parameters(**{name: values[:, None] for name, values in parameters.items()})


def shape_of(rates):
    return twin.Shape(rates["bending"], rates["twist"], rates["activity"])


def test_rates_agree_with_twin(device, verified):
    rods, p = random_ensemble(device)
    rods.force = np.random.default_rng(2).normal(size=(3, 65, 3))
    found = rods.rates()
    expected = twin.evaluate(shape_of(found), p, H, twin.load_of(np.einsum("rnij,rni->rnj", rods.rotation, rods.force)))
    for name in ("tension", "axial", "transverse"):
        np.testing.assert_allclose(found[name], getattr(expected, name), rtol=0, atol=2e-9, err_msg=name)
    np.testing.assert_allclose(found["angular_velocity"], expected.spin, rtol=0, atol=2e-9)
    errors = []
    for name in ("bending", "twist", "activity"):
        rate = getattr(expected, name)
        errors.append(abs(found[f"{name}_rate"] - rate).max() / abs(rate).max())
    verified.below(
        "independent", "free rods: rates of k, τ, f, relative", measured=errors, bound=1e-12,
        reference="the same equations in NumPy (tests/reference/free.py), random parameters and shapes",
    )  # fmt: skip


def test_steps_agree_with_twin(device, verified):
    """Twenty steps of three lengths; the first is divided, and begins with first order."""
    rods, p = random_ensemble(device)
    shapes, times = [shape_of(rods.rates())], [0.0]
    for dt, steps in ((STEP, 8), (2 * STEP, 6), (STEP, 6)):
        lengths = lengths_of_steps(rods, dt, steps)
        take_steps(rods, dt, steps)
        for length in lengths:
            shapes.insert(0, twin.step(shapes[:2], times[:2], times[0] + length, p, H)[0])
            times.insert(0, times[0] + length)
    found = rods.rates()
    verified.below(
        "independent", "free rods: k, τ, f after twenty steps of three lengths",
        measured=[abs(found[name] - getattr(shapes[0], name)).max() for name in ("bending", "twist", "activity")],
        bound=1e-12, reference="the same steps in NumPy",
    )  # fmt: skip


def test_a_rod_does_not_depend_on_its_batch(device, verified):
    """Steps of the same length give the same bits; where the error of all rods divides the first ones, nearly so."""
    bend = [8e-4, 1e-3, 2e-3]
    batch, divided, found = in_space(device, count=3, bend=bend), in_space(device, count=3, bend=bend), []
    take_steps(batch, STEP, 50)
    batch_after = batch.position
    divided.step(STEP, 50)
    for rod, value in enumerate(bend):
        alone = in_space(device, bend=value)
        take_steps(alone, STEP, 50)
        found.append(alone.position[0])
        alone = in_space(device, bend=value)
        alone.step(STEP, 50)
        np.testing.assert_allclose(alone.position[0], divided.position[rod], rtol=0, atol=1e-6)
    verified.same("free rods: three rods alone and in a batch", np.array(found), batch_after, reference="the batch")
    alone, twins = in_space(device), in_space(device, count=2)
    alone.step(STEP, 50)
    twins.step(STEP, 50)
    np.testing.assert_array_equal(twins.position, np.repeat(alone.position, 2, axis=0))


@pytest.mark.parametrize("forced", [False, True])
def test_restart_gives_the_same_bits(device, forced, verified):
    def external(t, position, rotation):
        return 0.1 * position + t

    options = {"external": external} if forced else {}
    rods, other = in_space(device, **options), in_space(device, **options)
    rods.step(STEP, 30)
    kept = rods.state()
    rods.step(STEP, 30)
    other.restore(kept)
    other.step(STEP, 30)
    forces = "under a force of place and time" if forced else "without forces"
    verified.same(f"free rods {forces}: a restored state", other.variables(), rods.variables(), reference="no stop")
    assert other.time == rods.time


def test_a_failing_rod_is_frozen_and_the_others_continue(device):
    strain = in_space(device).strain
    shapes = np.concatenate([strain, strain, strain])
    rods, fine = in_space(device, count=3, shape=shapes), in_space(device)
    force = np.zeros((3, 65, 3))
    rods.force = force
    take_steps(rods, STEP, 10)
    frozen = rods.position[1]
    force[1, 20] = np.nan
    rods.force_array.assign(force)
    take_steps(rods, STEP, 10)
    take_steps(fine, STEP, 20)
    assert rods.status.tolist() == [0, 1, 0]
    [(rod, time, what)] = rods.failures()
    assert (rod, what) == (1, "became non-finite")
    assert time == pytest.approx(10 * STEP)
    np.testing.assert_array_equal(rods.position[1], frozen)
    np.testing.assert_allclose(rods.position[2], fine.position[0], rtol=0, atol=1e-12)
    assert rods.parameters(1)["bend"] == 1e-3


def test_a_rod_with_too_long_steps_is_frozen_while_its_state_is_valid(device):
    shape = {"kind": "writhe", "amplitude": 6.0}
    rods = FreeRods(2, bend=[8e-5, 5e-3], twist=1e-5, moment=[3e-2, 0.0], shape=shape, device=device)
    take_steps(rods, 5e-3, 600)
    assert rods.status.tolist() == [Status.TOO_BENT, Status.OK]
    assert abs(rods.strain[..., 1:]).max() < np.pi / H
    assert np.isfinite(rods.position).all()


def test_readings_are_copies(device):
    rods = in_space(device)
    before = rods.variables()
    kept = {name: values.copy() for name, values in before.items()}
    rods.step(STEP, 5)
    for name, values in before.items():
        np.testing.assert_array_equal(values, kept[name], err_msg=name)


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"nodes": 64}, "nodes = 64"),
        ({"nodes": 15}, "nodes = 15"),
        ({"bend": -1.0}, "bend = -1"),
        ({"bend": [1e-3, 1e-3]}, "bend"),
        ({"twist": np.nan}, "twist = nan"),
        ({"flagella": {"diffusion": -1e-3}}, "diffusion"),
        ({"symmetric": True, "external": lambda t, x, R: 0 * x}, "symmetric"),
    ],
)
def test_impossible_parameters_are_named(wrong, named):
    given = {"count": 3, "nodes": 65, "bend": 1e-3, "twist": 1e-3, **wrong}
    with pytest.raises(SceneError, match=named):
        FreeRods(given.pop("count"), given.pop("nodes"), **given)

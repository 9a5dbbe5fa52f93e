"""The contract of an ensemble, which every kind of rod fulfils in the same way."""

import numpy as np
import pytest
from examples.contact_steps import take_steps
from examples.free import in_space

from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.ensemble import FORCE_STATE, TELL, Ensemble
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.status import Status

STEP = 1e-3


def free(device, **given) -> Ensemble:
    return in_space(device, count=2, bend=[1e-3, 2e-3], **given)


def bound(device, **given) -> Ensemble:
    torus = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    position, direction = [[1.4, 0, 0], [0, 1.4, 0]], [[0, 1, 0.3], [0, 0.2, 1]]
    return BoundRods(
        torus,
        position,
        direction,
        length=[1.2, 0.9],
        intrinsic=(0.7, 1.0, 0.2),
        drag=(1, 2, 0.3),
        device=device,
        **given,
    )


KINDS = {"free": free, "bound": bound}
FORCE = np.array([0.3, -0.2, 0.1])
READINGS = (
    *("position", "orientation", "strain", "tension", "energy", "energy_density", "dissipation", "power", "status"),
)


@pytest.fixture(params=KINDS)
def make(request, device):
    return lambda **given: KINDS[request.param](device, **given)


def assert_same(ours: dict, theirs: dict) -> None:
    assert ours.keys() == theirs.keys()
    for name, values in theirs.items():
        np.testing.assert_array_equal(ours[name], values, err_msg=name)


def test_setting_a_step_has_no_side_effects(make):
    """Set twice, set to another length first, or set after steps of another length: only the last value counts."""
    plain, changed = make(), make()
    for dt in (STEP, STEP, 2 * STEP, STEP / 2):
        plain.step(dt, 3)
        changed.set_step(7 * dt)
        changed.set_step(dt)
        changed.set_step(dt)
        changed.step(dt, 3)
    assert_same(changed.state(), plain.state())


def test_an_earlier_state_is_restored_completely(make):
    """After a change of the step and of the force."""
    rods = make()
    rods.force = FORCE
    rods.step(STEP, 5)
    kept = rods.state()
    rods.step(STEP, 5)
    expected = rods.state()
    rods.force = 3 * FORCE
    rods.step(3 * STEP, 4)
    rods.restore(kept)
    assert rods.time == pytest.approx(5 * STEP)
    assert_same(rods.state(), kept)
    rods.step(STEP, 5)
    assert_same(rods.state(), expected)


def test_a_state_holds_the_external_force(make):
    """Another ensemble, without a force before, continues from it with the same bits."""
    forced, other = make(), make()
    forced.force = FORCE
    forced.step(STEP, 5)
    other.restore(forced.state())
    np.testing.assert_array_equal(other.force, forced.force)
    forced.step(STEP, 5)
    other.step(STEP, 5)
    assert_same(other.state(), forced.state())


def test_restoring_a_state_without_a_force_removes_the_force(make):
    rods, unforced = make(), make()
    kept = unforced.state()
    rods.force = FORCE
    rods.step(STEP, 2)
    rods.restore(kept)
    assert not rods.force.any()
    rods.step(STEP, 5)
    unforced.step(STEP, 5)
    np.testing.assert_array_equal(rods.position, unforced.position)


def test_reading_the_force_changes_nothing(make):
    plain, read = make(), make()
    for _ in range(3):
        assert not read.force.any()
        _ = read.force_array
        plain.step(STEP, 2)
        read.step(STEP, 2)
    np.testing.assert_array_equal(read.position, plain.position)
    np.testing.assert_array_equal(read.strain, plain.strain)


def test_readings_are_the_variables_of_a_frame(make):
    rods = make()
    rods.force = FORCE
    rods.step(STEP, 3)
    frame = rods.variables()
    for name in READINGS:
        np.testing.assert_array_equal(getattr(rods, name), frame[name], err_msg=name)
    before = rods.state()
    rods.variables()
    assert_same(rods.state(), before)


def test_power_minus_dissipation_is_the_rate_of_energy(make, verified):
    """Under an external force, to second order in the spacing."""
    errors = []
    for nodes in (33, 65, 129):
        rods = make(nodes=nodes)
        rods.force = 20 * FORCE
        rods.step(2e-5, 500)
        energy, rate = [rods.energy], [rods.power - rods.dissipation]
        for _ in range(4):
            rods.step(2e-5, 10)
            energy.append(rods.energy)
            rate.append(rods.power - rods.dissipation)
        slope = (energy[0] - 8 * energy[1] + 8 * energy[3] - energy[4]) / (12 * 2e-4)
        errors.append(np.abs(slope / rods.dissipation - rate[2] / rods.dissipation).max())
    assert np.abs(rods.power).max() > 0.1 * rods.dissipation.max()
    name = f"{type(rods).__name__} under an external force: dE/dt − power + dissipation"
    if isinstance(rods, BoundRods):  # that of free rods is exact in Δs
        orders = -np.polyfit(np.log([32, 64, 128]), np.log(errors), 1)[0]
        verified.order(f"{name}, order in Δs", measured=orders, reference="N = 32, 64, 128")
    verified.below("conservation", f"{name}, relative, N = 128", measured=errors[-1], bound=1e-4, reference="0")


def test_steps_with_a_large_error_are_told_once(make, caplog):
    """After the steps, with the rod of the largest error and what to do; good steps are not told."""
    rods = make()
    rods.step(STEP, 20)
    assert not caplog.messages
    take_steps(rods, 0.3, 1)
    assert not caplog.messages
    rods.step(STEP)
    (record,) = caplog.records
    largest = rods.pace_arrays.largest_error.numpy()
    rod = int(np.argmax(largest))
    assert largest[rod] > TELL * rods.step_tolerance and rods.status[rod] == Status.OK
    assert record.name == "warp_rods" and record.levelname == "WARNING"
    assert f"{rods!r}: by t = {rods.time:g} a step of rod {rod} had an error of {largest[rod]:.2g}" in record.message
    assert "use shorter steps, or let the error choose them" in record.message
    rods.step(0.3)
    assert len(caplog.records) == 1


def test_a_loop_of_steps_that_are_far_too_long_is_told_once(make, caplog):
    rods = make()
    for _ in range(6):
        rods.step(0.5)
    assert (rods.status == Status.OK).any()
    assert len(caplog.messages) == 1 and "a step of rod" in caplog.messages[0]


def test_parameters_are_fixed(make):
    rods = make()
    arrays = [name for name in rods.parameters(0) if isinstance(getattr(rods, name), np.ndarray)]
    assert len(arrays) > 3
    for name in arrays:
        values = getattr(rods, name)
        assert len(values) == rods.count
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 1.0
    for name in (*rods.parameters(0), "count", "device"):
        with pytest.raises(AttributeError, match=f"{name} is fixed"):
            setattr(rods, name, getattr(rods, name))
    with pytest.raises(AttributeError):
        rods.nodes = 17


def test_growth_and_ends_are_fixed(device):
    rods = bound(device, growth={"rate": 1.0, "until": 3.0, "spacing": 0.1}, ends=("clamped", "free"))
    for name in ("growth", "ends", "surface", "largest_spacing"):
        with pytest.raises(AttributeError, match=f"{name} is fixed"):
            setattr(rods, name, getattr(rods, name))
    with pytest.raises(AttributeError):
        rods.clamped = (False, False)
    with pytest.raises(ValueError, match="read-only"):
        rods.growth[1][0] = 2.0
    assert rods.parameters(1)["ends"] == ("clamped", "free")
    assert rods.parameters(1)["growth"]["length"] == [0.9, 3.0]


def test_parameters_of_a_rod_that_is_not_there(make):
    rods = make()
    for wrong in (2, -1, "a", 0.0):
        with pytest.raises(SceneError, match=f"rod = {wrong!r}: must be"):
            rods.parameters(wrong)
    with pytest.raises(SceneError, match=r"name = 'strane': must be one of .* \(did you mean strain\?\)"):
        rods.reading("strane")


@pytest.mark.parametrize("kind", [np.int8, np.int32, np.uint16, np.int64])
def test_any_type_of_whole_number_is_taken(make, kind):
    rods = make(nodes=kind(33))
    rods.step(np.float32(STEP), kind(2))
    rods.set_step(np.array(STEP))
    assert rods.nodes == 33 and type(rods.nodes) is type(rods.count) is int
    np.testing.assert_array_equal(FreeRods(kind(2), kind(17), bend=1e-3, twist=1e-3).position.shape, (2, 17, 3))


@pytest.mark.parametrize(
    ("steps", "said"),
    [
        (("x",), "dt = 'x': must be a number"),
        ((None,), "dt = None: must be a number"),
        (([1e-3],), r"dt = \[0.001\]: must be one number"),
        ((0.0,), "dt = 0: must be positive"),
        ((np.nan,), "dt = nan: must be positive and finite"),
        ((True,), "dt = True: must be a number"),
        ((STEP, 2.5), "steps = 2.5: must be a whole number, 0 or more"),
        ((STEP, "2"), "steps = '2': must be a whole number, 0 or more"),
        ((STEP, -1), "steps = -1: must be a whole number, 0 or more"),
    ],
)
def test_impossible_steps_are_refused(make, steps, said):
    rods = make()
    before = rods.state()
    with pytest.raises(SceneError, match=said):
        rods.step(*steps)
    if len(steps) == 1:
        with pytest.raises(SceneError, match=said):
            rods.set_step(*steps)
    assert_same(rods.state(), before)


@pytest.mark.parametrize(
    ("force", "said"),
    [
        ("up", "force = 'up': must be a number"),
        (None, "force = None: must be a number"),
        ([np.nan, 0, 0], "force = nan: must be finite"),
        ([1.0, 2.0], r"force: must be one vector, or .* \[rod, node, 3\]; has shape \(2,\)"),
    ],
)
def test_impossible_forces_are_refused(make, force, said):
    rods = make()
    rods.force = FORCE
    with pytest.raises(SceneError, match=said):
        rods.force = force
    assert (rods.force == FORCE).all()


def test_a_state_that_does_not_fit_changes_nothing(make):
    rods = make(nodes=33)
    rods.step(STEP, 2)
    before = rods.state()
    some = next(iter(before))
    for wrong, said in (
        ({}, f"state: has no '{some}'; must be a state of {type(rods).__name__}"),
        (None, "state = None: must be a mapping of arrays"),
        ({name: before[name] for name in before if name != "clock"}, "state: has no 'clock'"),
        ({**before, "clock": before["clock"][:2]}, r"state\['clock'\]: has shape \(2,\); must be numbers of .*\(6,\)"),
        ({**before, "steps": before["steps"][:6]}, r"state\['steps'\]: has shape \(6,\); must be numbers of .*\(9,\)"),
        ({**before, "status": before["status"][:1]}, r"state\['status'\]: has shape \(1,\); must be .* \(2,\)"),
        (make(nodes=35).state(), rf"state\['{some}'\]: has shape \(2, 35.*must be numbers of shape \(2, 33"),
        ({**before, "force": np.zeros((2, 33, 3))}, "state: has no 'force_previous'"),
        (
            {**before, **dict.fromkeys(FORCE_STATE, np.zeros((2, 35, 3)))},
            r"state\['force'\]: has shape .* \(2, 33, 3\)",
        ),
    ):
        with pytest.raises(SceneError, match=said):
            rods.restore(wrong)
        assert_same(rods.state(), before)


def test_a_state_of_another_kind_is_refused(device):
    for rods, other in ((free(device), bound(device)), (bound(device), free(device))):
        before = rods.state()
        with pytest.raises(SceneError, match=f"must be a state of {type(rods).__name__}"):
            rods.restore(other.state())
        assert_same(rods.state(), before)


def test_a_rod_that_fails_has_a_status_with_words(make):
    rods = make()
    force = np.zeros((rods.count, rods.nodes, 3))
    force[1, 8] = np.nan
    rods.force_array.assign(force)
    rods.step(STEP, 3)
    assert rods.status.tolist() == [Status.OK, Status.NOT_FINITE]
    [failure] = rods.failures()
    assert (failure.rod, failure.what) == (1, Status.NOT_FINITE.words)
    assert "1 of them frozen" in repr(rods)


def test_readings_of_a_frozen_rod_are_those_of_its_last_shape(make):
    """Those that contain velocities are NaN under a force that is not finite; the other rods are not affected."""
    rods = make()
    force = np.zeros((rods.count, rods.nodes, 3))
    force[1, 8] = np.nan
    rods.force_array.assign(force)
    rods.step(STEP, 3)
    for name in READINGS:
        values = getattr(rods, name)
        assert np.isfinite(values[0]).all()
        assert np.isfinite(values[1]).all() == (name not in ("tension", "dissipation", "power")), name
    rods.force = [0, 0, 0]
    assert all(np.isfinite(getattr(rods, name)).all() for name in READINGS)

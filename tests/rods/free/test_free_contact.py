"""Free rods under forces at the end of a step and contact as drag: twin, stability, order, trial steps, restarts."""

from itertools import pairwise

import numpy as np
import pytest
from examples.contact_steps import lengths_of_steps, take_steps, try_one
from examples.free import in_space, planar, slope
from reference import free as twin
from reference.free_motion import Moving

from warp_rods.errors import SceneError
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.status import Status

H = 1 / 32
STIFFNESS = 1e4
ETA = 2.0


def moved(t):
    """A place that moves smoothly, and starts at rest."""
    return np.array([0.0, 0.1 * np.sin(5 * t) ** 2, 0.05 * np.cos(3 * t) - 0.05])


def tether(start, k, directions=(1.0, 1.0, 1.0)):
    """Springs k from each node to its place at the start, which is carried along; and their stiffness."""
    P = np.diag(directions)
    return lambda t, r: -k * (r - start - moved(t)) @ P, lambda r: k * P


def wall(k, depth=0.3):
    """A floor below y = 0 that pushes up what is in it."""

    def force(t, r):
        return k * np.maximum(-depth - r[..., 1:2], 0.0) * [0.0, 1.0, 0.0]

    def stiffness(r):
        inside = (r[..., 1] < -depth)[..., None, None]
        return inside * k * np.diag([0.0, 1.0, 0.0])

    return force, stiffness


def oblique(r):
    """A stiffness that depends on the place and whose directions are oblique to the rod."""
    n = np.stack([1 + r[..., 1], r[..., 0] - 0.3, np.cos(3 * r[..., 2])], axis=-1)
    return 300 * n[..., :, None] * n[..., None, :] + 100 * np.diag([1.0, 0.5, 0.0])


def shape_of(rods):
    found = rods.rates()
    return twin.Shape(found["bending"], found["twist"], found["activity"])


def test_steps_agree_with_the_twin(device, verified):
    """A force that depends on place and time, and an oblique stiffness; steps of two lengths, the first divided."""

    def force(t, r):
        return np.stack([r[..., 1] - t, np.sin(3 * r[..., 0]), 0.5 - r[..., 2] * r[..., 0]], axis=-1)

    rods = in_space(device, 33, count=2, bend=[1e-3, 2e-3])
    p = twin.Parameters(bend=rods.bend[:, None], twist=rods.twist[:, None], moment=rods.moment[:, None])
    middle = rods.position[:, 16], rods.rotation[:, 16]
    theirs = Moving(shape_of(rods), middle[1], middle[0], p, H)
    for dt, steps in ((1e-2, 4), (4e-3, 3)):
        lengths = lengths_of_steps(rods, dt, steps)
        take_steps(rods, dt, steps, force, oblique)
        for length in lengths:
            t = theirs.times[0] + length
            theirs.step(t, lambda r, t=t: force(t, r), oblique)
    for name in ("bending", "twist", "activity"):
        found, expected = rods.rates()[name], getattr(theirs.shapes[0], name)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9, err_msg=name)
    np.testing.assert_allclose(rods.position[:, 16], np.array(theirs.frames[0])[:, :3, 3], rtol=0, atol=1e-10)
    R, r = theirs.laid_out(theirs.shapes[0], np.array(theirs.frames[0]))
    verified.below(
        "independent", "free rods under contact as drag: places after seven steps",
        measured=abs(rods.position - r).max(), bound=1e-12, reference="the same steps in NumPy, oblique stiffness",
    )  # fmt: skip
    np.testing.assert_allclose(rods.rotation, R, rtol=0, atol=1e-9)


@pytest.mark.parametrize("make", [planar, in_space])
@pytest.mark.parametrize("k", [10.0, 10 * STIFFNESS])
def test_second_order_with_contact(device, make, k, verified):
    """Soft springs, and stiff ones: 5 to 37 times 4/3 ζ⊥/k, the bound of explicit contact."""
    start = make(device, 33).position
    steps, runs = np.array([100, 200, 400, 800]) * (1 if k == 10 else 2), []
    for count in steps:
        rods = make(device, 33)
        take_steps(rods, 0.2 / count, int(count), *tether(start, k))
        runs.append(rods.variables())
    found = [
        slope(steps[:-1], [abs(b[name] - a[name]).max() for a, b in pairwise(runs)])
        for name in ("position", "strain", "orientation")
    ]
    where = "in a plane" if make is planar else "in space"
    verified.order(
        f"swimmer {where} held by springs of {k:g}: order in Δt", measured=found,
        reference="successive differences of three readings",
    )  # fmt: skip


def test_a_stiff_contact_is_stable_in_long_steps(device):
    """Steps 150 times the explicit bound: nodes follow their springs. Without the stiffness the rods are lost."""
    start, dt = in_space(device, 33).position, 0.04
    assert dt > 100 * 4 / 3 * ETA / STIFFNESS
    rods = in_space(device, 33)
    take_steps(rods, dt, 100, *tether(start, STIFFNESS))
    assert rods.status[0] == Status.OK
    assert abs(rods.position - start - moved(rods.time)).max() < 0.02
    explicit = in_space(device, 33)
    take_steps(explicit, dt, 100, tether(start, STIFFNESS)[0])
    assert explicit.status[0] != Status.OK


def test_contact_holds_a_rod_and_lets_it_slide(device, verified):
    """Springs towards a plane add no drag along it: a straight rod sinks in by F/k and slides at F/ζ, whatever k."""
    rods = FreeRods(1, 33, bend=5e-3, twist=1e-3, flagella=None, shape={"kind": "straight"}, device=device)
    push, normal = np.array([0.3, -1.0, 0.4]), np.array([0.0, 1.0, 0.0])

    def force(t, r):
        return push - STIFFNESS * r * normal

    take_steps(rods, 0.02, 40, force, lambda r: STIFFNESS * np.diag(normal))
    before = rods.position[0, 16]
    take_steps(rods, 0.02, 10, force, lambda r: STIFFNESS * np.diag(normal))
    sunk = rods.position[0, :, 1] + 1 / STIFFNESS
    slid = rods.position[0, 16] - before - [0.2 * 0.3, 0.0, 0.2 * 0.4 / ETA]
    verified.below(
        "exact", "free rod on a plane of springs: depth and path", measured=[abs(sunk).max(), abs(slid).max()],
        bound=1e-9, reference="F/k across, F∥/ζ∥ and F⊥/ζ⊥ along it",
    )  # fmt: skip


def test_a_planar_start_stays_in_its_plane(device):
    """Exactly, under forces and contact in the plane."""
    rods = planar(device, 33)
    start = rods.position
    take_steps(rods, 1e-3, 50, *tether(start, 100.0, (1.0, 1.0, 0.0)))
    take_steps(rods, 1e-3, 20, *wall(100.0, 0.0))
    assert not rods.position[..., 2].any()
    assert not rods.strain[..., :2].any()
    assert abs(rods.position - start).max() > 1e-3


# --- a step that is tried -------------------------------------------------------------------------------------------


def test_a_step_that_is_tried_changes_nothing(device):
    """Rejected, and repeated with another length: the same bits as without it, and one more step counted."""
    start = in_space(device, 33).position
    plain, other = in_space(device, 33), in_space(device, 33)
    springs = tether(start, 100.0)
    for rods in (plain, other):
        take_steps(rods, 1e-3, 3, *springs)
    before = other.state()
    try_one(other, 7e-3, *springs)
    assert other.error_of_step()[0] > 0
    other.reject_step()
    after = other.state()
    assert after.pop("pace_rejected") == before.pop("pace_rejected") + 1
    for name in before.keys() - {"force", "clock"}:
        np.testing.assert_array_equal(after[name], before[name], err_msg=name)
    for rods in (plain, other):
        take_steps(rods, 1e-3, 3, *springs)
    np.testing.assert_array_equal(other.position, plain.position)
    assert other.time == plain.time
    assert other.steps_rejected[0] == 1


@pytest.mark.parametrize("make", [planar, in_space])
def test_the_error_of_a_step_is_of_third_order(device, make, verified):
    start = make(device, 33).position
    sizes, errors = np.array([4e-3, 2e-3, 1e-3]), []
    for dt in sizes:
        rods = make(device, 33)
        take_steps(rods, dt, round(0.1 / dt), *tether(start, 10.0))
        try_one(rods, dt, *tether(start, 10.0))
        errors.append(rods.error_of_step()[0])
    where = "in a plane" if make is planar else "in space"
    verified.order(
        f"swimmer {where}: order of the estimated error of a step", measured=slope(1 / sizes, errors), expected=3,
        within=0.3, reference="Δt = 4e-3 to 1e-3",
    )  # fmt: skip


def test_the_error_tells_of_a_force_that_only_moves_the_rod(device, verified):
    """A straight rod under a uniform force that grows: u = t/η, whose error in steps of second order is h³ u''/9."""
    rods = FreeRods(1, 33, bend=5e-3, twist=1e-3, flagella=None, shape={"kind": "straight"}, device=device)

    def force(t, r):
        return t**2 * np.array([0.0, 1.0, 0.0])

    dt = 1e-2
    take_steps(rods, dt, 10, force)
    try_one(rods, dt, force)
    verified(
        "exact", "estimated error of a step under a force t²", measured=rods.error_of_step()[0], expected=dt**3 / 3,
        relative=1e-6, reference="Δt³/3",
    )  # fmt: skip


def test_the_error_of_a_result_that_is_not_valid_is_infinite(device):
    rods = in_space(device, 33, count=2)

    def force(t, r):
        return np.where(np.arange(2)[:, None, None] == 1, np.nan, 0.0 * r)

    take_steps(rods, 1e-3, 2, lambda t, r: 0 * r)
    before = rods.status
    try_one(rods, 1e-3, force)
    assert np.isinf(rods.error_of_step()).tolist() == [False, True]
    np.testing.assert_array_equal(rods.status, before)
    rods.accept_step()
    rods.finish_step()
    assert rods.status.tolist() == [Status.OK, Status.NOT_FINITE]
    assert rods.failures()[0].time == pytest.approx(2e-3)
    try_one(rods, 1e-3, lambda t, r: 0 * r)
    assert rods.error_of_step()[1] == -1  # it is frozen and does not count
    rods.reject_step()
    assert rods.steps_rejected.tolist() == [1, 0]


def test_a_frozen_rod_stays_where_contact_finds_it(device):
    rods = in_space(device, 33, count=2)
    springs = tether(rods.position, 10.0)
    take_steps(rods, 1e-3, 4, *springs)
    take_steps(rods, 1e-3, 1, lambda t, r: np.where(np.arange(2)[:, None, None] == 1, np.nan, 0.0 * r))
    kept = rods.position
    rods.predict_step()
    foretold = rods.position_array.numpy()
    np.testing.assert_array_equal(foretold[1], kept[1])
    assert abs(foretold[0] - kept[0]).max() > 0


def test_show_returns_to_the_present_state(device):
    rods = in_space(device, 33)
    take_steps(rods, 1e-2, 3, lambda t, r: 0 * r)
    kept = rods.position
    try_one(rods, 1e-2, lambda t, r: 0 * r)
    foretold = rods.position_array.numpy().copy()
    rods.show()
    np.testing.assert_array_equal(rods.position_array.numpy(), kept)
    take_steps(rods, 1e-2, 1, lambda t, r: 0 * r)
    assert 0 < abs(rods.position - foretold).max() < 0.2 * abs(foretold - kept).max()


def test_a_restart_has_the_same_bits(device):
    """Also in an ensemble that knew of no contact, and back in time."""
    rods, other = in_space(device, 33), in_space(device, 33)
    springs = tether(rods.position, 1e3)
    plain = rods.state()
    take_steps(rods, 1e-3, 5, *springs)
    kept = rods.state()
    take_steps(rods, 2e-3, 5, *springs)
    other.restore(kept)
    take_steps(other, 2e-3, 5, *springs)
    for name, values in rods.state().items():
        np.testing.assert_array_equal(other.state()[name], values, err_msg=name)
    np.testing.assert_array_equal(other.position, rods.position)
    rods.restore(plain)
    take_steps(rods, 1e-3, 5, *springs)
    for name, values in rods.state().items():
        np.testing.assert_array_equal(values, kept[name], err_msg=name)


def test_readings_are_those_of_the_drag_of_the_rod(device):
    """Power and dissipation do not contain the drag of contact."""
    plain, other = in_space(device, 33), in_space(device, 33)
    springs = tether(plain.position, 0.0)
    take_steps(plain, 1e-3, 1, springs[0])
    _ = other.contact_stiffness_array
    other.restore(plain.state())
    other.contact_stiffness_array.assign(np.tile(1e4 * np.eye(3), (1, 33, 1, 1)))
    for name in ("power", "dissipation", "tension"):
        np.testing.assert_array_equal(getattr(other, name), getattr(plain, name), err_msg=name)


def test_a_state_without_a_part_of_contact_has_none_of_it():
    """Such states were written by versions that kept less; arrays of other shapes are refused."""
    rods = FreeRods(2, 17, bend=1e-2, twist=1e-3)
    state = {**rods.state(), "contact_velocity": np.ones((2, 17, 3))}
    other = FreeRods(2, 17, bend=1e-2, twist=1e-3)
    other.restore(state)
    np.testing.assert_array_equal(other.state()["contact_lag"], 0.0)
    np.testing.assert_array_equal(other.state()["contact_velocity"], 1.0)
    untouched = FreeRods(2, 17, bend=1e-2, twist=1e-3)
    with pytest.raises(SceneError, match=r"state\['contact_velocity'\]: has shape \(2, 3, 3\)"):
        untouched.restore({**state, "contact_velocity": np.ones((2, 3, 3))})
    assert "contact_lag" not in untouched.state()

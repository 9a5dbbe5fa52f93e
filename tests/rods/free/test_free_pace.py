"""Active rods in steps of their own: error against tolerance, the same bits alone, in a batch and after a restart."""

import numpy as np
import pytest

from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.status import Status

BEND = np.array([1e-4, 1e-3, 5e-3])
WRITHE = {"kind": "writhe", "amplitude": 2.0}
KINDS = {
    "planar": {"bend": BEND, "twist": 1e-3, "shape": {"kind": "mode", "amplitude": 2.0}},
    "in space": {"bend": BEND, "twist": BEND, "moment": 5e-3, "shape": WRITHE},
    "stiff in twist": {"bend": BEND, "twist": 100 * BEND, "moment": 5e-3, "shape": WRITHE},
}


def rods(device, rod=slice(None), **parameters):
    given = {name: values[rod] if isinstance(values, np.ndarray) else values for name, values in parameters.items()}
    return FreeRods(len(given["bend"]), 33, device=device, **given)


def to(time, tolerance, made):
    made.advance_to(time, tolerance / made.step_tolerance)
    assert (made.status == Status.OK).all()
    return made


@pytest.mark.parametrize("kind", KINDS)
def test_the_error_follows_the_tolerance(device, kind, verified):
    """Positions after two units of time against a run with a tolerance that is far smaller."""
    exact = to(2.0, 1e-9, rods(device, **KINDS[kind])).position
    tolerances = np.array([1e-4, 1e-5, 1e-6, 1e-7])
    errors = [abs(to(2.0, t, rods(device, **KINDS[kind])).position - exact).max(axis=(1, 2)) for t in tolerances]
    verified.below(
        "independent", f"swimmers {kind}, steps by error: error of places over the tolerance of a step",
        measured=np.array(errors) / tolerances[:, None], bound=300, reference="a run with 1e-9; t = 2, 1e-4 to 1e-7",
    )  # fmt: skip
    assert (np.array(errors)[0] > 10 * np.array(errors)[-1]).all()


@pytest.mark.parametrize("kind", KINDS)
def test_equal_steps_approach_the_same_motion(device, kind, verified):
    """A fixed step of second order against steps by error: the same limit."""
    exact = to(0.5, 1e-9, rods(device, **KINDS[kind])).position
    errors = []
    for steps in (1000, 2000):
        fixed = rods(device, **KINDS[kind])
        fixed.step(0.5 / steps, steps)
        errors.append(abs(fixed.position - exact).max())
    name = f"swimmers {kind}: equal steps against steps by error"
    verified.below(
        "independent", f"{name}, place", measured=errors[1], bound=1e-4, reference="steps by error, 1e-9; Δt = 2.5e-4"
    )
    verified.order(
        f"{name}, order in Δt", measured=np.log2(errors[0] / errors[1]), within=0.25, reference="errors at 5e-4, 2.5e-4"
    )


@pytest.mark.parametrize("bend", [2.5e-4, 1e-3])
@pytest.mark.parametrize("ratio", [100, 1000])
@pytest.mark.parametrize("rotational_drag", [1e-2, 3e-2])
def test_stiffness_in_twist_does_not_shorten_the_steps(device, bend, ratio, rotational_drag):
    """Steps by error: less than thrice those of a rod with equal stiffnesses. Fixed steps are right, too.

    A change of twist moves the rod across, which spreads twist by c |k|²/η; (c/ηr) is less where |k|² ηr > η.
    """

    def rod(twist):
        given = {"bend": bend, "twist": twist, "moment": 2e-2, "rotational_drag": rotational_drag, "shape": WRITHE}
        return FreeRods(1, 65, **given, device=device)

    stiff, soft = to(1.0, 1e-5, rod(ratio * bend)), to(1.0, 1e-5, rod(bend))
    assert stiff.steps_taken[0] < 3 * soft.steps_taken[0]
    assert stiff.steps_rejected[0] < 0.2 * stiff.steps_taken[0]
    exact = to(1.0, 1e-8, rod(ratio * bend)).position
    fixed = rod(ratio * bend)
    fixed.step(1e-3, 1000)
    assert abs(fixed.position - exact).max() < 2e-4
    assert abs(stiff.position - exact).max() < 3e-4


def test_soft_rods_take_more_steps_than_stiff_ones(device):
    made = to(2.0, 1e-6, rods(device, **KINDS["planar"]))
    taken = made.steps_taken
    assert taken[0] > 1.5 * taken[1] > 1.5 * taken[2]
    assert (made.steps_rejected < 0.3 * taken).all()


def test_a_rod_has_the_same_bits_alone_and_in_a_batch(device, verified):
    together = to(0.3, 1e-5, rods(device, **KINDS["in space"]))
    alone = [to(0.3, 1e-5, rods(device, slice(rod, rod + 1), **KINDS["in space"])).position[0] for rod in range(3)]
    name = "swimmers in steps of their own: three rods alone and in a batch"
    verified.same(name, np.array(alone), together.position, reference="the batch")


def test_the_times_that_are_shown_do_not_matter(device, verified):
    """Frames between steps come from the polynomial of the scheme: the steps stay the same, and so do their bits."""
    straight = to(0.5, 1e-5, rods(device, **KINDS["in space"]))
    often, found = rods(device, **KINDS["in space"]), {}
    for time in np.linspace(0, 0.5, 501)[1:]:
        found[round(float(time), 4)] = to(time, 1e-5, often).position
    verified.same(
        "swimmers in steps of their own: shown 500 times", often.position, straight.position, reference="shown once"
    )
    exact = rods(device, **KINDS["in space"])
    for time in (0.05, 0.2, 0.4):
        assert abs(found[time] - to(time, 1e-9, exact).position).max() < 1e-3


def test_a_restart_has_the_same_bits(device, verified):
    straight = rods(device, **KINDS["in space"])
    to(0.2, 1e-5, straight)
    kept = straight.state()
    to(0.4, 1e-5, straight)
    other = rods(device, **KINDS["in space"])
    other.restore(kept)
    to(0.4, 1e-5, other)
    verified.same(
        "swimmers in steps of their own: a restored state", other.variables(), straight.variables(), reference="no stop"
    )


def test_rods_that_cannot_be_resolved_are_frozen(device):
    """Bends beyond half a turn a cell stop a rod however short the steps, and do not stop the others."""
    parameters = {"bend": np.array([2e-6, 5e-3]), "twist": 1e-5, "moment": np.array([0.1, 0.0]), "shape": WRITHE}
    made = rods(device, **parameters)
    made.advance_to(2.0, 1e-4 / made.step_tolerance)
    assert made.status.tolist() == [Status.TOO_BENT, Status.OK]
    assert np.isfinite(made.position).all() and made.failures()[0].time < 2.0

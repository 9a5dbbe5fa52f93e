"""The length of steps that rods take together, from errors that are known."""

import numpy as np
import pytest

from warp_rods.rods.control import GOAL, LENGTHEN_MOST, SAFETY, SHORTEN_INVALID, SHORTEN_MOST, Control

TARGET = 1.0


def controlled(first=1e-3) -> Control:
    return Control(first)


def try_step(control: Control, error: float, move: float = 0.0, reached: float = 0.0) -> bool:
    """A try of the step that was chosen."""
    return control.accepts(control.step, error, move, reached, TARGET)


@pytest.mark.parametrize("exceeded", [{"error": 1.001}, {"error": 8.0}, {"error": 0.5, "move": 1.2}])
def test_a_step_with_too_large_an_error_or_move_is_rejected_and_shortened(exceeded):
    control = controlled()
    assert not try_step(control, **exceeded)
    assert (control.taken, control.rejected) == (0, 1)
    assert SHORTEN_MOST * 1e-3 <= control.step <= SAFETY * 1e-3


def test_the_step_that_follows_a_rejection_has_the_error_allowed():
    """The error of a step of second order grows with its third power, a move with the step."""
    control = controlled()
    try_step(control, error=8.0)
    assert control.step == pytest.approx(1e-3 * SAFETY / 2)
    control = controlled()
    try_step(control, error=1.1, move=2.0)
    assert control.step == pytest.approx(1e-3 * SAFETY / 2)


def test_a_result_that_is_not_valid_is_rejected():
    control = controlled()
    assert not try_step(control, error=np.inf)
    assert control.step == pytest.approx(1e-3 * SHORTEN_INVALID)


@pytest.mark.parametrize("error", [0.0, 1e-30, 1e-3, 0.1])
def test_steps_grow_twofold_at_most(error):
    control, steps = controlled(), []
    for _ in range(10):
        steps.append(control.step)
        assert try_step(control, error)
    ratios = np.divide(steps[1:], steps[:-1])
    assert ratios.max() <= LENGTHEN_MOST == 2 and ratios.min() >= 1
    assert (ratios[0] == LENGTHEN_MOST) == (error < 0.1)


def test_steps_whose_error_is_that_of_a_smooth_motion_converge_and_are_not_rejected():
    """Error (Δt/Δt₀)³: the step settles where the error is GOAL, below what is allowed."""
    control, best = controlled(1e-6), 3e-2
    for _ in range(60):
        assert try_step(control, (control.step / best) ** 3)
    assert control.rejected == 0 and control.taken == 60
    assert control.step == pytest.approx(best * GOAL ** (1 / 3), rel=1e-4)


def test_moves_bound_the_step():
    """Places move by Δt: no step moves a node farther than allowed, and the step approaches the longest such."""
    control = controlled()
    for _ in range(20):
        move = control.step / 0.01
        assert try_step(control, error=1e-9, move=move) and move <= 1
    assert control.step == pytest.approx(SAFETY * 0.01)


@pytest.mark.parametrize("reached", [0.0, 0.7])
def test_the_shortest_step_counts_whatever_its_error(reached):
    """Halved in vain at most to the round-off of the time; then it is taken, and a rod without a result is frozen."""
    control = controlled()
    tries = 0
    while not try_step(control, np.inf, reached=reached):
        tries += 1
        assert tries < 60
    assert control.taken == 1 and control.rejected == tries
    assert control.step > 0
    assert reached == 0 or control.step < 2e-13 * reached


def test_a_shorter_step_than_chosen_does_not_shorten_the_next():
    """The last step before a time that was asked for."""
    control = controlled()
    assert control.accepts(1e-5, 0.5, 0.0, 0.0, TARGET)
    assert control.step == 1e-3


def test_a_control_is_restored_completely():
    control, other = controlled(), controlled(7.0)
    for error in (1e-3, 0.2, 3.0, 0.7, np.inf, 0.4):
        try_step(control, error)
        other.restore(control.state())
        np.testing.assert_array_equal(other.state(), control.state())
        assert try_step(other, 0.6) == try_step(control, 0.6)
        assert other.step == control.step and (other.taken, other.rejected) == (control.taken, control.rejected)

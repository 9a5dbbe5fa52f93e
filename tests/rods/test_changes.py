"""Bounds of steps by error from what is given in time."""

import numpy as np
import pytest

from warp_rods import arguments
from warp_rods.rods.along import Along
from warp_rods.rods.changes import Changes
from warp_rods.rods.outside import Outside


def steps(changes, end, longest=np.inf):
    """The longest steps that changes allow."""
    found, time = [], 0.0
    while time < end:
        found.append(changes.longest_step(time, min(longest, end - time)))
        time += found[-1]
    return np.array(found)


def of_formula(text, end=1.0):
    changes = Changes([Along("a", text, 1, 17, arguments.ANY, in_time=True).sampled])
    changes.foresee(0.0, end)
    return changes


@pytest.mark.parametrize("text", ["3*t", "2 - t/7", "s*t"])
def test_what_changes_evenly_bounds_no_step(text):
    assert steps(of_formula(text), 1.0) == pytest.approx([1.0])


@pytest.mark.parametrize("text", ["sin(2*pi*5*t)", "s + 40*t + 1e-3*sin(2*pi*5*t)", "7*sin(2*pi*(2*s - 5*t))"])
def test_steps_within_a_period(text):
    """(ωh)² ≤ 4π SHARE on average for a sine."""
    found = steps(of_formula(text), 1.0)
    assert 0.2 / 14 < np.median(found) < 0.2 / 5


def test_a_pulse_is_met_whatever_the_step():
    """The whole pulse takes steps of less than its width, at any place along the rod, and in a flow or force."""
    pulse = "exp(-((t - 0.7)/0.001)**2)"
    rods = np.zeros((1, 17, 3))
    flow = Outside({"kind": "formula", "velocity": [0, f"y + {pulse}", 0]}, None, None, 1)
    force = Outside(None, None, [{"force": [0, 0, pulse]}], 1)
    of_space = [Changes(o.sampled(lambda: rods)) for o in (flow, force)]
    for changes in of_space:
        changes.foresee(0.0, 1.0)
    for changes in (of_formula(f"1 + s*{pulse}"), *of_space):
        lengths = steps(changes, 1.0)
        ends = np.cumsum(lengths)
        assert lengths.max() > 0.2  # at rest
        assert (abs(ends - 0.7) < 0.002).sum() > 6


def test_a_step_is_no_longer_than_two_intervals_of_a_table():
    times = np.array([0.0, 2.0, 2.1, 2.2, 4.0])
    found = steps(Changes([], [(times, False)]), 4.0)
    assert found[0] == 2.0 and found[1] == pytest.approx(0.2)
    repeated = steps(Changes([], [(times, True)]), 12.0)
    ends = np.concatenate([[0.0], np.cumsum(repeated)])
    for start, step in zip(ends, repeated, strict=False):
        if start % 4 < 2.2 - 1e-9 and start % 4 > 2 - 1e-9:
            assert step <= 0.2 + 1e-9
    assert len(repeated) < 15

"""Crossings in obvious cases, and against jumps of the Gauss linking integral."""

import numpy as np
import pytest
import xarray as xr
from test_diagnostics import integrate

from warp_rods.analysis.crossings import crossings
from warp_rods.frames import writhe
from warp_rods.rods.free.rods import FreeRods


def group(position, period=None, status=None) -> xr.Dataset:
    """A group with these positions [frame, rod, node, 3] and unit time between frames."""
    position = np.asarray(position, float)
    data = {"position": (("frame", "rod", "node", "axis"), position)}
    if period is not None:
        data["period"] = ("axis", np.array(period, float))
    if status is not None:
        data["status"] = (("frame", "rod"), np.asarray(status))
    return xr.Dataset(data, {"time": ("frame", np.arange(float(len(position))))})


def stick(middle, direction, nodes=9) -> np.ndarray:
    """A straight rod of length 1 [node, 3]."""
    direction = np.asarray(direction, float) / np.linalg.norm(direction)
    return np.asarray(middle, float) + np.linspace(-0.5, 0.5, nodes)[:, None] * direction


def falling(heights, direction=(0.0, 1.0, 0.0), offset=(0.0, 0.0, 0.0), **other) -> xr.Dataset:
    """A rod along ``direction`` at these heights above a fixed rod along x."""
    fixed = stick((0, 0, 0), (1, 0, 0))
    return group([[fixed, stick(np.array([0, 0, z]) + offset, direction)] for z in heights], **other)


def linking(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Gauss linking integral of polygons [time, node, 3], from writhes of polygons that join parts of them.

    The writhe of a chain is a sum over all pairs of its segments; the difference leaves the pairs between both
    polygons.
    """
    joined = writhe(np.concatenate([one, other], axis=1))
    last_and_other = np.concatenate([one[:, -1:], other], axis=1)
    one_and_first = np.concatenate([one, other[:, :1]], axis=1)
    return (
        joined
        - writhe(last_and_other)
        - writhe(one_and_first)
        + writhe(np.concatenate([one[:, -1:], other[:, :1]], axis=1))
    ) / 2


def test_one_crossing_none_and_two():
    through = crossings(falling([0.1, -0.1]))
    assert through.crossings.values.tolist() == [0, 1]
    assert through.event_time.item() == pytest.approx(0.5)
    assert (through.first_rod.item(), through.second_rod.item()) == (0, 1)
    assert crossings(falling([0.1, -0.1], offset=(0.6, 0, 0))).crossings.sum() == 0
    assert crossings(falling([0.1, 0.01])).crossings.sum() == 0
    back = crossings(falling([0.1, -0.1, 0.1]))
    assert back.crossings.values.tolist() == [0, 1, 1]
    assert back.event_sign.sum() == 0 and abs(back.event_sign[0]) == 1


def test_long_segments_cross_near_their_ends():
    """Two rods of one segment each, whose middles are almost a length apart."""
    fixed = stick((0, 0, 0), (1, 0, 0), nodes=2)
    moving = [stick((0.96, 0.048, z), (0.995, 0.0995, 0), nodes=2) for z in (0.01, -0.01)]
    assert crossings(group([[fixed, now] for now in moving])).crossings.values.tolist() == [0, 1]


@pytest.mark.parametrize("direction", [(0, 1, 0), (0.3, 1, 0), (1, 1, 0.2)])
@pytest.mark.parametrize("x", [0.0, 0.125, -0.25, 0.01])
def test_crossings_at_nodes_and_at_frames_count_once(direction, x):
    """Nodes that meet at a frame or between two frames, and rods that stay in contact for a while."""
    for heights in ([0.2, -0.2], [0.1, 0.0, -0.1], [0.1, 0.0, 0.0, 0.0, -0.3]):
        assert crossings(falling(heights, direction, (x, 0, 0))).crossings.sum() == 1, heights
    assert crossings(falling([0.1, 0.0, 0.1], direction, (x, 0, 0))).crossings.sum() in (0, 2)


def test_a_node_crosses_between_many_frames():
    heights = np.linspace(0.5, -0.5, 101) + 1e-17
    assert crossings(falling(heights, (0.5, 1, 0.1))).crossings.sum() == 1


def test_a_rod_passes_through_itself():
    """A loop whose upper strand sinks through the lower one: the writhe falls by two."""
    angle = np.linspace(-0.3, 2 * np.pi + 0.3, 41)
    ring = np.stack([np.cos(angle), np.sin(angle), 0.1 * np.sin(angle / 2 - np.pi / 2)], axis=-1)
    tails = 1 + 0.8 * np.maximum(np.abs(angle - np.pi) - np.pi + 0.3, 0)
    loop = ring * np.stack([tails, np.ones(41), np.ones(41)], axis=-1)
    frames = [loop * [1, 1, height] for height in (1.0, 0.4, -0.4, -1.0)]
    found = crossings(group([[frame] for frame in frames]))
    assert found.crossings.values.tolist() == [0, 0, 1, 0]
    assert (found.first_rod.item(), found.second_rod.item()) == (0, 0)
    jump = writhe(frames[2]) - writhe(frames[1])
    assert np.sign(jump) == found.event_sign.item() and 1 < abs(jump) < 2


def test_crossings_through_a_periodic_boundary():
    """Rods at opposite sides of the box and in distant images; no crossing in open space."""
    fixed, moving = stick((0.02, 0, 0), (0, 1, 0)), [stick((9.93 + shift, 0, 0), (0, 0, 1)) for shift in (0, 0.2)]
    frames = np.array([[fixed + np.array([30, 0, 0]), now] for now in moving])
    assert crossings(group(frames, period=(10, np.inf, 10))).crossings.sum() == 1
    assert crossings(group(frames, period=(10, 10, 10))).event_time.item() == pytest.approx(0.45)
    assert crossings(group(frames)).crossings.sum() == 0
    with pytest.raises(ValueError, match="half the period"):
        crossings(group(frames, period=(0.4, 10, 10)))


def test_frames_too_far_apart_are_named_with_the_remedy():
    """A rod that moves by most of the period between two frames."""
    frames = np.array([[stick((x, 0, 0), (0, 1, 0))] for x in (0.0, 6.0)])
    with pytest.raises(ValueError, match=r"crossings: a segment and .* save frames more often \(time.save_every"):
        crossings(group(frames, period=(10, 10, 10)))


def test_a_rod_crosses_its_own_image():
    """A rod as long as the box is wide."""
    rod = np.array([stick((0, 0, 0), (1, 0, 0)), stick((0, 0, 0), (1, 0, 0))])
    rod[:, -2:] += [[[0.3, 0.1, 0], [0.1, 0.2, 0.2]], [[0.3, 0.1, 0], [0.1, 0.2, -0.2]]]
    frames = rod[:, None]
    images = np.concatenate([frames, frames + np.array([0.9, 0, 0])], axis=1)
    number = (crossings(group(images)).first_rod != crossings(group(images)).second_rod).sum()
    itself = crossings(group(frames)).crossings.sum()
    assert crossings(group(frames, period=(0.9, np.inf, np.inf))).crossings.sum() == number + itself


def test_crossings_in_a_plane():
    """A rod that sweeps over another crosses it once while they overlap; so does a rod with itself."""
    fixed = stick((0, 0, 0), (1, 0, 0))

    def sweep(ys, direction):
        return crossings(group([[fixed, stick((0.03, y, 0), direction)] for y in ys])).crossings.values.tolist()

    for direction in ((0, 1, 0), (1, 1, 0), (1, 0.1, 0), (1, 0, 0)):
        assert sweep([0.8, -0.8], direction) == [0, 1], direction
        assert sweep([0.8, 0.7, 0.6], direction) == [0, 0, 0], direction
        assert sweep([0.8, -0.8, 0.8], direction) == [0, 1, 1], direction
    assert sweep([0.6, 0.4, 0.2, 0.0, -0.4, -0.6], (0, 1, 0)) == [0, 1, 0, 0, 0, 0]
    assert sweep([0.0, 0.1], (0, 1, 0)) == [0, 0]
    head_on = [[fixed, stick((1.2 - t, 0, 0), (1, 0, 0))] for t in (0.0, 0.5, 0.6)]
    assert crossings(group(head_on)).crossings.values.tolist() == [0, 1, 0]
    hook = np.array([[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0.5, 1, 0], [0.5, y, 0]] for y in (0.3, 0.1, -0.3, -0.4)])
    assert crossings(group(hook[:, None])).crossings.values.tolist() == [0, 0, 1, 0]


def test_crossings_in_a_moving_plane():
    """A planar sweep in a tilted plane that moves along its normal, with stretching in the plane."""
    tilt = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    fixed = stick((0, 0, 0), (1, 0, 0))
    for ys, number in (([0.7, -0.7], 1), ([0.9, 0.6], 0), ([0.1, -0.1], 0)):
        frames = np.array([[fixed * (1 + 0.1 * i), stick((0.03, y, 0), (0.2, 1, 0))] for i, y in enumerate(ys)])
        drift = np.array([0.0, 0.3])[:, None, None, None] * np.array([0.2, 0.1, 1.0])
        assert crossings(group((frames + drift) @ tilt)).crossings.sum() == number


def test_rods_just_outside_the_plane_do_not_cross():
    tilt = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    frames = [[stick((0, 0, 0), (1, 0, 0)), stick((0.03, y, 1e-5), (1, 1, 0))] for y in (0.8, -0.8)]
    assert crossings(group(np.array(frames) @ tilt)).crossings.sum() == 0


def test_failed_rods_are_left_out():
    assert crossings(falling([0.1, -0.1], status=[[0, 0], [1, 0]])).crossings.sum() == 0
    frames = falling([0.1, -0.1]).position.values
    more = group(np.concatenate([frames[:, :1] + 5, frames], axis=1), status=[[0, 0, 0], [3, 0, 0]])
    assert (crossings(more).first_rod.item(), crossings(more).second_rod.item()) == (1, 2)


def test_random_motion_against_the_linking_integral(verified):
    """Numbers, times and signs of the jumps of the linking integral, and of the writhe of each rod."""
    counts = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        start, end = rng.normal(size=(2, 2, 7, 3)) + np.arange(7)[:, None] * [0.3, 0, 0]
        t = np.linspace(0, 1, 4001)[:, None, None, None]
        fine = start + t * (end - start)
        found = crossings(group([start, end]))
        pair = found.first_rod.values * 2 + found.second_rod.values
        integrals = {1: linking(fine[:, 0], fine[:, 1]), 0: writhe(fine[:, 0]) / 2, 3: writhe(fine[:, 1]) / 2}
        for which, integral in integrals.items():
            steps = np.diff(integral)
            jumps = np.flatnonzero(np.abs(steps) > 0.5)
            assert np.all(np.sort(np.abs(steps))[: len(steps) - len(jumps)] < 0.2)
            these = pair == which
            assert these.sum() == len(jumps)
            np.testing.assert_allclose(found.event_time[these], t[jumps, 0, 0, 0] + 1.25e-4, rtol=0, atol=1.3e-4)
            np.testing.assert_array_equal(found.event_sign[these], np.sign(steps[jumps]))
        assert len(pair) >= 6
        counts.append((len(pair), sum(int((np.abs(np.diff(one)) > 0.5).sum()) for one in integrals.values())))
    measured, expected = np.transpose(counts)
    verified(
        "independent", "crossings of rods that move at random, six times", measured=measured,
        expected=expected, within=0,
        reference="jumps of Gauss' linking integral and of the writhe at 4000 times",
    )  # fmt: skip


def random_motion(rng, rods, box, flat) -> np.ndarray:
    """Seven frames [frame, rod, node, 3] of rods that move and bend at random."""
    direction = rng.normal(size=(rods, 3)) * [1, 1, not flat]
    start = np.array([stick(at, p) for at, p in zip(rng.uniform(0, box, (rods, 3)), direction, strict=True)])
    steps = rng.normal(0, 0.03, (6, rods, 9, 3)) + rng.normal(0, 0.1, (6, rods, 1, 3))
    return np.concatenate([start[None], start + steps.cumsum(axis=0)]) * [1, 1, not flat]


def test_additional_frames_change_nothing():
    """A dense periodic swarm, and the same motion with three times as many frames."""
    frames = random_motion(np.random.default_rng(12), 40, 2.0, False)
    share = np.array([0.0, 0.3, 0.7])[:, None, None, None]
    fine = [frames[k] + share * (frames[k + 1] - frames[k]) for k in range(6)]
    coarse = crossings(group(frames, (2, 2, 2)))
    often = crossings(group(np.concatenate([*fine, frames[-1:]]), (2, 2, 2)))
    assert coarse.crossings.sum() > 50
    np.testing.assert_array_equal(often.crossings[1:].values.reshape(6, 3).sum(axis=1), coarse.crossings[1:])
    np.testing.assert_array_equal(often.event_sign, coarse.event_sign)
    np.testing.assert_array_equal(often.first_rod, coarse.first_rod)


def overlap(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Whether planar polygons [time, node, 2] intersect [time], from all pairs of their segments."""
    p, q = one[:, :-1, None], other[:, None, :-1]
    a, b, w = np.diff(one, axis=1)[:, :, None], np.diff(other, axis=1)[:, None], q - p

    def cross(v, u):
        return v[..., 0] * u[..., 1] - v[..., 1] * u[..., 0]

    u, v = cross(w, b) / cross(a, b), cross(w, a) / cross(a, b)
    return ((u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)).any(axis=(1, 2))


def test_planar_swarm_against_many_times():
    """Pairs of rods that do not overlap at one frame but do at one of many times until the next."""
    frames = random_motion(np.random.default_rng(13), 20, 4.0, True)
    found = crossings(group(frames))
    two = found.event_time[found.first_rod != found.second_rod]
    expected = np.zeros(6, int)
    t = np.linspace(0, 1, 301)[:, None, None, None]
    for k in range(6):
        fine = (frames[k] + t * (frames[k + 1] - frames[k]))[..., :2]
        pairs = [overlap(fine[:, i], fine[:, j]) for i in range(20) for j in range(i + 1, 20)]
        expected[k] = sum(not now[0] and now.any() for now in pairs)
    assert expected.sum() > 8
    np.testing.assert_array_equal(np.bincount(np.ceil(two).astype(int) - 1, minlength=6), expected)
    assert len(two) < found.crossings.sum()  # some rods pass through themselves


@pytest.mark.parametrize("turn", [np.eye(3), [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]], ids=["in their plane", "across"])
def test_swimmers_that_meet(device, turn):
    """Two U-swimmers without sterics pass through each other once, in one plane or in perpendicular planes."""
    rotation = [np.eye(3), np.array(turn) @ np.diag([-1, -1, 1])]
    bow, at = {"kind": "mode", "mode": 0, "amplitude": 3.0}, [[0, 0.5, 0], [0.1, -0.5, 0]]
    rods = FreeRods(2, 33, bend=5e-3, twist=1e-3, shape=bow, position=at, rotation=rotation, device=device)
    data = integrate(rods, 2.0, 0.1, dt=2e-3)
    assert data.position.values[-1, 0, 16, 1] < -0.2 < 0.2 < data.position.values[-1, 1, 16, 1]
    assert crossings(data).crossings.sum() == 1

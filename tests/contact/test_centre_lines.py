"""Centre lines in the cells of a grid against all pairs of segments: which touch, which fit, how they are pushed."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.contact.test_arrangements import distance_of_segments
from warp_rods.contact import segments
from warp_rods.contact.overlap import overlapping
from warp_rods.contact.push import pushed_apart
from warp_rods.contact.rotations import about_z, isotropic
from warp_rods.contact.segments import CentreLines, OccupiedSpace

PERIODS = {
    "none": (0.0, 0.0, 0.0),
    "slab": (1.3, 1.1, 0.0),
    "box": (1.3, 1.1, 1.2),
    "narrow": (1.3, 0.5, 0.25),  # one and two cells along an axis
}


def scattered(count: int, nodes: int, rng: np.random.Generator) -> np.ndarray:
    """Curved lines [rod, node, 3] of different lengths, some of them far outside the box."""
    steps = rng.normal(size=(count, nodes, 3)) * rng.uniform(0.01, 0.1, size=(count, 1, 1))
    steps[:, 0] = rng.uniform(-0.5, 0.5, size=(count, 3))
    steps[: count // 8, 0] += [8.0, -30.0, 17.5]
    return np.cumsum(steps, axis=1)


def distances(lines: list[np.ndarray], period: np.ndarray) -> np.ndarray:
    """The smallest distances [rod, rod] of centre lines [node, 3], of nearest images of the middles of segments."""
    p = np.concatenate([x[:1] if len(x) == 1 else x[:-1] for x in lines])
    a = np.concatenate([0 * x if len(x) == 1 else np.diff(x, axis=0) for x in lines])
    a[(a == 0).all(axis=1)] = 1e-100  # a point is a very short segment
    rod = np.repeat(np.arange(len(lines)), [max(len(x) - 1, 1) for x in lines])
    apart = (p + a / 2)[:, None] - (p + a / 2)
    image = np.where(period > 0, period * np.rint(apart / np.where(period > 0, period, 1.0)), 0.0)
    with np.errstate(all="ignore"):
        d = distance_of_segments(p[:, None] - image, a[:, None], p, a)
    found = np.full((len(lines), len(lines)), np.inf)
    np.minimum.at(found, (rod[:, None], rod), np.where(np.isfinite(d), d, np.inf))
    np.fill_diagonal(found, np.inf)
    return found


@pytest.mark.parametrize("period", PERIODS.values(), ids=PERIODS)
@pytest.mark.parametrize("clearance", [0.03, 0.06])
def test_pairs_that_touch_and_lines_that_fit_are_those_of_all_pairs(period, clearance):
    rng, period = np.random.default_rng(7), np.array(period)
    others = [scattered(10, 9, rng), scattered(12, 1, rng)]
    lines = scattered(60, 5, rng)
    lines[3, 2] = np.nan  # segments that are not finite touch nothing
    rows = [line for part in (*others, lines) for line in part]
    touch = distances(rows, period) < clearance
    assert touch.sum() > 20
    assert overlapping([*others, lines], clearance, period) == touch.sum() / 2

    taken, expected = list(range(22)), []
    for rod in range(22, len(rows)):
        fits = not touch[rod, taken].any()
        expected.append(fits)
        taken += [rod] if fits else []
    placed = CentreLines(OccupiedSpace(others, period), clearance, 60, 5)
    parts = [placed.those_that_fit(lines[:25])]
    assert (placed.those_that_fit(lines[:25]) == parts[0]).all()  # it has left nothing behind
    placed.add(lines[:25][parts[0]])
    parts.append(placed.those_that_fit(lines[25:]))
    assert np.concatenate(parts).tolist() == expected and 3 < sum(expected) < 60


def test_longer_segments_than_before_are_found():
    placed = CentreLines(OccupiedSpace([], np.zeros(3)), 0.1, 3, 2)
    placed.add(np.array([[[0, 0, 0], [0.01, 0, 0]]]))
    long = np.array([[[-5.0, 0.05, 0], [5.0, 0.05, 0]]])
    assert not placed.those_that_fit(long)[0]
    placed.add(long + np.array([0.0, 1.0, 0.0]))
    for y, fits in ((0.0, True), (1.0, False)):
        assert placed.those_that_fit(np.array([[[4, y, 0], [4.01, y, 0]]])).tolist() == [fits]


def test_cells_repeat_where_there_would_be_too_many(monkeypatch):
    monkeypatch.setattr(segments, "FEW_CELLS", 30)
    monkeypatch.setattr(segments, "CELLS_PER_SEGMENT", 0)
    for period in PERIODS.values():
        test_pairs_that_touch_and_lines_that_fit_are_those_of_all_pairs(period, 0.05)


def nearest_by_search(d: np.ndarray, a: np.ndarray, b: np.ndarray) -> tuple[float, float]:
    """Places x, y in [0, 1] where d + x a − y b is shortest, on ever finer grids."""
    x = y = width = 0.5
    for _ in range(12):
        u, v = (np.clip(np.linspace(c - width, c + width, 21), 0, 1) for c in (x, y))
        r = np.linalg.norm(d + u[:, None, None] * a - v[:, None] * b, axis=-1)
        i, j = np.unravel_index(np.argmin(r), r.shape)
        x, y, width = u[i], v[j], width / 4
    return x, y


def round_of_pushes(position, rotation, shapes, clearance, period, apart):
    """Every pair of rods pushed once, segment by segment, from the formulas."""
    lines = position[:, None] + np.einsum("rij,rnj->rni", rotation, shapes)
    rods, size = len(lines), 12 / np.linalg.norm(np.diff(shapes, axis=1), axis=-1).sum(axis=1) ** 2
    shift, turn, pushes = np.zeros((rods, 3)), np.zeros((rods, 3)), np.zeros(rods)
    starts = [(rod, line[k], line[k + 1]) for rod, line in enumerate(lines) for k in range(len(line) - 1)]
    for (i, p, p_end), (j, q, q_end) in itertools.combinations(starts, 2):
        middle = (p + p_end - q - q_end) / 2
        d = p - q - period * np.rint(middle / period)
        x, y = nearest_by_search(d, p_end - p, q_end - q)
        gap = d + x * (p_end - p) - y * (q_end - q)
        if i == j or (r := np.linalg.norm(gap)) >= clearance:
            continue
        push = (apart - r) / 2 * gap / r
        for rod, at, by in ((i, p + x * (p_end - p), push), (j, q + y * (q_end - q), -push)):
            arm = at - position[rod]
            share = by / (1 + size[rod] * arm @ arm)
            shift[rod] += share
            turn[rod] += size[rod] * np.cross(arm, share)
            pushes[rod] += 1
    each = 1 / np.maximum(pushes, 1)[:, None]
    return position + each * shift, Rotation.from_rotvec(each * turn).as_matrix() @ rotation, pushes


def test_a_round_of_pushes_is_that_of_the_formulas(monkeypatch):
    """Two rods that cross and touch a third through a face of the box, and one far away that stays."""
    shapes = np.zeros((4, 4, 3))
    shapes[..., 0] = np.linspace(-0.5, 0.5, 4)
    position = np.array([[0.0, 0, 0], [0.1, 0.03, 0.06], [0.2, -1.45, 0.02], [5.0, 0.7, 0.7]])
    rotation = Rotation.from_rotvec([[0, 0, 0], [0.2, 0.1, 1.2], [0, 0.05, 0.08], [0, 0, 1.0]]).as_matrix()
    period, clearance = np.array([20.0, 1.5, 20.0]), 0.1
    expected = round_of_pushes(position, rotation, shapes, clearance, period, 1.01 * clearance)
    assert (expected[2][:3] > 0).all() and expected[2][3] == 0
    rounds = []
    monkeypatch.setattr("warp_rods.contact.push.MOST_PUSHES", 1)
    original = segments.launch

    def kept(kernel, *inputs):
        original(kernel, *inputs)
        if kernel.key == "move_rods":
            rounds.append(tuple(a.numpy().copy() for a in (inputs[0].position, inputs[0].rotation, inputs[0].moved)))

    monkeypatch.setattr("warp_rods.contact.push.launch", kept)
    assert pushed_apart(position, rotation, shapes, clearance, OccupiedSpace([], period)) is None
    ((moved_to, turned_to, moved),) = rounds
    np.testing.assert_allclose(moved_to, expected[0], rtol=0, atol=1e-8)
    np.testing.assert_allclose(turned_to, expected[1], rtol=0, atol=1e-8)
    assert moved.tolist() == [1, 1, 1, 0]


def test_rods_that_are_pushed_keep_clear_of_those_that_stay():
    """Rods that were not moved are not looked at again, whatever comes near them: all pairs tell."""
    rng, period = np.random.default_rng(3), np.array([3.0, 3.0, 3.0])
    shapes = np.zeros((40, 9, 3))
    shapes[..., 0] = np.linspace(-0.5, 0.5, 9)
    others = rng.uniform(-1.5, 1.5, size=(300, 1, 3))
    placed = pushed_apart(
        rng.uniform(-1.5, 1.5, size=(40, 3)), isotropic(40, rng), shapes, 0.08, OccupiedSpace([others], period)
    )
    assert placed is not None
    lines = placed[0][:, None] + np.einsum("rij,rnj->rni", placed[1], shapes)
    d = distances([*others, *lines], period)
    assert d[300:].min() >= 0.08 * (1 - 1e-12) > d[:300, :300].min()


def test_frames_have_the_bits_of_scipy():
    one, other = (np.random.default_rng(1) for _ in range(2))
    assert isotropic(200, one).tobytes() == Rotation.random(200, rng=other).as_matrix().tobytes()
    angle = one.uniform(-10, 10, 200)
    np.testing.assert_allclose(about_z(angle), Rotation.from_euler("z", angle[:, None]).as_matrix(), rtol=0, atol=1e-15)

"""Correlations and density of swarms in boxes of all kinds, against ideal gases, lattices and counting."""

import numpy as np
import pytest
from examples.swarm import group, isotropic, scattered

from warp_rods.analysis.swarm.data import minimum_image, pairs_within, space, wrapped
from warp_rods.analysis.swarm.motion import mean_square_displacement, speed_distribution
from warp_rods.analysis.swarm.space import density_map, pair_correlation, velocity_correlation
from warp_rods.draw.labels import label

OPEN = (np.inf, np.inf, np.inf)
BOXES = {
    "periodic": ((6.0, 7.0, 8.0), (6.0, 7.0, 8.0), 3),
    "open": ((6.0, 7.0, 8.0), OPEN, 3),
    "mixed": ((6.0, 7.0, 8.0), (6.0, np.inf, 8.0), 3),
    "periodic plane": ((16.0, 9.0, 0.1), (16.0, 9.0, np.inf), 2),
    "open plane": ((16.0, 9.0, 0.0), OPEN, 2),
    "strip": ((16.0, 9.0, 0.0), (16.0, np.inf, np.inf), 2),
}


@pytest.mark.parametrize("box, period, dimensions", BOXES.values(), ids=BOXES)
def test_an_ideal_gas_has_no_correlations(box, period, dimensions):
    """g = 1 in every bin within 4.5 standard errors; uncorrelated velocities have C_v = 0."""
    rng, frames, rods = np.random.default_rng(6), 40, 300
    middle = scattered(rng, frames, rods, box)
    found = pair_correlation(group(middle, period=period, length=0.9), bins=20)
    assert found.r[-1] > 2
    ideal = found.expected.sum("frame")
    excess = ((found * found.expected).sum("frame") / ideal - 1) * np.sqrt(ideal)
    assert np.abs(excess).max() < 4.5
    share = (found * found.expected).sum("r") / found.expected.sum(
        "r"
    ) - 1  # frames are independent, which gives the error
    assert np.abs(share.mean()) < 3.5 * share.std() / np.sqrt(frames)
    assert share.std() < 0.05
    assert found.sizes == {"frame": frames, "r": 20}
    v = rng.normal(size=(1, rods, 3)) * (np.asarray(box) > 0.2)
    moving = group(middle[:1] + 1e-6 * np.arange(3)[:, None, None] * v, period=period, length=0.9)
    assert np.abs(velocity_correlation(moving, bins=4)).max() < 0.1


def test_a_cubic_lattice_has_its_neighbours():
    """6, 12, 8, 6 neighbours at the distances 1, √2, √3, 2, and none in between."""
    grid = np.stack(np.meshgrid(*[np.arange(6.0)] * 3, indexing="ij"), axis=-1).reshape(1, -1, 3)
    far = group(grid + 6 * np.random.default_rng(7).integers(-3, 4, (1, 216, 3)), period=(6, 6, 6))
    found = pair_correlation(far, reach=2.1, bins=21)
    pairs = (found * found.expected)[0].to_numpy()
    expected = np.zeros(21)
    for distance, neighbours in ((1.0, 6), (np.sqrt(2), 12), (np.sqrt(3), 8), (2.0, 6)):
        expected[int(distance / 0.1 + 1e-9)] = 216 * neighbours / 2
    np.testing.assert_allclose(pairs, expected)


def test_reach_has_bounds():
    data = group(scattered(np.random.default_rng(8), 3, 30, (6, 6, 6)), period=(6, 6, 6))
    with pytest.raises(ValueError, match="half the shortest side"):
        pair_correlation(data, reach=3.1)
    with pytest.raises(ValueError, match="all at one place"):
        pair_correlation(group(np.zeros((1, 2, 3))), dimensions=3)
    with pytest.raises(ValueError, match="dimensions = 4"):
        pair_correlation(data, dimensions=4)


def test_velocity_correlation_of_a_drift_and_of_a_rotation():
    """C_v = 1 for a drift. In a ring in rigid rotation v_i·v_j is exactly the cosine of the angle between points."""
    drift = group(scattered(np.random.default_rng(9), 1, 50, (5, 5, 5)) + np.arange(4.0)[:, None, None] * [0.1, 0, 0])
    found = velocity_correlation(drift)
    np.testing.assert_allclose(found.values[found.notnull()], 1)
    number = 24
    angle = 2 * np.pi * np.arange(number) / number + 1e-3 * np.arange(5)[:, None]
    ring = group(3 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1))
    found = velocity_correlation(ring, reach=3.0, bins=100)
    for apart in (1, 2, 3):
        between = 2 * np.pi * apart / number
        bin_of = int(2 * 3 * np.sin(between / 2) / 0.03)
        np.testing.assert_allclose(found[:, bin_of], np.cos(between), rtol=1e-9)
    assert found.notnull()[2].sum() == 4  # the fourth: neighbours at 60°, at a distance of exactly 3.0


@pytest.mark.parametrize("box, period, dimensions", BOXES.values(), ids=BOXES)
def test_density_sums_to_the_number_of_rods(box, period, dimensions):
    """The sum over the cells times their size."""
    rng = np.random.default_rng(10)
    data = group(scattered(rng, 3, 20, box) * 3 - 5, isotropic(rng, 3, 20, flat=dimensions == 2), period=period)
    found = density_map(data, dimensions=dimensions)
    assert found.ndim == dimensions + 1
    size = np.prod([float(found[name][1] - found[name][0]) for name in found.dims[1:]])
    np.testing.assert_allclose(found.sum(found.dims[1:]) * size, 20)
    assert found.attrs["units"] == f"1/length^{dimensions}"


def test_density_is_in_the_cells_of_the_nodes():
    """A node on an edge belongs to the cell above, wrapped at the period; the box is centred on the origin."""
    data = group([[[-2.0, -2.0, 0], [2.0, -2.0, 0]]], period=(5, 5, np.inf), nodes=3)
    found = density_map(data, cell=1.0)[0]
    expected = np.zeros((5, 5))
    for x, share in ((0.0, 0.25), (0.5, 0.5), (1.0, 0.25), (4.0, 0.25), (4.5, 0.5), (5.0, 0.25)):
        expected[int(x % 5), 0] += share
    np.testing.assert_allclose(found, expected)
    assert found.x.values.tolist() == [-2.0, -1.0, 0.0, 1.0, 2.0]


@pytest.mark.parametrize("period", [(3.0, 4.0, 5.0), (3.0, np.inf, 5.0), OPEN])
def test_pairs_against_a_search_over_all_pairs(period):
    """Points far outside the box and on its edges: each near pair once, with the separation of nearest images."""
    rng, period = np.random.default_rng(11), np.array(period)
    points = rng.uniform(-20, 20, (300, 3)) * [1, 0.2, 1]
    points[:8] = [
        [0, 0, 0],
        [3, 4, 5],
        [-3, 0, 5],
        [6, 0, -1e-18],
        [-1e-18, 0, 0],
        [1.5, 2, 2.5],
        [3, 0, 10],
        [-9, 4, 0],
    ]
    pairs, apart = pairs_within(points, period, 1.4)
    i, j = np.triu_indices(300, 1)
    moves = np.arange(-20, 21)[:, None, None] * np.where(np.isfinite(period), period, 0.0)
    best = np.sum(np.min((points[j] - points[i] + moves) ** 2, axis=0), axis=1)
    near = np.sqrt(best) <= 1.4
    assert {tuple(pair) for pair in pairs} == set(zip(i[near], j[near], strict=True)) and len(pairs) == near.sum()
    expected = dict(zip(zip(i[near], j[near], strict=True), np.sqrt(best[near]), strict=True))
    np.testing.assert_allclose(np.linalg.norm(apart, axis=1), [expected[tuple(pair)] for pair in pairs], atol=1e-12)
    inside = wrapped(points, period)
    finite = np.isfinite(period)
    assert np.all(inside[:, finite] >= 0) and np.all((inside < period)[:, finite])
    np.testing.assert_allclose(minimum_image(inside - points, period)[:, finite], 0, atol=1e-12)
    with pytest.raises(ValueError, match="half the period"):
        pairs_within(points, np.array([2.0, 5, 5]), 1.4)


@pytest.mark.parametrize(
    ("box", "axes"),
    [
        ('kind = "pore"\nradius = 0.1', [0, 1, 2]),
        ('kind = "duct"\nsides = [0.2, 0.2]', [0, 1, 2]),
        ('kind = "duct"\nsides = [0.2, 0.3]', [0, 2]),
        ('kind = "duct"\naxis = "z"\nsides = [0.3, 0.2]', [0, 2]),
        ('kind = "duct"\nsides = [0.2, 9.0]', [0, 2]),
    ],
)
def test_axes_of_a_thin_room_are_those_of_its_box(box, axes):
    """Not those along which the rods happen to be."""
    extent = np.array([0.21, 0.2, 0.19]) + (np.arange(3) == (2 if "z" in box else 0)) * 5
    data = group(scattered(np.random.default_rng(3), 2, 40, extent), (0, 0, 1) if "z" in box else (1, 0, 0))
    assert space(data.assign_attrs(scene=f"[box]\n{box}\n")).axes.tolist() == axes
    assert space(data.assign_attrs(scene=f"[box]\n{box}\n"), 3).axes.tolist() == [0, 1, 2]


def test_coordinates_have_the_units_of_the_data():
    """As their values, which are in the units of the scene; an axis of a plot names the size of one."""
    data = group(scattered(np.random.default_rng(3), 6, 40, (4, 4, 4))).assign_attrs(units="length 1 um, time 2 s")
    found = {"r": pair_correlation(data), "x": density_map(data), "lag": mean_square_displacement(data)}
    found |= {"v": speed_distribution(data)}
    units = {name: array[name].attrs["units"] for name, array in found.items()}
    assert units == {"r": "1e-06 m", "x": "1e-06 m", "lag": "2.0 s", "v": "5e-07 m/s"}
    assert label(found["r"]["r"]) == "distance (µm)"
    assert label(found["r"]["r"].assign_attrs(units="1.0 m")) == "distance (m)"
    assert "(µm²)" in label(found["lag"]).replace("\n", " ")

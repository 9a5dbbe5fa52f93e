"""Measures of swarms: groups of a trajectory whose answer is known in closed form or by counting."""

import numpy as np
import pytest
import xarray as xr
from test_diagnostics import film

from warp_rods import swarm
from warp_rods.free_rods import FreeRods
from warp_rods.modes import beam_mode
from warp_rods.swarm_data import minimum_image, pairs_within, wrapped
from warp_rods.swarm_motion import displacement_exponent, mean_speed, mean_square_displacement, speed_distribution
from warp_rods.swarm_order import local_nematic_order, local_polar_order, motion_order, nematic_order, polar_order
from warp_rods.swarm_shapes import shape_of, shape_shares
from warp_rods.swarm_space import density_map, pair_correlation, velocity_correlation
from warp_rods.swimmer_shapes import initial_strain

OPEN = (np.inf, np.inf, np.inf)


def group(middle, direction=(1.0, 0.0, 0.0), period=None, step=1.0, length=1.0, nodes=5, **other) -> xr.Dataset:
    """Straight rods with these middles [frame, rod, 3] and directions, ``step`` from frame to frame."""
    middle = np.asarray(middle, float)
    along = np.broadcast_to(np.asarray(direction, float), middle.shape)
    position = middle[:, :, None] + length * np.linspace(-0.5, 0.5, nodes)[:, None] * along[:, :, None]
    data = {
        "position": (("frame", "rod", "node", "axis"), position),
        "length": ("rod", np.full(middle.shape[1], length)),
    }
    if period is not None:
        data["period"] = ("axis", np.array(period, float))
    data |= {name: (("frame", "rod"), values) for name, values in other.items()}
    times = {"units": "time"}
    return xr.Dataset(data, {"time": ("frame", step * np.arange(len(middle)), times)})


def isotropic(rng, *shape, flat=False) -> np.ndarray:
    vectors = rng.normal(size=(*shape, 3)) * [1, 1, not flat]
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def scattered(rng, frames, rods, box) -> np.ndarray:
    return rng.uniform(0, 1, (frames, rods, 3)) * np.asarray(box)


@pytest.mark.parametrize("dimensions", [2, 3])
def test_rods_along_one_line(dimensions):
    """All one way: 1 and 1; half of them the other way: 0 and 1; two crossed halves lie in a plane: 0 and 0."""
    at = scattered(np.random.default_rng(0), 1, 40, (5, 5, 5))
    line = np.array([3.0, 4.0, 0.0]) / 5
    half = np.where(np.arange(40) % 2, 1.0, -1.0)[:, None]
    aligned, opposed = group(at, line), group(at, half * line)
    assert polar_order(aligned, dimensions).item() == pytest.approx(1)
    assert polar_order(opposed, dimensions).item() == pytest.approx(0, abs=1e-15)
    assert nematic_order(aligned, dimensions).item() == pytest.approx(1)
    assert nematic_order(opposed, dimensions).item() == pytest.approx(1)
    crossed = group(at, np.where(half > 0, [[1.0, 0, 0]], [[0, 1.0, 0]]))
    expected = {2: 0.0, 3: 0.25}[dimensions]  # Q = diag(1/4, 1/4, −1/2) in space
    assert nematic_order(crossed.assign(position=crossed.position * [1, 1, 1e-3]), dimensions).item() == pytest.approx(
        expected, abs=1e-12
    )


def test_order_of_any_direction():
    """⟨|⟨p⟩|²⟩ = 1/N; the nematic order has 1/√N in a plane, 0.86/√N in space; rods without direction are left out."""
    rng, frames, rods = np.random.default_rng(1), 600, 100
    for dimensions, share in ((2, 1.0), (3, 0.86)):
        p = isotropic(rng, frames, rods, flat=dimensions == 2)
        data = group(np.zeros((frames, rods, 3)), p)
        polar, nematic = polar_order(data, dimensions), nematic_order(data, dimensions)
        assert polar.attrs["isotropic"] == 0.1
        assert np.sqrt((polar**2).mean()) == pytest.approx(0.1, rel=0.07)
        assert np.sqrt((nematic**2).mean()) == pytest.approx(0.1 * share, rel=0.07)
    p[:, 1:] = 0.0
    assert polar_order(group(np.zeros((frames, rods, 3)), p), 3).to_numpy() == pytest.approx(1)
    assert nematic_order(group(np.zeros((frames, rods, 3)), p), 3).to_numpy() == pytest.approx(1)


def test_local_order_sees_domains():
    """Two bands that move against each other: no polar order at all, all of it in each band, also across the edge."""
    x = np.arange(40) * 0.5
    middle = np.stack([x, 0 * x, 0 * x], axis=-1)[None]
    p = np.where(((x >= 5) & (x < 15))[:, None], [1.0, 0, 0], [-1.0, 0, 0])
    data = group(middle, p, period=(20.0, np.inf, np.inf))
    assert polar_order(data).item() == pytest.approx(0, abs=1e-12)
    local = local_polar_order(data, 1.1, dimensions=3)
    inside = (np.abs(np.abs(x - 10) - 5) > 1.2)[None]
    np.testing.assert_allclose(local.values[inside], 1)
    assert local.sel(rod=10).item() == pytest.approx(1 / 5)  # three of five of its own way, one of them itself
    np.testing.assert_allclose(local_nematic_order(data, 1.1, dimensions=3), 1)
    assert local.attrs["radius"] == 1.1
    alone = group(np.zeros((1, 1, 3)), (0, 0, 1.0))
    assert local_polar_order(alone, 0.1, dimensions=3).item() == pytest.approx(1)


def test_failed_rods_are_left_out():
    status = np.zeros((3, 4), int)
    status[1:, 0] = 2
    p = np.tile([[-1.0, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0]], (3, 1, 1))
    data = group(scattered(np.random.default_rng(2), 3, 4, (9, 9, 9)), p, status=status)
    np.testing.assert_allclose(polar_order(data), 1)
    assert local_polar_order(data, 0.1).rod.values.tolist() == [1, 2, 3]
    with pytest.raises(ValueError, match="all rods failed"):
        polar_order(group(np.zeros((1, 2, 3)), status=np.ones((1, 2), int)))


def test_ballistic_rods():
    """Straight on at v: speed v, all the same way, displacement (v lag)², exponent 2; periods do not matter."""
    v, t = np.array([0.3, -0.4, 1.2]), 0.1 * np.arange(41)
    start = scattered(np.random.default_rng(3), 1, 7, (4, 4, 4))
    data = group(start + t[:, None, None] * v, step=0.1, period=(4, 4, 4))
    np.testing.assert_allclose(mean_speed(data), 1.3)
    np.testing.assert_allclose(motion_order(data, 3), 1)
    msd = mean_square_displacement(data)
    np.testing.assert_allclose(msd, (1.3 * msd.lag) ** 2, rtol=1e-12)
    assert msd.lag[0] == pytest.approx(0.1) and msd.lag[-1] == pytest.approx(2.0)
    np.testing.assert_allclose(displacement_exponent(data), 2, rtol=1e-10)
    shares = speed_distribution(data, bins=20)
    width = float(shares.speed[1] - shares.speed[0])
    np.testing.assert_allclose(shares, [0] * 19 + [1 / width])
    uneven = data.assign_coords(time=("frame", t**2))
    with pytest.raises(ValueError, match="even times"):
        mean_square_displacement(uneven)


def test_random_walks_diffuse():
    """Steps of variance σ² along each axis: 3 σ² a step, exponent 1; within five errors of independent walks."""
    walks = np.random.default_rng(4).normal(0, 0.2, (101, 800, 3)).cumsum(axis=0)
    msd = mean_square_displacement(group(walks))
    error = 5 * np.sqrt(2 / 3 / 800 * np.maximum(msd.lag / 50, 0.05))
    assert np.all(np.abs(msd / (3 * 0.04 * msd.lag) - 1) < error)
    assert displacement_exponent(group(walks)).mean() == pytest.approx(1, abs=0.05)


def test_speeds_of_a_rotation():
    """Uniform rotation in a disc of radius R: p(v) = 2v/R², ⟨v⟩ = 2R/3, to the error of so many points."""
    rng, omega = np.random.default_rng(5), 1e-2
    r, phi = np.sqrt(rng.uniform(0, 1, 4000)), rng.uniform(0, 2 * np.pi, 4000)
    angle = phi + omega * np.arange(5)[:, None]
    data = group(np.stack([r * np.cos(angle), r * np.sin(angle), 0 * angle], axis=-1))
    assert mean_speed(data).to_numpy() == pytest.approx(2 / 3 * omega, rel=0.02)
    found = speed_distribution(data, bins=8)
    np.testing.assert_allclose(found, 2 * found.speed / omega**2, rtol=0.25)
    assert float(found.sum() * (found.speed[1] - found.speed[0])) == pytest.approx(1)


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
    """g = 1 in every bin within 4.5 counted errors, on average within 3; unrelated velocities have C_v = 0."""
    rng, frames, rods = np.random.default_rng(6), 40, 300
    middle = scattered(rng, frames, rods, box)
    found = pair_correlation(group(middle, period=period, length=0.9), bins=20)
    assert found.r[-1] > 2
    ideal = found.expected.sum("frame")
    excess = ((found * found.expected).sum("frame") / ideal - 1) * np.sqrt(ideal)
    assert np.abs(excess).max() < 4.5
    share = (found * found.expected).sum("r") / found.expected.sum("r") - 1  # frames are independent: their own error
    assert np.abs(share.mean()) < 3.5 * share.std() / np.sqrt(frames)
    assert share.std() < 0.05
    assert found.sizes == {"frame": frames, "r": 20}
    v = rng.normal(size=(1, rods, 3)) * (np.asarray(box) > 0.2)
    moving = group(middle[:1] + 1e-6 * np.arange(3)[:, None, None] * v, period=period, length=0.9)
    assert np.abs(velocity_correlation(moving, bins=4)).max() < 0.1


def test_a_lattice_has_its_neighbours():
    """A simple cubic lattice: 6, 12, 8, 6 neighbours at 1, √2, √3, 2, and nothing in between."""
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


def test_velocities_of_a_common_drift_and_of_a_rotation():
    """C_v = 1 for a drift. A rigid rotation of a ring of n: v_i·v_j ∝ cos of the angle between them, exactly."""
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
    assert found.notnull()[2].sum() == 4  # 4: one more pair of neighbours at 60°, at 3.0 exactly


@pytest.mark.parametrize("box, period, dimensions", BOXES.values(), ids=BOXES)
def test_density_holds_all_rods(box, period, dimensions):
    """Its sum times the cells' size is the number of rods; a rod on a cell's edge counts where its nodes are."""
    rng = np.random.default_rng(10)
    data = group(scattered(rng, 3, 20, box) * 3 - 5, isotropic(rng, 3, 20, flat=dimensions == 2), period=period)
    found = density_map(data, dimensions=dimensions)
    assert found.ndim == dimensions + 1
    size = np.prod([float(found[name][1] - found[name][0]) for name in found.dims[1:]])
    np.testing.assert_allclose(found.sum(found.dims[1:]) * size, 20)
    assert found.attrs["units"] == f"1/length^{dimensions}"


def test_density_is_where_the_rod_is():
    """A node on an edge belongs to the cell above, and to the first at the period."""
    data = group([[[0.5, 0.5, 0], [4.5, 0.5, 0]]], period=(5, 5, np.inf), nodes=3)
    found = density_map(data, cell=1.0)[0]
    expected = np.zeros((5, 5))
    for x, share in ((0.0, 0.25), (0.5, 0.5), (1.0, 0.25), (4.0, 0.25), (4.5, 0.5), (5.0, 0.25)):
        expected[int(x % 5), 0] += share
    np.testing.assert_allclose(found, expected)
    assert found.x.values.tolist() == [0.5, 1.5, 2.5, 3.5, 4.5]


@pytest.mark.parametrize("period", [(3.0, 4.0, 5.0), (3.0, np.inf, 5.0), OPEN])
def test_pairs_against_all_pairs(period):
    """Points far out of the box, some on its edges: each near pair once, with the separation of nearest images."""
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


def bent(*bendings) -> xr.Dataset:
    """Swimmers with these bendings k(s) and no twist; their positions by turning tangents along in space."""
    fine = np.linspace(-0.5, 0.5, 4001)
    s, ds = fine[::50], fine[1] - fine[0]
    k = np.array([np.broadcast_to(bending(fine), fine.shape) + 0j for bending in bendings])
    tangent, one, other = (np.tile(axis, (len(k), 1)) for axis in np.eye(3))
    line = [np.zeros((len(k), 3))]
    for now in ((k[:, 1:] + k[:, :-1]) / 2).T[..., None]:
        turn = ds * (now.real * one + now.imag * other)
        line.append(line[-1] + ds * (tangent + turn / 2))
        tangent = (tangent + turn) / np.linalg.norm(tangent + turn, axis=1, keepdims=True)
        one = one - np.sum(one * tangent, axis=1, keepdims=True) * tangent
        one /= np.linalg.norm(one, axis=1, keepdims=True)
        other = np.cross(tangent, one)
    k = k[:, ::50]
    strain = np.stack([0 * k.real, k.imag, -k.real], axis=-1)
    vector = ("frame", "rod", "node", "axis")
    data = {"position": (vector, np.stack(line, axis=1)[None, :, ::50]), "strain": (vector, strain[None])}
    data["activity"] = (vector[:3], np.zeros((1, *k.shape)))
    return xr.Dataset(data, {"time": ("frame", [0.0]), "s": ("node", s)})


def test_shapes_are_named():
    """Modes by themselves, in any plane; a circle and a half; a helix of two turns, while a wave bends as much."""
    two = 4 * np.pi
    known = {
        "straight": lambda s: 0.3 * beam_mode(0, s),
        "U": lambda s: (3 * beam_mode(0, s) + beam_mode(1, s)) * np.exp(0.7j),
        "S": lambda s: -4 * beam_mode(1, s) + 1j * beam_mode(0, s),
        "W": lambda s: 8j * beam_mode(2, s),
        "higher": lambda s: 12 * beam_mode(4, s),
        "coiled": lambda s: 3 * np.pi + 0 * s,
        "coiled ": lambda s: two * np.exp(0.5j * two * s),
    }
    assert shape_of(bent(*known.values())).values[0].tolist() == [name.strip() for name in known]
    shares = shape_shares(bent(*known.values()))[0]
    assert float(shares.sum()) == pytest.approx(1) and float(shares.sel(shape="coiled")) == pytest.approx(2 / 7)
    with pytest.raises(ValueError, match="no strain"):
        shape_shares(group(np.zeros((1, 2, 3))))


@pytest.fixture(scope="module")
def swimming(device) -> xr.Dataset:
    """Six swimmers of one stiffness and three shapes, for a moment."""
    shapes = [{"kind": "mode", "mode": mode, "amplitude": 3.0} for mode in (0, 1, 2, 0, 1, 2)]
    given = {"bend": np.array([1e-3]), "twist": np.array([1e-3]), "moment": np.zeros(1)}
    strain = [initial_strain(shape, 33, given)[0] for shape in shapes]
    return film(FreeRods(6, 33, bend=1e-3, twist=1e-3, shape=strain, device=device), 0.1, 0.02)


def test_a_run_is_measured_and_drawn(swimming, tmp_path):
    """All measures, with units and sources, of what a simulation saves; a figure of each, from either."""
    data = swimming.assign(position=swimming.position + xr.DataArray(np.arange(6) % 3, dims="rod"))
    found = swarm.measure(data, *swarm.MEASURES)
    assert set(found) == set(swarm.MEASURES) == set(swarm.PLOTS)
    assert all(array.attrs.keys() >= {"units", "long_name", "source"} for array in found.values())
    assert found.shape_shares[0].sel(shape=["U", "S", "W"]).values == pytest.approx(1 / 3)
    for name in swarm.PLOTS:
        axes = swarm.plot(found, name).axes[0]
        assert axes.get_xlabel() and axes.get_ylabel(), name
    swarm.plot(data, "mean_speed", tmp_path / "speed")
    assert (tmp_path / "speed.png").stat().st_size > 5000
    for unknown in (swarm.measure, swarm.plot):
        with pytest.raises(ValueError, match=r"no measure called beauty: there are polar_order, .*"):
            unknown(data, "beauty")


def test_long_runs_are_read_in_parts(monkeypatch):
    """A frame at a time, with a progress bar from the start, everything is the same."""
    rng = np.random.default_rng(14)
    walk = scattered(rng, 1, 40, (3, 3, 3)) + rng.normal(0, 0.05, (9, 40, 3)).cumsum(axis=0)
    data = group(walk, isotropic(rng, 1, 40), period=(3, 3, 3))
    names = [name for name in swarm.MEASURES if name != "shape_shares"]
    whole = swarm.measure(data, *names)
    assert whole.crossings.sum() > 0
    monkeypatch.setattr("warp_rods.swarm_data._BLOCK_BYTES", 1)
    monkeypatch.setattr("warp_rods.swarm_data._PATIENCE", -1.0)
    xr.testing.assert_identical(swarm.measure(data, *names), whole)

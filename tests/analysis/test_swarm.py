"""Measures of swarms, for groups of a trajectory with answers in closed form or by counting."""

import numpy as np
import pytest
import xarray as xr
from examples.swarm import bent, group, isotropic, scattered
from test_diagnostics import integrate

from warp_rods.analysis.swarm.motion import (
    displacement_exponent,
    mean_speed,
    mean_square_displacement,
    speed_distribution,
)
from warp_rods.analysis.swarm.order import (
    local_nematic_order,
    local_polar_order,
    motion_order,
    nematic_order,
    polar_order,
)
from warp_rods.analysis.swarm.shapes import shape_of, shape_shares
from warp_rods.draw import swarm
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.free.shapes import initial_strain
from warp_rods.rods.modes import beam_mode


@pytest.mark.parametrize("dimensions", [2, 3])
def test_order_of_parallel_antiparallel_and_crossed_rods(dimensions):
    """Parallel: 1 and 1. Half antiparallel: 0 and 1. Half perpendicular: nematic 0 in their plane, 1/4 in space."""
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


def test_order_of_random_directions():
    """⟨|⟨p⟩|²⟩ = 1/N; nematic order 1/√N in a plane, 0.86/√N in space. Rods without direction are left out."""
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


def test_local_order_shows_domains():
    """Two bands of opposite directions: no global polar order, full order in each, also through the boundary."""
    x = np.arange(40) * 0.5
    middle = np.stack([x, 0 * x, 0 * x], axis=-1)[None]
    p = np.where(((x >= 5) & (x < 15))[:, None], [1.0, 0, 0], [-1.0, 0, 0])
    data = group(middle, p, period=(20.0, np.inf, np.inf))
    assert polar_order(data).item() == pytest.approx(0, abs=1e-12)
    local = local_polar_order(data, 1.1, dimensions=3)
    inside = (np.abs(np.abs(x - 10) - 5) > 1.2)[None]
    np.testing.assert_allclose(local.values[inside], 1)
    assert local.sel(rod=10).item() == pytest.approx(1 / 5)  # three of five have its own direction, itself included
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
    """Constant velocity v: speed v, motion order 1, displacement (v lag)², exponent 2, whatever the periods."""
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
    width = float(shares.v[1] - shares.v[0])
    np.testing.assert_allclose(shares, [0] * 19 + [1 / width])
    uneven = data.assign_coords(time=("frame", t**2))
    with pytest.raises(ValueError, match="equally spaced in time"):
        mean_square_displacement(uneven)


def test_random_walks_diffuse():
    """Steps of variance σ² along each axis: 3 σ² per step, exponent 1, within five standard errors."""
    walks = np.random.default_rng(4).normal(0, 0.2, (101, 800, 3)).cumsum(axis=0)
    msd = mean_square_displacement(group(walks))
    error = 5 * np.sqrt(2 / 3 / 800 * np.maximum(msd.lag / 50, 0.05))
    assert np.all(np.abs(msd / (3 * 0.04 * msd.lag) - 1) < error)
    assert displacement_exponent(group(walks)).mean() == pytest.approx(1, abs=0.05)


def test_speeds_of_a_rotation():
    """Uniform rotation of a disc of radius R: p(v) = 2v/R² and ⟨v⟩ = 2R/3, within sampling errors."""
    rng, omega = np.random.default_rng(5), 1e-2
    r, phi = np.sqrt(rng.uniform(0, 1, 4000)), rng.uniform(0, 2 * np.pi, 4000)
    angle = phi + omega * np.arange(5)[:, None]
    data = group(np.stack([r * np.cos(angle), r * np.sin(angle), 0 * angle], axis=-1))
    assert mean_speed(data).to_numpy() == pytest.approx(2 / 3 * omega, rel=0.02)
    found = speed_distribution(data, bins=8)
    np.testing.assert_allclose(found, 2 * found.v / omega**2, rtol=0.25)
    assert float(found.sum() * (found.v[1] - found.v[0])) == pytest.approx(1)


def test_shapes_are_named():
    """Single beam modes in any plane; one and a half circles; a helix of two turns."""
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
    """Six swimmers of one stiffness and three shapes, for a short time."""
    shapes = [{"kind": "mode", "mode": mode, "amplitude": 3.0} for mode in (0, 1, 2, 0, 1, 2)]
    given = {"bend": np.array([1e-3]), "twist": np.array([1e-3]), "moment": np.zeros(1)}
    strain = [initial_strain(shape, 33, given)[0] for shape in shapes]
    return integrate(FreeRods(6, 33, bend=1e-3, twist=1e-3, shape=strain, device=device), 0.1, 0.02)


def test_a_run_is_measured_and_drawn(swimming, tmp_path):
    """All measures, with units and sources, of a simulation; and a figure of each, from data or from measures."""
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
    """Reading one frame at a time, with a progress bar from the start, changes nothing."""
    rng = np.random.default_rng(14)
    walk = scattered(rng, 1, 40, (3, 3, 3)) + rng.normal(0, 0.05, (9, 40, 3)).cumsum(axis=0)
    data = group(walk, isotropic(rng, 1, 40), period=(3, 3, 3))
    names = [name for name in swarm.MEASURES if name != "shape_shares"]
    whole = swarm.measure(data, *names)
    assert whole.crossings.sum() > 0
    monkeypatch.setattr("warp_rods.analysis.swarm.data._BLOCK_BYTES", 1)
    monkeypatch.setattr("warp_rods.progress.WAIT", -1.0)
    xr.testing.assert_identical(swarm.measure(data, *names), whole)


def test_ensembles_are_measured_together():
    """A soft and a stiff cell that pass through each other: neither group alone has the crossing."""
    open_space, none = (np.inf,) * 3, np.zeros((2, 1))
    soft = group([[[0, 0, 0]], [[0, 0, 0]]], (1, 0, 0), period=open_space, activity=none)
    stiff = group([[[0, 0, 0.1]], [[0.03, 0.02, -0.1]]], (0, 1, 0), period=open_space, activity=none)
    tree = xr.DataTree.from_dict({"soft": soft, "stiff": stiff, "filament": soft.drop_vars("activity")})
    both = swarm.together(tree)
    assert both.sizes["rod"] == 2 and both["period"].dims == ("axis",)
    assert [int(swarm.measure(data, "crossings").crossings.sum()) for data in (soft, stiff, both)] == [0, 0, 1]
    with pytest.raises(ValueError, match="no ensemble called soff: the run has soft, stiff, filament"):
        swarm.together(tree, "soff")

"""Measures of filaments on membranes, for trajectories with known answers; and theorems on curvature."""

import numpy as np
import pytest
import xarray as xr

from warp_rods.analysis import sensing
from warp_rods.errors import RunFolderError
from warp_rods.membranes.mesh import area_below, area_mean, curvatures, triangulate
from warp_rods.membranes.sampling import uniform_points
from warp_rods.membranes.surfaces import make

TORUS = make("torus", {"major": 1.0, "minor": 0.4})
OUTER = 0.5 + 0.4 / np.pi
"""Share of the area of that torus where 𝒦 > 0: (πR + 2r)/(2πR)."""
CELLS = (24, 48, 96)


def ensemble(frames=101, rods=3, end=10.0, **variables) -> xr.Dataset:
    """A trajectory of filaments of length 1 at rest, except for the given variables [frame, rod(, axis)].

    ``middle`` is the position of the midpoints.
    """
    shape = (frames, rods)
    data = {name: np.zeros(shape) for name in ("gauss", "energy", "steric_energy", "dissipation")}
    data |= {"status": np.zeros(shape, int), **variables}
    middle = data.pop("middle", np.zeros((*shape, 3)))
    dims = ("frame", "rod")
    arrays = {name: (dims, values) for name, values in data.items()}
    arrays["position"] = ((*dims, "node", "axis"), np.repeat(middle[:, :, None], 9, axis=2))
    arrays["length"] = ("rod", np.ones(rods))
    return xr.Dataset(arrays, {"time": ("frame", np.linspace(0.0, end, frames))})


def slope(cells, errors) -> float:
    return -np.polyfit(np.log(cells), np.log(np.abs(errors)), 1)[0]


def test_curvatures_of_spheres_and_tori(verified):
    """−1/R twice for a sphere; −1/r and −cos θ/(R + r cos θ) for a torus, θ from its outer equator."""
    rng = np.random.default_rng(1)
    sphere = make("sphere", {"radius": 2.0})
    found = curvatures(sphere, uniform_points(sphere, 20, rng))
    for values, exact in zip(found, (np.full((20, 2), -0.5), 0.25, -0.5), strict=True):
        np.testing.assert_allclose(values, np.broadcast_to(exact, values.shape), rtol=1e-12)
    points = uniform_points(TORUS, 50, rng)
    rho = np.hypot(points[:, 0], points[:, 1])
    around, along = np.full(50, -1 / 0.4), -(rho - 1.0) / 0.4 / rho
    found = curvatures(TORUS, points)
    np.testing.assert_allclose(found.principal, np.stack([around, along], axis=-1), rtol=0, atol=1e-10)
    np.testing.assert_allclose(found.gaussian, around * along, rtol=0, atol=1e-9)
    verified.below(
        "exact", "torus: mean curvature", measured=np.abs(found.mean - (around + along) / 2), bound=1e-10,
        reference="−(1/r + cos θ/(R + r cos θ))/2",
    )  # fmt: skip
    np.testing.assert_allclose(found.gaussian, TORUS.gaussian_curvature(points), rtol=0, atol=1e-12)


def test_mean_curvature_of_a_torus_is_zero(verified):
    """Gauss–Bonnet, to second order in the mesh size, as is the share of the area where 𝒦 > 0."""
    means, shares = [], []
    for cells in CELLS:
        mesh = triangulate(TORUS, cells)
        gauss = curvatures(TORUS, mesh.points).gaussian
        means.append(area_mean(mesh, gauss))
        shares.append(1 - area_below(mesh, gauss, np.zeros(1))[0] - OUTER)
    assert abs(means[-1]) < 1e-3 and abs(shares[-1]) < 1e-3
    verified.below(
        "exact", "triangulated torus: mean Gaussian curvature, 96 cells", measured=abs(means[-1]), bound=1e-3,
        reference="Gauss–Bonnet: 0",
    )  # fmt: skip
    verified.order(
        "triangulated torus: order of ⟨𝒦⟩ and of the share of the area at 𝒦 > 0 in the size of cells",
        measured=[slope(CELLS, means), slope(CELLS, shares)], reference="0 and ½ + r/πR",
    )  # fmt: skip


def test_area_below_a_height():
    """Height is uniformly distributed over the area of a sphere (Archimedes)."""
    mesh = triangulate(make("sphere", {"radius": 1.0}), 48)
    levels = np.linspace(-1.2, 1.2, 13)
    expected = np.clip((levels + 1) / 2, 0, 1)
    np.testing.assert_allclose(area_below(mesh, mesh.points[:, 2], levels), expected, rtol=0, atol=1e-3)


def test_uniform_filaments_are_not_enriched():
    rods = 4000
    points = uniform_points(TORUS, rods, np.random.default_rng(5))
    data = ensemble(frames=1, rods=rods, gauss=TORUS.gaussian_curvature(points)[None])
    found = sensing.enrichment(data, TORUS).isel(frame=0)
    share = np.array([OUTER, 1 - OUTER])
    np.testing.assert_allclose(found.area_share, share, rtol=0, atol=1e-3)
    error = np.sqrt((1 - share) / (share * rods))
    assert np.all(np.abs(found.enrichment - 1) < 3 * error)
    half_width = (found.enrichment_high - found.enrichment_low) / 2
    np.testing.assert_allclose(half_width, error, rtol=0.15)  # the 68 % interval is one standard error
    histogram = sensing.curvature_histogram(data, TORUS, bins=9).isel(frame=0)
    share = histogram.gauss_area_share
    assert np.all(np.abs(histogram.gauss_share - share) < 4 * np.sqrt(share * (1 - share) / rods))
    spread = np.std(data.gauss.values) / np.sqrt(rods)
    assert abs(histogram.gauss_mean - histogram.gauss_area_mean) < 3 * spread


def test_gathered_filaments_are_enriched():
    """Three of four filaments at 𝒦 > 0; a failed one does not count."""
    gauss, status = np.array([[1.0, 1.0, 1.0, -1.0, 1.0]]), np.array([[0, 0, 0, 0, 2]])
    data = ensemble(frames=1, rods=5, gauss=gauss, status=status)
    found = sensing.enrichment(data, TORUS).isel(frame=0)
    assert found.enrichment.sel(side="positive") == pytest.approx(0.75 / OUTER, rel=1e-3)
    assert found.enrichment.sel(side="negative") == pytest.approx(0.25 / (1 - OUTER), rel=1e-3)
    histogram = sensing.curvature_histogram(data, TORUS, bins=[-2.0, 0.0, 2.0])
    np.testing.assert_allclose(histogram.gauss_share[0], [0.25, 0.75])
    assert histogram.gauss_mean[0] == 0.5


def test_membranes_of_constant_curvature():
    """A sphere fills one bin; a cylinder has neither side, although its 𝒦 is zero only up to round-off."""
    data = ensemble(frames=2, gauss=np.full((2, 3), 0.25 * (1 + 1e-13)))
    found = sensing.curvature_histogram(data, make("sphere", {"radius": 2.0}))
    for shares in (found.gauss_share[0], found.gauss_share[1], found.gauss_area_share):
        assert shares.max() == pytest.approx(1.0) and shares.values.argmax() == 10
    assert found.gauss_area_mean == pytest.approx(0.25)
    cylinder = make("cylinder", {"radius": 0.5, "length": 2.0})
    found = sensing.enrichment(ensemble(frames=2, gauss=np.full((2, 3), 1e-15)), cylinder)
    assert found.enrichment.isnull().all() and (found.area_share == 0).all()


def test_if_all_failed_the_results_are_nan():
    data = ensemble(frames=1, status=np.full((1, 3), 1))
    assert sensing.enrichment(data, TORUS).enrichment.isnull().all()
    assert sensing.curvature_histogram(data, TORUS).gauss_share.isnull().all()
    assert sensing.settling_time(data).settling_time.isnull().all()


def test_settling_time():
    """x = e^(−t/τ) is within 0.1 of its end from t = τ ln 10; one filament drifts, one is at rest, one failed."""
    time, tau = np.linspace(0.0, 10.0, 101), 1.03
    middle = np.zeros((101, 4, 3))
    middle[:, 0, 0], middle[:, 1, 1] = np.exp(-time / tau), time
    status = np.zeros((101, 4), int)
    status[50:, 3] = 1
    found = sensing.settling_time(ensemble(rods=4, middle=middle, status=status)).settling_time.values
    assert found[0] == pytest.approx(np.ceil(10 * tau * np.log(10)) / 10)
    assert found[1] == np.inf and found[2] == 0.0 and np.isnan(found[3])


def test_a_filament_that_returns_settles_when_it_is_back():
    middle = np.zeros((101, 1, 3))
    middle[40:60, 0, 0] = 1.0
    found = sensing.settling_time(ensemble(rods=1, middle=middle))
    assert found.settling_time.item() == pytest.approx(6.0)


def test_relaxation_time():
    """E = e^(−t/τ): 95 % is released at t = τ ln 20; with τ as long as the run the energy is still falling."""
    tau = np.array([0.5, 1.03, 10.0])
    energy = np.exp(-np.linspace(0.0, 10.0, 101)[:, None] / tau)
    found = sensing.relaxation_time(ensemble(energy=energy, dissipation=energy / tau)).relaxation_time.values
    np.testing.assert_allclose(found[:2], np.ceil(10 * tau[:2] * np.log(20)) / 10)
    assert found[2] == np.inf


def test_bootstrap():
    """The standard error of a mean; equal results for equal seeds; a median with inf."""
    values = xr.DataArray(np.random.default_rng(2).normal(3.0, 2.0, (5, 400)), dims=("frame", "rod"))
    found = sensing.bootstrap(values, np.mean)
    np.testing.assert_array_equal(found.value, values.mean("rod"))
    assert np.all(found.low < found.value) and np.all(found.value < found.high)
    np.testing.assert_allclose((found.high - found.low) / 2, 2.0 / 20, rtol=0.15)
    xr.testing.assert_identical(found, sensing.bootstrap(values, np.mean))
    assert not found.equals(sensing.bootstrap(values, np.mean, seed=1))
    late = xr.DataArray([1.0, 2.0, 3.0, 4.0, np.inf, np.inf, np.nan], dims="rod")
    found = sensing.bootstrap(late)
    assert found.value == 3.5 and found.low < 3.5 and found.high == np.inf


def test_the_table():
    found = sensing.measure(ensemble(), TORUS)
    assert {"gauss_share", "enrichment", "settling_time", "relaxation_time"} <= set(found.data_vars)
    for name, variable in found.data_vars.items():
        assert variable.attrs["units"] and variable.attrs["long_name"], name
    assert set(sensing.measure(ensemble(), TORUS, "settling_time").data_vars) == {"settling_time"}
    with pytest.raises(ValueError, match=r"no measure called speed: there are curvature_histogram, "):
        sensing.measure(ensemble(), TORUS, "speed")


SWIMMER = """
[[swimmers]]
name = "cell"
count = 1
nodes = 17
bend = 5e-3
twist = 1e-3
[time]
end = 1.0
"""


def test_the_membrane_of_a_run():
    run = xr.DataTree(xr.Dataset(attrs={"scene": '[surface]\nkind = "sphere"\nradius = 2.0\n' + SWIMMER}))
    assert sensing.membrane_of(run).values == {"radius": 2.0}
    with pytest.raises(RunFolderError, match=r"no \[surface\]"):
        sensing.membrane_of(xr.DataTree(xr.Dataset(attrs={"scene": SWIMMER})))


def test_a_moving_membrane_is_refused_but_not_at_one_time():
    moving = make("sphere", {"radius": "1.0 + 0.1*t"})
    with pytest.raises(ValueError, match=r"surface\.at\(t\)"):
        sensing.measure(ensemble(), moving, "enrichment")
    area = sensing.measure(ensemble(gauss=np.ones((101, 3))), moving.at(2.0), "enrichment")["area_share"]
    assert float(area.sel(side="positive")) == pytest.approx(1.0)

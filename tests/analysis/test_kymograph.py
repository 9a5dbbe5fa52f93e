"""Kymographs of growing filaments: the energy balance of a run, and trajectories with known answers."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.special import erf

from warp_rods.analysis import kymograph
from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner

BRIDGE = Path(__file__).parents[2] / "scenes" / "escrt_bridge.toml"


@pytest.fixture(scope="module")
def buckling(tmp_path_factory) -> xr.Dataset:
    """The scene of the bridge with growth from length 0.8 to 1.2, at twice the rate."""
    scene = Scene.load(BRIDGE)
    filaments = scene.filaments[0].model_dump(exclude_none=True)
    filaments |= {"nodes": 65, "length": 0.8, "growth": {"rate": 0.1, "until": 1.2}}
    table = scene.model_dump(exclude_none=True) | {"filaments": [filaments], "time": {"end": 5.0, "save_every": 0.02}}
    run = runner.simulate(Scene.model_validate(table), tmp_path_factory.mktemp("run") / "bridge", device="cpu")
    return run.data["escrt"].to_dataset().load()


def at_rest(frames: int, **variables) -> xr.Dataset:
    """One rod of length 1 without energy, except for the given variables [frame]."""
    values = {name: np.zeros(frames) for name in ("energy", "steric_energy", "dissipation")}
    values |= {"length": np.ones(frames), **variables}
    arrays = {name: (("frame", "rod"), value[:, None]) for name, value in values.items()}
    return xr.Dataset(arrays, {"time": ("frame", np.linspace(0.0, 10.0, frames))})


@pytest.mark.long
def test_terms_sum_to_the_energy(buckling):
    terms = kymograph.energy_terms(buckling)
    total = sum(terms[name] for name in kymograph.TERMS)
    np.testing.assert_allclose(total, buckling.energy_density, rtol=1e-6)
    energy = np.trapezoid(total.values, terms.arc.values, axis=-1)
    np.testing.assert_allclose(energy, buckling.energy, rtol=1e-12)
    np.testing.assert_allclose(terms.arc[:, 0, -1], buckling.length[:, 0], rtol=1e-12)
    assert all(term.attrs["units"] == "force" for term in terms.data_vars.values())


@pytest.mark.long
def test_energy_moves_from_bending_to_twist_as_the_filament_leaves_the_hoop(buckling):
    terms = kymograph.energy_terms(buckling).isel(rod=0)
    hoop = 0.5 * (1 / 0.4 - 1.0) ** 2
    np.testing.assert_allclose(terms.normal_energy[0], hoop, rtol=1e-4)
    assert (terms.twist_energy[0] < 1e-3).all()
    assert terms.normal_energy[-1, -1] < 0.7 * hoop
    assert terms.twist_energy[-1].max() > 0.1
    assert terms.geodesic_energy.values[-1].argmax() == 0


@pytest.mark.long
def test_energy_per_length_is_the_growth_power_minus_the_dissipation(buckling):
    """Second order in the time between frames and in Δs."""
    growing = buckling.isel(frame=slice(2, 198))
    found = kymograph.energy_per_length(growing).energy_per_length.isel(rod=0, frame=slice(1, -1))
    expected = ((growing.growth_power - growing.dissipation) / 0.1).isel(rod=0, frame=slice(1, -1))
    np.testing.assert_allclose(found, expected, atol=0.02)
    assert found.min() < 0.7 * found[0]
    assert np.isnan(kymograph.energy_per_length(buckling.isel(frame=slice(220, None))).energy_per_length).all()


def test_round_off_of_the_length_is_not_growth():
    """Lengths that differ in their last digits."""
    noisy = 0.5 + 1e-13 * np.random.default_rng(0).normal(size=50)
    data = at_rest(50, length=noisy, energy=np.linspace(1.0, 0.0, 50))
    assert kymograph.energy_per_length(data).energy_per_length.isnull().all()
    slow = kymograph.energy_per_length(
        at_rest(50, length=np.linspace(0.5, 0.50001, 50), energy=np.linspace(0.0, 1.0, 50))
    )
    np.testing.assert_allclose(slow.energy_per_length, 1e5, rtol=1e-6)


def test_a_peak_is_found_with_its_energy():
    """A Gaussian on a background; the energy above half of the maximum is erf √ln 2 of the whole."""
    time = np.linspace(0.0, 10.0, 2001)
    dissipation = 1e-4 + np.exp(-0.5 * ((time - 6.0) / 0.1) ** 2)
    data = at_rest(2001, dissipation=dissipation, length=1 + 0.2 * time)
    found = kymograph.dissipation_peaks(data).isel(rod=0)
    assert found.peak_ratio == pytest.approx(1 / 1e-4, rel=1e-3)
    assert found.peak_time == pytest.approx(6.0, abs=5e-3)
    assert found.peak_length == pytest.approx(2.2, abs=1e-3)
    assert found.peak_energy == pytest.approx(0.1 * np.sqrt(2 * np.pi) * erf(np.sqrt(np.log(2))), rel=0.02)


def test_a_steady_run_has_no_peak():
    found = kymograph.dissipation_peaks(at_rest(101, dissipation=np.full(101, 2.0)))
    assert found.peak_ratio == 1 and found.peak_energy == 0


@pytest.mark.long
def test_buckling_is_a_peak_of_the_dissipation(buckling):
    found = kymograph.dissipation_peaks(buckling.isel(frame=slice(10, 198))).isel(rod=0)
    assert found.peak_ratio > 10
    assert 0.85 < found.peak_length < 1.2

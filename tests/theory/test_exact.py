"""The closed forms of tests/reference/exact.py against direct numerical solutions."""

import numpy as np
import pytest
from reference import exact, steady_u, straight_rod, waving
from scipy.linalg import eigh

from warp_rods.theory.elements import clamped_elements


@pytest.mark.parametrize("length, radius", [(0.5, 1.0), (2.0, 1.0), (9.0, 1.0), (1.0, 1e6)])
def test_sphere_rates_are_the_spectrum_of_the_operator(length, radius, verified):
    space = clamped_elements(8)
    operator = space.second / length**2 + space.value / radius**2
    weights = space.weights[:, None]
    stiff, mass = operator.T @ (weights * operator), space.value.T @ (weights * space.value)
    # The mass matrix is the ill-conditioned one, so solve for the inverse rates.
    spectrum = 1 / eigh(mass, stiff, eigvals_only=True)[::-1]
    rates = exact.sphere_decay_rates(0.1, 2.0, 0.3, radius, length, 6)
    verified(
        "independent", f"decay rates on a sphere in closed form, L/R = {length / radius:g}", measured=rates,
        expected=spectrum[:6] * 0.1 / (2.0 + 0.3 / radius**2), relative=1e-9, reference="spectrum by finite elements",
    )  # fmt: skip


def test_a_large_sphere_is_a_plane():
    sphere = exact.sphere_decay_rates(0.1, 2.0, 0.3, 1e6, 1.2, 5)
    np.testing.assert_allclose(sphere, exact.beam_decay_rates(0.1, 2.0, 1.2, 5), rtol=1e-9)


@pytest.mark.parametrize(
    "stiffness, intrinsic",
    [
        ((1, 1), (0.4, 0.2)),
        ((1, 2), (0.0, 0.6)),
        ((2, 1), (-0.7, 0.1)),
        ((1, 1), (0.0, 0.3)),
        ((3, 1), (0.2, 1.0)),
    ],
)
def test_cylinder_angles_are_the_minima(stiffness, intrinsic):
    angles = exact.cylinder_angles(stiffness, intrinsic, 0.8)
    scan = np.linspace(-np.pi / 2, np.pi / 2, 4001)[1:]
    energy = exact.cylinder_energy(scan, stiffness, intrinsic, 0.8)
    minima = (energy <= np.roll(energy, 1)) & (energy < np.roll(energy, -1))
    assert len(angles) == minima.sum()
    np.testing.assert_allclose(np.sort(angles), scan[minima], atol=1e-3)
    assert exact.cylinder_energy(angles[0], stiffness, intrinsic, 0.8) <= energy.min() + 1e-12


def test_two_cylinder_angles_are_degenerate_without_intrinsic_twist():
    """cos 2α = B2(2Rσ2 − 1)/(B2 − B1), where B2 > B1. The sign of σ1 selects the handedness."""
    radius, sigma = 1.3, 0.5
    angles = exact.cylinder_angles((1.0, 2.5), (0.0, sigma), radius)
    expected = 0.5 * np.arccos(2.5 * (2 * radius * sigma - 1) / 1.5)
    np.testing.assert_allclose(np.sort(angles), [-expected, expected], atol=1e-12)
    for hand in (-1, 1):
        assert hand * exact.cylinder_angles((1.0, 2.5), (0.1 * hand, sigma), radius)[0] > 0


def test_the_numbers_of_the_steady_u_are_those_of_a_boundary_value_problem():
    """To the four digits stated."""
    for bend, known in exact.STEADY_U.items():
        np.testing.assert_allclose(steady_u.amplitude_and_speed(bend), known, atol=5e-4, rtol=0)


@pytest.mark.long
def test_the_fold_of_the_u_is_that_of_a_boundary_value_problem():
    assert steady_u.fold() == pytest.approx(exact.SADDLE_NODE, abs=5e-7)


@pytest.mark.long
def test_the_onset_of_waving_is_that_of_a_galerkin_method():
    assert waving.hopf() == pytest.approx(exact.HOPF, abs=5e-8)


def test_critical_stiffnesses_are_those_of_shooting_and_quadrature():
    """To the digits stated; all ten of (4.45), (4.47) in test_stability.py."""
    assert straight_rod.beam_mode_stiffness("tanh") == pytest.approx(exact.CRITICAL_BEND_BEAM_MODE, abs=5e-7)
    assert straight_rod.critical_stiffnesses(1, "tanh")[0] == pytest.approx(exact.CRITICAL_BEND_TANH, abs=5e-8)

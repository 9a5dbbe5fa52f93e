"""Linear theory: Airy conditions, spectra, growth rates of beam modes, and the linearisation of a nonlinear rod."""

import numpy as np
import pytest
from reference import exact
from reference.straight_rod import beam_mode_stiffness, critical_stiffnesses

import warp_rods.theory.stability as stability
from warp_rods.rods import modes
from warp_rods.theory.tension import planar_tension


def test_airy_roots_to_six_digits(verified):
    verified(
        "independent", "critical stiffnesses of (4.45), (4.47), ten", measured=stability.critical_stiffness(10),
        expected=critical_stiffnesses(10, "piecewise"), relative=1e-9,
        reference="b k'' = λk − A − Bs by shooting (tests/reference/straight_rod.py)",
    )  # fmt: skip
    np.testing.assert_allclose(stability.critical_stiffness(10), exact.AIRY_STIFFNESSES, rtol=5e-6)
    verified(
        "published", "first critical stiffness, text after (4.47)", measured=stability.critical_stiffness(1)[0],
        expected=1.1e-2, within=0.05e-2, reference="dissertation §4.3: 1.1e-2",
    )  # fmt: skip


def test_airy_roots_are_where_the_operator_is_singular(verified):
    """Two independent methods: Airy integrals, and a Galerkin eigenvalue problem for μ = 0."""
    airy = stability.airy_stiffnesses(30)
    assert np.all(np.diff(airy) < 0)
    verified(
        "independent", "critical stiffnesses of (4.45), (4.47), thirty", measured=airy,
        expected=stability.marginal_stiffnesses(30, "piecewise", intervals=16), relative=1e-9,
        reference="eigenvalues 0 of (4.37) by finite elements",
    )  # fmt: skip


@pytest.mark.parametrize("index", range(6))
def test_an_eigenvalue_vanishes_at_each_airy_root(index):
    bend = stability.airy_stiffnesses(6)[index]
    values, curves = stability.eigenmodes(bend, np.linspace(-0.5, 0.5, 65), "piecewise", count=10)
    marginal = np.argmin(np.abs(values))
    assert abs(values[marginal]) < 1e-9
    airy = stability.airy_mode(index, np.linspace(-0.5, 0.5, 65))
    np.testing.assert_allclose(curves[marginal], airy, atol=1e-8)


def test_airy_modes_are_normalised_and_free_at_the_ends():
    nodes, weights = np.polynomial.legendre.leggauss(60)
    for index in range(6):
        mode = stability.airy_mode(index, np.append(nodes / 4 + 0.25, nodes / 4 - 0.25))
        assert abs(np.tile(weights, 2) / 4 @ mode**2 - 1) < 1e-12
        assert abs(stability.airy_mode(index, 0.5)) < 1e-14
        assert abs(stability.airy_mode(index, 0.5 - 1e-6)) < 1e-8


def test_critical_bend_of_the_smooth_profile(verified):
    bend = stability.marginal_stiffnesses()[0]
    verified(
        "independent", "critical stiffness of (4.37), f = −tanh 10s", measured=bend,
        expected=critical_stiffnesses(1, "tanh")[0], relative=1e-9, reference="b k'' = λk − A by shooting",
    )  # fmt: skip
    assert bend == pytest.approx(exact.CRITICAL_BEND_TANH, rel=1e-5)
    assert abs(stability.eigenvalues(bend)[0]) < 1e-9
    assert stability.eigenvalues(0.99 * bend)[0].real > 0 > stability.eigenvalues(1.01 * bend)[0].real


def test_growth_rate_of_single_beam_modes(verified):
    bend = stability.beam_mode_critical_stiffness()
    verified(
        "independent", "stiffness at which beam mode 0 neither grows nor decays", measured=bend,
        expected=beam_mode_stiffness("tanh"), relative=1e-9, reference="∫ φ₀'' λφ₀ ds/x₀⁴ by Gauss' rule",
    )  # fmt: skip
    verified(
        "published", "first critical stiffness, full equations", measured=bend, expected=1.0e-2, within=0.05e-2,
        reference="dissertation §4.3: 1.0e-2, as β⊥ where beam mode 0 neither grows nor decays; C.2 prints .0101",
    )  # fmt: skip
    assert abs(stability.beam_mode_growth_rate(bend)) < 1e-12
    for k in range(4):
        passive = stability.beam_mode_growth_rate(0.3, lambda s: 0 * s, drag_ratio=1.5, mode=k)
        np.testing.assert_allclose(passive, -exact.beam_decay_rates(0.3, 1.5, 1.0, 4)[k], rtol=1e-11)


def test_a_passive_rod_decays_in_beam_modes(verified):
    s = np.linspace(-0.5, 0.5, 33)
    values, curves = stability.eigenmodes(1e-2, s, lambda s: 0 * s, drag_ratio=2.0)
    verified(
        "exact", "spectrum of a passive rod, six eigenvalues", measured=values.real,
        expected=-exact.beam_decay_rates(1e-2, 2.0, 1.0, 6), relative=1e-10, reference="−(b/η) x_k⁴",
    )  # fmt: skip
    assert not values.imag.any()
    np.testing.assert_allclose(curves, [modes.beam_mode(k, s) for k in range(6)], atol=1e-9)


@pytest.mark.parametrize("activity", ["tanh", "piecewise"])
def test_eigenvalues_do_not_depend_on_the_elements(activity):
    coarse, fine = (stability.eigenvalues(1e-3, activity, intervals=m) for m in (6, 16))
    np.testing.assert_allclose(coarse, fine, atol=1e-9 * np.abs(fine).max())


def test_activity_as_values_on_nodes():
    s = np.linspace(-0.5, 0.5, 257)
    found = stability.eigenvalues(1e-3, -np.tanh(10 * s))
    np.testing.assert_allclose(found, stability.eigenvalues(1e-3), atol=1e-6)


def test_a_uniformly_pushed_rod_is_stable():
    """f = 1 leaves no tension but advection (4.36), which makes eigenvalues complex without any growth."""
    values = stability.eigenvalues(1e-3, "uniform")
    assert np.all(values.real < 0) and np.abs(values.imag).max() > 1
    assert len(stability.marginal_stiffnesses(3, "uniform")) == 0


def rod_rate(nodes: int, bend: float, drag_ratio: float):
    """Right-hand side of (4.32) with f = −tanh 10s held fixed, at the inner nodes."""
    s = np.linspace(-0.5, 0.5, nodes)
    f, spacing = -np.tanh(10 * s), 1 / (nodes - 1)

    def second(field):
        return (field[2:] - 2 * field[1:-1] + field[:-2]) / spacing**2

    def rate(inner):
        κ = np.pad(inner, 1)
        λ = planar_tension(κ, f, bend, drag_ratio)
        mirrored = np.pad(κ, 1, mode="reflect")
        push = (λ[1:] - λ[:-1]) / spacing + (f[1:] + f[:-1]) / 2
        advected = np.diff((κ[1:] + κ[:-1]) / 2 * push) / spacing
        return (
            -bend / drag_ratio * second(second(mirrored))
            + second(κ * λ) / drag_ratio
            + advected
            + bend / 3 * second(κ**3)
        )

    return rate


def test_linearising_a_nonlinear_rod_gives_the_spectrum(verified):
    expected = stability.eigenvalues(5e-3, count=4).real
    errors = []
    for nodes in (33, 65, 129):
        found = stability.growth_rates(rod_rate(nodes, 5e-3, 2.0), np.zeros(nodes - 2), count=4)
        errors.append(np.abs(found - expected) / np.abs(expected).max())
    assert np.max(errors[-1]) < 4e-3
    slope = np.polyfit(np.log([32, 64, 128]), np.log(np.max(errors, axis=1)), 1)[0]
    verified.order(
        "spectrum of (4.32) discretised in NumPy: order in Δs", measured=-slope, reference="eigenvalues of (4.37)"
    )


def test_growth_rates_of_a_known_spiral(verified):
    found = stability.growth_rates(lambda x: [x[1] + x[0] ** 2, -4 * x[0] - 2 * x[1], 3 * x[2]], np.zeros(3))
    exact = np.array([3, -1 + 1j * 3**0.5, -1 - 1j * 3**0.5])
    verified.below(
        "exact", "eigenvalues by differences: a spiral and a saddle", measured=np.abs(found - exact), bound=1e-5,
        reference="3, −1 ± i√3",
    )  # fmt: skip


def test_stiffness_of_a_real_cell(verified):
    published = {10e-6: (3.6e-25, 0.05e-25), 50e-6: (2.6e-23, 0.05e-23), 100e-6: (1.8e-22, 0.05e-22)}
    for length, (stiffness, half_a_digit) in published.items():
        found = stability.critical_stiffness(length=length, diameter=1e-6, viscosity=1e-3, speed=13e-6)
        verified(
            "published", f"critical stiffness of a cell of {1e6 * length:g} µm, N m²", measured=found,
            expected=stiffness, within=half_a_digit, reference=f"dissertation C.2: {stiffness:.1e}",
        )  # fmt: skip


def test_wrong_arguments_are_named():
    with pytest.raises(ValueError, match="length > diameter"):
        stability.critical_stiffness(1e-6, 2e-6, 1e-3, 13e-6)
    with pytest.raises(ValueError, match="at least one"):
        stability.critical_stiffness(0)
    with pytest.raises(ValueError, match="tanh, piecewise, uniform"):
        stability.eigenvalues(1e-3, "wiggly")

"""Beam modes and harmonics against their defining properties."""

import numpy as np
import pytest
from reference import exact

from warp_rods.rods import modes


def gauss(points: int):
    nodes, weights = np.polynomial.legendre.leggauss(points)
    return nodes / 2, weights / 2


def test_roots_solve_the_characteristic_equation(verified):
    ours = [modes.beam_root(k) for k in range(8)]
    verified(
        "exact", "roots x_k of beam modes, eight", measured=ours, expected=exact.beam_roots(8), relative=1e-12,
        reference="cos x cosh x = 1, by bisection",
    )  # fmt: skip
    assert abs(ours[0] - 4.730040744862704) < 1e-14


@pytest.mark.parametrize("family", [modes.beam_mode, modes.harmonic])
def test_orthonormal_up_to_mode_50(family, verified):
    s, weights = gauss(120)
    table = np.array([family(k, s) for k in range(51)])
    error = np.abs((table * weights) @ table.T - np.eye(51)).max()
    name = f"orthonormality of 51 {family.__name__.replace('_', ' ')}s"
    verified.below("exact", name, measured=error, bound=1e-12, reference="∫ φ_j φ_k ds = δ_jk by Gauss' rule")


@pytest.mark.parametrize("k", [0, 1, 2, 7, 24, 50])
def test_beam_mode_is_an_eigenfunction_with_free_ends(k):
    s = np.linspace(-0.5, 0.5, 101)
    root = modes.beam_root(k)
    fourth = modes.beam_mode_derivative(k, s, 4)
    np.testing.assert_allclose(fourth / root**4, modes.beam_mode(k, s), atol=1e-12)
    ends = np.array([-0.5, 0.5])
    np.testing.assert_allclose(modes.beam_mode(k, ends), 0.0, atol=1e-12)
    np.testing.assert_allclose(modes.beam_mode_derivative(k, ends) / root, 0.0, atol=1e-12)


@pytest.mark.parametrize("k", [0, 1, 6, 13])
def test_derivatives_match_central_differences(k):
    s, step = np.linspace(-0.45, 0.45, 31), 1e-5
    for order in range(4):
        ahead = modes.beam_mode_derivative(k, s + step, order)
        behind = modes.beam_mode_derivative(k, s - step, order)
        scale = modes.beam_root(k) ** (order + 1)
        slope = modes.beam_mode_derivative(k, s, order + 1)
        np.testing.assert_allclose((ahead - behind) / (2 * step * scale), slope / scale, atol=1e-6)


@pytest.mark.parametrize("family", [modes.beam_mode, modes.harmonic])
@pytest.mark.parametrize("k", range(6))
def test_parity_and_sign(family, k):
    s = np.linspace(-0.5, 0.5, 41)
    np.testing.assert_allclose(family(k, -s), (-1) ** k * family(k, s), atol=1e-13)
    assert family(k, 0.0) > 0.5 if k % 2 == 0 else family(k, 0.01) > 0


def test_first_mode_at_the_middle():
    assert abs(modes.beam_mode(0, 0.0) - 1.58815) < 5e-6


def test_coefficients_of_a_batch_are_the_amplitudes_it_was_made_of():
    s = np.linspace(-0.5, 0.5, 65)
    amplitudes = np.random.default_rng(1).normal(size=(2, 3, 6))
    curvature = amplitudes @ np.array([modes.beam_mode(k, s) for k in range(6)])
    np.testing.assert_allclose(modes.coefficients(curvature, s, 6), amplitudes, atol=1e-4)
    twist = amplitudes @ np.array([modes.harmonic(k, s) for k in range(6)])
    np.testing.assert_allclose(modes.harmonic_coefficients(twist, s, 6), amplitudes, atol=1e-12)


def test_order_of_the_quadrature(verified):
    """∫cos(πs) φ₀ ds = 2π φ₀''(½)/(x⁴ − π⁴), by parts; fourth order, because φ₀ has double zeros at the ends."""
    x = modes.beam_root(0)
    exact_value = 2 * np.pi * modes.beam_mode_derivative(0, 0.5, 2) / (x**4 - np.pi**4)
    nodes = np.array([17, 33, 65, 129])
    errors = []
    for n in nodes:
        s = np.linspace(-0.5, 0.5, n)
        errors.append(abs(modes.coefficients(np.cos(np.pi * s), s, 1)[0] - exact_value))
    slope = np.polyfit(np.log(nodes - 1), np.log(errors), 1)[0]
    verified.order(
        "coefficients of beam modes: order of the quadrature", measured=-slope, expected=4, reference="∫ cos πs φ₀ ds"
    )


def test_negative_mode_is_refused():
    with pytest.raises(ValueError, match="counted from 0"):
        modes.beam_mode(-1, 0.0)

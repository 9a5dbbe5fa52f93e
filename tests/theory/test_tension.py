"""The Fredholm series of the tension against the direct solution and an exact one."""

import numpy as np
import pytest

from warp_rods.rods import modes
from warp_rods.theory.tension import planar_tension, series_ratio, tension_series

S = np.linspace(-0.5, 0.5, 129)
ACTIVITY = -np.tanh(10 * S)


def test_series_converges_to_the_direct_solve(verified):
    curvature = 2.0 * modes.beam_mode(0, S) + 1.0 * modes.beam_mode(1, S)
    direct = planar_tension(curvature, ACTIVITY, 5e-3, 2.0)
    sums = tension_series(curvature, ACTIVITY, 5e-3, 2.0, 60)
    errors = np.abs(sums - direct).max(axis=1)
    verified.below(
        "independent", "tension: Fredholm series (C.9), 60 terms", measured=errors[-1], bound=1e-13,
        reference="direct solution of (4.34)",
    )  # fmt: skip
    ratio = series_ratio(curvature, 2.0)
    assert 0.3 < ratio < 1
    verified(
        "exact", "tension: ratio of late errors of the series", measured=errors[9] / errors[8], expected=ratio,
        relative=0.02, reference="spectral radius of K/η",
    )  # fmt: skip


def test_first_order_in_the_inverse_drag_ratio(verified):
    """(C.11): the error of the first two terms is of order ε²."""
    curvature = 2.0 * modes.beam_mode(0, S)
    ratios = np.array([20.0, 40.0, 80.0])
    errors = []
    for η in ratios:
        two_terms = tension_series(curvature, ACTIVITY, 5e-3, η, 1)[-1]
        errors.append(np.abs(two_terms - planar_tension(curvature, ACTIVITY, 5e-3, η)).max())
    verified.order(
        "tension: order in 1/η of λ₀ + λ₁/η", measured=-np.polyfit(np.log(ratios), np.log(errors), 1)[0],
        reference="(C.11): 2",
    )  # fmt: skip


def test_series_diverges_where_its_ratio_exceeds_one():
    curvature = 6.0 * modes.beam_mode(0, S)
    assert series_ratio(curvature, 2.0) > 1
    steps = np.abs(np.diff(tension_series(curvature, ACTIVITY, 5e-3, 2.0, 40), axis=0)).max(axis=1)
    assert steps[-1] > steps[0]


@pytest.mark.parametrize("method", ["direct", "series"])
def test_convergence_to_an_exact_tension_is_second_order(method, verified):
    """With κ = cos²πs and λ = cos πs, (4.34) is an equation for f, which is integrated here in closed form."""
    bend, drag_ratio, sizes = 0.7, 1.6, np.array([32, 64, 128])
    errors = []
    for size in sizes:
        s = np.linspace(-0.5, 0.5, size + 1)
        c, d = np.cos(np.pi * s), np.sin(np.pi * s)
        κ2_slope = -4 * np.pi * c**3 * d
        # ∫κκ'' = κκ' − ∫κ'²,  κ' = −π sin 2πs;  ∫κ²λ = ∫cos⁵πs
        κκ2 = -2 * np.pi * c**3 * d - np.pi**2 * (s / 2 - np.sin(4 * np.pi * s) / (8 * np.pi))
        κ2λ = (d - 2 * d**3 / 3 + d**5 / 5) / np.pi
        f = np.pi * d + κ2λ / drag_ratio - 0.5 * bend * κ2_slope - bend / drag_ratio * κκ2
        arguments = (c**2, f, bend, drag_ratio)
        tension = planar_tension(*arguments) if method == "direct" else tension_series(*arguments, 30)[-1]
        errors.append(np.abs(tension - c).max())
    verified.order(
        f"tension, {method}: order in Δs", measured=-np.polyfit(np.log(sizes), np.log(errors), 1)[0],
        reference="λ = cos πs for κ = cos² πs and the f that (4.34) demands",
    )  # fmt: skip

"""Batched banded solves against LAPACK: random, badly scaled, small, stiff and singular systems."""

import numpy as np
import pytest
import warp as wp
from reference.banded import backward_error, biharmonic, dominant, lapack, off_the_rod

from warp_rods.kernels import banded
from warp_rods.kernels.layout import per_node, real

EPSILON = np.finfo(float).eps
BANDS = [3, 5]
SIZES = [(1, 3), (1, 4), (2, 5), (1, 65), (50, 33), (3, 257)]
"""Systems and rows."""
BANDED = {3: "tridiagonal", 5: "pentadiagonal"}


def uploaded(values: np.ndarray, dtype, device) -> wp.array:
    array = per_node(*values.shape[:2], dtype, device)
    array.assign(values)
    return array


def solve(coefficients: np.ndarray, right: np.ndarray, device, in_place: bool = False) -> np.ndarray:
    """Solutions of the systems [band, rod, node] by the kernels; checks that the coefficients do not change."""
    bands, rods, nodes = coefficients.shape
    dtype = real if right.ndim == 2 else wp.vec2d
    kernel = banded.solve_tridiagonal if bands == 3 else banded.solve_pentadiagonal
    rows = [uploaded(band, real, device) for band in coefficients]
    given = uploaded(right, dtype, device)
    solution = given if in_place else per_node(rods, nodes, dtype, device)
    work = per_node(rods, nodes, real if bands == 3 else wp.vec2d, device)
    wp.launch(kernel, rods, [*rows, given, work, solution], device=device)
    for row, band in zip(rows, coefficients, strict=True):
        np.testing.assert_array_equal(row.numpy(), band)
    return solution.numpy()


@pytest.mark.parametrize("bands", BANDS)
def test_random_systems_agree_with_lapack(bands, device, verified):
    backward, apart = [], []
    for rods, nodes in SIZES:
        rng = np.random.default_rng(bands * nodes)
        coefficients, right = dominant(rng, bands, rods, nodes), rng.normal(size=(rods, nodes))
        x = solve(coefficients, right, device)
        backward.append(backward_error(coefficients, x, right))
        apart.append(abs(x - lapack(coefficients, right)).max() / abs(x).max())
    name = f"{BANDED[bands]} solve of random systems of 3 to 257 rows"
    verified.below(
        "independent", f"{name}: backward error", measured=backward, bound=8 * EPSILON, reference="8 · 2.2e-16"
    )
    verified.below(
        "independent", f"{name}: solution, relative", measured=apart, bound=1e-13,
        reference="LAPACK (SciPy's `solve_banded`)",
    )  # fmt: skip


@pytest.mark.parametrize("bands", BANDS)
@pytest.mark.parametrize("rods", [1, 20])
def test_rows_scaled_by_up_to_eight_decades(bands, rods, device):
    rng = np.random.default_rng(bands)
    coefficients, right = dominant(rng, bands, rods, 65), rng.normal(size=(rods, 65))
    scale = 10 ** rng.uniform(-8, 8, size=(rods, 65))
    x = solve(coefficients * scale, right * scale, device)
    assert backward_error(coefficients * scale, x, right * scale) < 8 * EPSILON
    # Scaling the rows changes the order of pivoting, but not elimination without it: compare with the unscaled system.
    np.testing.assert_allclose(x, lapack(coefficients, right), rtol=0, atol=1e-13 * abs(x).max())


@pytest.mark.parametrize("nodes", [65, 257])
@pytest.mark.parametrize("strength", [5e-6, 5e-3])
def test_implicit_bending_operator(nodes, strength, device, verified):
    coefficients = biharmonic(2, nodes, strength)
    s = np.linspace(0, 1, nodes)
    right = np.stack([np.sin(np.pi * s) ** 2, np.random.default_rng(0).normal(size=nodes)])
    x = solve(coefficients, right, device)
    assert backward_error(coefficients, x, right) < 8 * EPSILON
    condition = 1 + 16 * strength * (nodes - 1) ** 4
    difference = np.linalg.norm(x - lapack(coefficients, right)) / np.linalg.norm(x)
    verified.below(
        "independent", f"1 + {strength:g} ∂⁴ at {nodes} nodes: difference over the condition number",
        measured=difference / condition, bound=8 * EPSILON, reference="LAPACK",
    )  # fmt: skip


@pytest.mark.parametrize("bands", BANDS)
def test_pairs_have_the_bits_of_two_scalar_solves(bands, device):
    rng = np.random.default_rng(5)
    coefficients, right = dominant(rng, bands, 7, 65), rng.normal(size=(7, 65, 2))
    pairs = solve(coefficients, right, device)
    for component in (0, 1):
        alone = solve(coefficients, right[:, :, component], device)
        np.testing.assert_array_equal(pairs[:, :, component], alone)
    assert backward_error(coefficients, pairs, right) < 8 * EPSILON


@pytest.mark.parametrize("bands", BANDS)
@pytest.mark.parametrize("tail", [(), (2,)])
def test_the_solution_may_replace_the_right_hand_side(bands, tail, device):
    rng = np.random.default_rng(6)
    coefficients, right = dominant(rng, bands, 4, 17), rng.normal(size=(4, 17, *tail))
    apart = solve(coefficients, right, device)
    np.testing.assert_array_equal(solve(coefficients, right, device, in_place=True), apart)


def test_the_upper_diagonal_may_be_the_work_array(device):
    rng = np.random.default_rng(7)
    coefficients, right = dominant(rng, 3, 4, 17), rng.normal(size=(4, 17))
    lower, diagonal, upper, given = (uploaded(v, real, device) for v in (*coefficients, right))
    wp.launch(banded.solve_tridiagonal, 4, [lower, diagonal, upper, given, upper, given], device=device)
    np.testing.assert_array_equal(given.numpy(), solve(coefficients, right, device))


@pytest.mark.parametrize("bands", BANDS)
@pytest.mark.parametrize("nodes", [3, 4, 5, 33])
def test_coefficients_off_the_rod_are_ignored(bands, nodes, device):
    rng = np.random.default_rng(8)
    coefficients, right = dominant(rng, bands, 2, nodes), rng.normal(size=(2, nodes))
    padded = np.where(off_the_rod(bands, nodes)[:, None, :], np.nan, coefficients)
    np.testing.assert_array_equal(solve(padded, right, device), solve(coefficients, right, device))


@pytest.mark.parametrize("bands", BANDS)
def test_a_zero_pivot_affects_its_own_rod_only(bands, device):
    rng = np.random.default_rng(9)
    coefficients, right = dominant(rng, bands, 3, 33), rng.normal(size=(3, 33))
    expected = solve(coefficients, right, device)
    coefficients[bands // 2, 1, 0] = 0.0
    x = solve(coefficients, right, device)
    assert not np.isfinite(x[1]).all()
    np.testing.assert_array_equal(x[[0, 2]], expected[[0, 2]])


@pytest.mark.parametrize("bands", BANDS)
def test_a_rod_does_not_depend_on_its_batch(bands, device, verified):
    rng = np.random.default_rng(10)
    coefficients, right = dominant(rng, bands, 40, 65), rng.normal(size=(40, 65))
    together = solve(coefficients, right, device)
    alone = solve(coefficients[:, 17:18], right[17:18], device)
    verified.same(f"{BANDED[bands]} solve of one system alone and among 40", alone, together[17:18], reference="of 40")

"""wr.frames: path-ordered products by each rule, their orders, and strains from frames."""

import numpy as np
import pytest
from examples.framed_curve import curve
from examples.free import slope
from reference import lie as reference
from scipy.integrate import cumulative_simpson

import warp_rods as wr
from warp_rods import frames
from warp_rods.frames.products import RULES

ORDERS = {"forward": 1, "mean": 2, "midpoint": 2, "magnus": 4}
FINE = np.linspace(-0.5, 0.5, 8193)
STRETCH = np.stack([1 + 0.3 * np.sin(4 * FINE), 0.2 * FINE, np.cos(3 * FINE)], axis=-1)
PLACES = cumulative_simpson(np.einsum("nij,nj->ni", curve(FINE)[0], STRETCH), x=FINE, axis=0, initial=0.0)
"""An extensible, shearable framed curve: ∂s r = R U."""


def every(cells: int, offset: int = 0) -> slice:
    return slice(offset, None, (len(FINE) - 1) // cells)


def test_every_rule_is_in_this_table():
    assert ORDERS.keys() == RULES.keys()


@pytest.mark.parametrize("rule", ORDERS)
def test_order_of_each_rule(rule, verified):
    """With the printed sign of the commutator in (4.27), −½, "magnus" would be of order 2."""
    sizes, errors = [16, 32, 64, 128], []
    for cells in sizes:
        at = every(cells)
        R, r = curve(FINE[at])[0], PLACES[at]
        given = every(cells, (len(FINE) - 1) // cells // 2) if rule == "midpoint" else at
        start = cells // 4
        found = frames.path_product(
            curve(FINE[given])[1], 1 / cells, STRETCH[given], rule=rule, start=start, R=R[start], r=r[start]
        )
        errors.append((abs(found[0] - R).max(), abs(found[1] - r).max()))
    verified.order(
        f"wr.frames.path_product, rule {rule}: order in Δs of frames and places", expected=ORDERS[rule],
        measured=[slope(sizes, [e[k] for e in errors]) for k in (0, 1)],
        reference="a rotation in closed form, Simpson's rule",
    )  # fmt: skip


def test_products_equal_those_of_matrix_exponentials():
    """Two curves at once, each with its own spacing, from an inner node."""
    rng = np.random.default_rng(1)
    strain, spacing = rng.normal(size=(2, 9, 3)) * 3, np.array([0.1, 0.07])
    R0 = frames.rotation_exp(rng.normal(size=(2, 3)))
    r0 = rng.normal(size=(2, 3))
    R, r = frames.path_product(strain, spacing, start=4, R=R0, r=r0)
    seeds = np.repeat(R0[:, None], 9, axis=1), np.repeat(r0[:, None], 9, axis=1)
    R_twin, r_twin = reference.integrate_frames(strain, spacing, 4, *seeds)
    np.testing.assert_allclose(R, R_twin, atol=3e-15)
    np.testing.assert_allclose(r, r_twin, atol=3e-15)


@pytest.mark.parametrize("rule", ORDERS)
def test_constant_strain_is_exact(rule):
    cells = 4 if rule == "midpoint" else 5
    omega, u = np.array([1.5, -2.0, 3.0]), np.array([1.1, 0.2, -0.3])
    R, r = frames.path_product(np.tile(omega, (cells, 1)), 0.2, u, rule=rule)
    exact = frames.se3_exp(0.8 * omega, 0.8 * u)
    np.testing.assert_allclose(R[-1], exact[0], atol=3e-15)
    np.testing.assert_allclose(r[-1], exact[1], atol=3e-15)


def test_strains_of_frames_invert_the_product():
    omega, u = np.random.default_rng(2).normal(size=(2, 3, 8, 3))
    found = frames.strain_of_frames(*frames.path_product(omega, 0.3, u, rule="midpoint"), 0.3)
    np.testing.assert_allclose(found[0], omega, atol=1e-13)
    np.testing.assert_allclose(found[1], u, atol=1e-13)


def test_the_frames_of_a_run_of_free_rods(device):
    """Frames of an ensemble are the product of its strains by the mean, from the middle outwards."""
    rods = wr.FreeRods(
        2, 33, bend=1e-3, twist=1e-3, shape={"kind": "writhe", "amplitude": 3.0}, moment=5e-3, device=device
    )
    rods.step(1e-3, 5)
    R = frames.from_quaternion(rods.orientation)
    bishop, angle = frames.bishop_strain(rods.strain, 1 / 32, start=16)
    R_bishop, r = frames.path_product(bishop, 1 / 32, start=16, R=R[:, 16], r=rods.position[:, 16])
    np.testing.assert_allclose(r, rods.position, atol=1e-13)
    np.testing.assert_allclose(frames.turned(R_bishop, angle), R, atol=1e-13)


@pytest.mark.parametrize(
    "arguments, words",
    [
        ({"rule": "euler"}, "rule = 'euler': must be one of forward, mean, midpoint, magnus"),
        ({"rule": "magnus"}, "strain: must have 4 nodes or more"),
        ({"start": 3}, "start = 3: must be a node, 0 to 2"),
        ({"spacing": 0.0}, "spacing = 0: must be positive"),
        ({"spacing": [0.1, 0.2]}, "spacing: must be one number, or one for each curve"),
    ],
)
def test_wrong_arguments_are_named(arguments, words):
    with pytest.raises(wr.SceneError, match=words):
        frames.path_product(**({"strain": np.zeros((3, 3)), "spacing": 0.1} | arguments))

"""wr.frames: Frenet, Bishop and material strains and frames, and how they turn into each other (3.49) to (3.61)."""

import numpy as np
import pytest
from examples.free import slope

import warp_rods as wr
from warp_rods import frames


def intrinsic(nodes: int) -> tuple[np.ndarray, ...]:
    """s, κ > 0, τ, θ of a rod, and the exact strain of the frame that is turned by θ from Frenet's."""
    s = np.linspace(0.0, 1.0, nodes)
    k, tau, theta = 2 + np.sin(3 * s), np.cos(2 * s) - 1.5 * s, 4 * s + np.sin(5 * s)
    rate = 4 + 5 * np.cos(5 * s)
    return s, k, tau, theta, np.stack([tau + rate, k * np.sin(theta), k * np.cos(theta)], axis=-1)


def test_frenet_strains_from_material_ones_and_back_are_second_order(verified):
    sizes, errors = [33, 65, 129, 257], []
    for nodes in sizes:
        _, k, tau, theta, strain = intrinsic(nodes)
        ds = 1 / (nodes - 1)
        found = frames.frenet_strain(np.stack([strain, 2 * strain]), [ds, ds / 2])
        np.testing.assert_allclose(found.curvature, [k, 2 * k], rtol=1e-14)
        np.testing.assert_allclose(found.angle, [theta, theta], atol=1e-13)
        np.testing.assert_allclose(found.torsion[1], 2 * found.torsion[0], rtol=1e-12)
        back = frames.material_strain(k, tau, theta, ds)
        errors.append((abs(found.torsion[0] - tau).max(), abs(back - strain).max()))
    verified.order(
        "wr.frames: torsion of a material strain (3.59), strain of κ, τ, θ (3.53): order in Δs",
        measured=[slope(np.array(sizes) - 1, [e[i] for e in errors]) for i in (0, 1)], reference="closed forms",
    )  # fmt: skip


def test_turning_a_frame_turns_its_strain():
    """(3.52) to (3.54) on frames: the product of the turned strain is the turned frame, to fourth order."""
    _, _, tau, theta, strain = intrinsic(257)
    k = np.hypot(strain[:, 1], strain[:, 2])
    frenet = np.stack([tau, 0 * k, k], axis=-1)
    F, r = frames.path_product(frenet, 1 / 256, rule="magnus")
    R, q = frames.path_product(strain, 1 / 256, rule="magnus", R=frames.turned(np.eye(3), theta[0]))
    np.testing.assert_allclose(q, r, atol=1e-8)
    np.testing.assert_allclose(R, frames.turned(F, theta), atol=1e-7)
    np.testing.assert_allclose(frames.angle_between(F, R), theta, atol=1e-7)
    np.testing.assert_allclose(frames.frenet_of_frame(R, strain), F, atol=1e-7)  # (3.55) to (3.57)
    np.testing.assert_allclose(frames.turned_strain(frenet, theta, 1 / 256)[:, 1:], strain[:, 1:], atol=1e-13)
    np.testing.assert_allclose(frames.turned_strain(frenet, theta, 1 / 256)[:, 0], strain[:, 0], atol=2e-3)


def test_the_bishop_strain_has_no_twist_and_its_frame_the_same_centre_line(verified):
    sizes, errors = [65, 129, 257], []
    for nodes in sizes:
        s, _, _, _, strain = intrinsic(nodes)
        ds, start = 1 / (nodes - 1), nodes // 2
        bishop, angle = frames.bishop_strain(strain, ds, start)
        assert (bishop[:, 0] == 0).all() and angle[start] == 0
        np.testing.assert_allclose(np.linalg.norm(bishop, axis=1), np.hypot(strain[:, 1], strain[:, 2]), rtol=1e-14)
        exact = np.sin(2 * s) / 2 - 0.75 * s**2 + 4 * s + np.sin(5 * s)  # ∫ τ + θ′ ds
        R, r = frames.path_product(strain, ds, start=start)
        B, q = frames.path_product(bishop, ds, start=start)
        turns = (angle[-1] - angle[0]) / (2 * np.pi)
        assert frames.twist_of_strain(strain, ds) == pytest.approx(turns, rel=1e-13)
        assert abs(frames.twist(B)) < 1e-13  # each cell turns about an axis across the tangent, the shortest way
        twist = abs(frames.twist(R) - (exact[-1] - exact[0]) / (2 * np.pi))
        apart = abs(angle - exact + exact[start]).max(), abs(q - r).max(), abs(frames.turned(B, angle) - R).max()
        errors.append([*apart, twist])
    verified.order(
        "wr.frames: Bishop angle, frame and centre line of a material strain, and its twist: order in Δs",
        measured=[slope(np.array(sizes) - 1, column) for column in zip(*errors, strict=True)],
        reference="a twist in closed form, the product of the material strain",
    )  # fmt: skip


def test_signs_of_a_helix():
    """A right-handed helix of radius a and pitch 2πh: κ = a/(a² + h²), τ = h/(a² + h²) > 0."""
    a, h = 0.3, 0.2
    k, tau = a / (a * a + h * h), h / (a * a + h * h)
    s = np.linspace(0, 4, 401)
    _, r = frames.path_product(np.tile([tau, 0.0, k], (401, 1)), 0.01)
    axis = np.array([tau, 0.0, k]) / np.hypot(k, tau)  # Ω is constant in space as well
    np.testing.assert_allclose(r @ axis, s * h / np.hypot(a, h), atol=1e-13)
    assert frames.writhe(r) > 0
    np.testing.assert_allclose(frames.torsion(r)[5:-5], tau, rtol=1e-3)


def test_free_ends_have_no_frenet_frame_and_it_is_said():
    """As κ = 0 there, τ is NaN with a warning; other nodes have their values."""
    s = np.linspace(-0.5, 0.5, 65)
    bending = np.cos(np.pi * s)
    bending[[0, -1]] = 0
    strain = np.stack([0 * s + 0.7, 0 * s, bending], axis=-1)
    with pytest.warns(RuntimeWarning, match=r"frenet_strain: the curvature is zero at 2 nodes, first at \[0\]"):
        found = frames.frenet_strain(strain, 1 / 64)
    assert np.isnan(found.torsion[[0, -1]]).all() and np.isnan(found.angle[[0, -1]]).all()
    np.testing.assert_allclose(found.torsion[1:-1], 0.7)
    with pytest.warns(RuntimeWarning, match="frenet_of_frame: the curvature is zero at 1 nodes"):
        assert np.isnan(frames.frenet_of_frame(np.eye(3), [0.7, 0.0, 0.0])[:, 1:]).all()


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda s: frames.frenet_strain(s[:2], 0.1), "strain: must have 3 nodes or more"),
        (lambda s: frames.bishop_strain(s, 0.1, 9), "start = 9: must be a node, 0 to 4"),
        (lambda s: frames.frenet_strain(s, [0.1, 0.2]), "spacing: must be one number, or one for each curve"),
        (
            lambda s: frames.angle_between(np.eye(3)[None], frames.rotation_exp([[0, 0, 1.0]])),
            r"Q\[0\]: must have the tangent",
        ),
        (lambda s: frames.turned(2 * np.eye(3), 0.1), "R: must be a rotation"),
        (lambda s: frames.material_strain(1.0, 0.0, 0.0, 0.1), "angle: must have 3 nodes or more"),
    ],
)
def test_wrong_arguments_are_named(call, words):
    with pytest.raises(wr.SceneError, match=words):
        call(np.ones((5, 3)))

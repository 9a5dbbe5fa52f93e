"""SO(3) and SE(3): identities of the groups for random elements, including angles near 0 and pi.

References are matrix functions of SciPy and arithmetic with 50 digits or more. Tolerances are round-off: a few tens of
2.2e-16, relative to the values compared.
"""

import math

import numpy as np
import pytest
from examples.lie import coefficients, matrices, rotations, screws
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from reference import lie as reference
from scipy.linalg import expm

ROUND_OFF = 1e-14
drawn = settings(deadline=None, derandomize=True, max_examples=40)

tiny = st.floats(-12.0, -3.0).map(lambda p: 10.0**p)
angles = st.one_of(st.just(0.0), tiny, st.floats(0.0, math.pi), tiny.map(lambda d: math.pi - d), st.just(math.pi))
component = st.floats(-1.0, 1.0).map(lambda x: 0.0 if abs(x) < 1e-30 else x)


@st.composite
def rotation_vectors(draw) -> np.ndarray:
    """Rotation vectors of any direction, axes included, and any angle from 0 to pi; 0 and pi are drawn often."""
    direction = np.array([draw(component) for _ in range(3)])
    size = np.linalg.norm(direction)
    assume(size > 0.0)
    return draw(angles) * (direction / size)


vectors = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)
batches = st.lists(rotation_vectors(), min_size=1, max_size=8).map(np.array)
screw_batches = st.lists(
    st.tuples(rotation_vectors(), vectors, rotation_vectors(), vectors, vectors, vectors).map(np.array),
    min_size=1,
    max_size=4,
).map(np.array)


def assert_same_rotation_vector(found: np.ndarray, expected: np.ndarray) -> None:
    """Equal to round-off, or opposite where the angle is pi to round-off."""
    error = np.linalg.norm(found - expected)
    if abs(np.linalg.norm(expected) - math.pi) < ROUND_OFF:
        error = min(error, np.linalg.norm(found + expected))
    assert error <= ROUND_OFF * max(np.linalg.norm(expected), 1e-15)


def test_coefficients_are_exact_to_round_off_on_both_sides_of_the_threshold(device, verified):
    near = 1.0 + np.array([-1e-15, 1e-15, -1e-6, 1e-6, -0.1, 0.1])
    sizes = np.concatenate([10.0 ** np.linspace(-12, 0, 40), near, np.linspace(1.0, 3.1, 30)])
    theta = np.outer(sizes, [1.0, 0.0, 0.0])
    values = coefficients(theta, device)
    expected = np.array([reference.coefficients(size) for size in sizes])
    # 1 - A/(2B) and 1 - A lose about one digit at the threshold; A is compared with 1, its size near 0.
    np.testing.assert_allclose(values[:, 0], expected[:, 0], rtol=0, atol=5e-16)
    error = abs(values[:, 1:] / expected[:, 1:] - 1).max()
    verified.below(
        "independent", "coefficients of exp and log at angles from 1e-12 to 3.1, relative", measured=error, bound=5e-15,
        reference="arithmetic with 50 digits",
    )  # fmt: skip


@drawn
@given(theta=batches)
def test_log_inverts_exp_of_rotation_vectors(device, theta):
    R, _, _, log, _ = rotations(theta, device)
    for i, vector in enumerate(theta):
        np.testing.assert_allclose(R[i], reference.rotation_exp(vector), rtol=0, atol=2e-15)
        assert_same_rotation_vector(log[i], vector)


@drawn
@given(theta=batches)
def test_exp_inverts_log_of_rotation_matrices(device, theta):
    R = np.array([reference.rotation_exp(vector) for vector in theta])
    log, again, quaternion, orthonormal = matrices(R, device)
    np.testing.assert_allclose(again, R, rtol=0, atol=4e-15)
    np.testing.assert_allclose(orthonormal, R, rtol=0, atol=1e-15)
    assert np.all(np.linalg.norm(log, axis=-1) <= math.pi * (1 + 1e-15))
    for i, vector in enumerate(theta):
        assert_same_rotation_vector(log[i], vector)
        half = 0.5 * np.linalg.norm(vector)
        expected = np.append(vector * (0.5 * np.sinc(half / math.pi)), math.cos(half))
        off = min(abs(quaternion[i] - expected).max(), abs(quaternion[i] + expected).max())
        assert off < 2e-15 and quaternion[i, 3] >= 0.0


@pytest.mark.parametrize("axis", [*np.eye(3), [1, 1, 0], [1, -1, 0], [0, 1, -1], [1, 2, 3], [-3, 1e-9, 1]])
def test_an_exact_half_turn_has_an_angle_of_pi(device, axis):
    axis = np.array(axis) / np.linalg.norm(axis)
    log, _, _, _ = matrices(np.array([2.0 * np.outer(axis, axis) - np.eye(3)]), device)
    assert np.linalg.norm(log[0]) == pytest.approx(math.pi, rel=1e-15)
    np.testing.assert_allclose(np.outer(log[0], log[0]), math.pi**2 * np.outer(axis, axis), atol=1e-14)


def test_orthonormalise_keeps_the_tangent_and_hand(device, verified):
    rng = np.random.default_rng(3)
    R = reference.rotation_exp(np.array([0.3, -1.0, 2.0]))
    bent = R * [2.0, 0.5, 3.0] + 0.1 * rng.normal(size=(5, 3, 3))
    _, _, _, Q = matrices(bent, device)
    gram = abs(Q.transpose(0, 2, 1) @ Q - np.eye(3)).max()
    verified.below("constraint", "Gram–Schmidt of five bent frames: QᵀQ − 1", measured=gram, bound=1e-15, reference="0")
    np.testing.assert_allclose(np.linalg.det(Q), 1.0, rtol=2e-15)
    tangent = bent[:, :, 0] / np.linalg.norm(bent[:, :, 0], axis=1, keepdims=True)
    np.testing.assert_allclose(Q[:, :, 0], tangent, rtol=0, atol=5e-16)
    assert np.allclose(np.einsum("bi,bi->b", Q[:, :, 2], bent[:, :, 0]), 0.0, atol=1e-14)


@drawn
@given(theta=batches, change=vectors)
def test_left_jacobian_has_its_inverse_and_is_the_derivative_of_exp(device, theta, change):
    R, V, V_inverse, _, hat = rotations(theta, device)
    for i, vector in enumerate(theta):
        np.testing.assert_array_equal(hat[i], reference.hat(vector))
        np.testing.assert_allclose(V[i] @ V_inverse[i], np.eye(3), rtol=0, atol=ROUND_OFF)
        derivative = reference.hat(V[i] @ change) @ R[i]
        np.testing.assert_allclose(derivative, reference.exp_derivative(vector, change), rtol=0, atol=1e-13)


@drawn
@given(x=screw_batches)
def test_exp_log_composition_and_inverse_of_rigid_motions(device, x):
    R, v = screws(x, device)
    for i, (a, a1, b, b1, _, _) in enumerate(x):
        S = [reference.frame_matrix(R[i, k], v[i, k]) for k in range(4)]
        assert abs(S[0] - expm(reference.twist_matrix(a, a1))).max() < 1e-13
        assert abs(S[1] - expm(reference.twist_matrix(b, b1))).max() < 1e-13
        assert abs(S[2] - S[0] @ S[1]).max() < ROUND_OFF * 10
        assert abs(S[3] @ S[0] - np.eye(4)).max() < ROUND_OFF * 10
        # At pi the log may return the opposite axis, whose exp is the same frame.
        again, place = reference.se3_exp(v[i, 4], v[i, 5])
        assert abs(again - R[i, 0]).max() < 1e-13 and abs(place - v[i, 0]).max() < 1e-12
        if np.linalg.norm(a) < math.pi - 1e-13:
            assert abs(v[i, 5] - a1).max() < 1e-13


@drawn
@given(x=screw_batches)
def test_adjoint_actions_represent_the_group_and_its_algebra(device, x):
    R, v = screws(x, device)
    for i, (a, a1, _, _, c, c1) in enumerate(x):
        Ad = [reference.adjoint_matrix(R[i, k], v[i, k]) for k in range(4)]
        C = np.concatenate([c, c1])
        np.testing.assert_allclose(np.concatenate(v[i, 6:8]), Ad[0] @ C, rtol=0, atol=1e-13)
        np.testing.assert_allclose(np.concatenate(v[i, 8:10]), reference.ad_matrix(a, a1) @ C, atol=1e-13)
        assert abs(Ad[2] - Ad[0] @ Ad[1]).max() < 1e-13
        assert abs(Ad[3] @ Ad[0] - np.eye(6)).max() < 1e-13
        assert abs(Ad[0] - expm(reference.ad_matrix(a, a1))).max() < 1e-12


@drawn
@given(x=screw_batches)
def test_coadjoint_actions_are_dual_to_the_adjoint_ones(device, x):
    """``<Ad* p, A> = <p, Ad A>`` and ``<ad* p, A> = <p, ad A>`` with p = (c, c') and A = (b, b') (B.37)."""
    momentum, velocity = x[:, 4:6], x[:, 2:4]
    _, on_momentum = screws(x, device)
    _, on_velocity = screws(x[:, [0, 1, 4, 5, 2, 3]], device)
    for star, plain in ((slice(10, 12), slice(6, 8)), (slice(12, 14), slice(8, 10))):
        left = np.sum(on_momentum[:, star] * velocity, axis=(1, 2))
        right = np.sum(momentum * on_velocity[:, plain], axis=(1, 2))
        np.testing.assert_allclose(left, right, rtol=0, atol=1e-12)

"""wr.frames: SO(3) and SE(3) in NumPy against definitions, SciPy's matrix exponential and 50 digits."""

import numpy as np
import pytest
from reference import lie as reference
from scipy.spatial.transform import Rotation

import warp_rods as wr
from warp_rods import frames

RNG = np.random.default_rng(7)
ANGLES = np.array([0.0, 1e-300, 1e-12, 1e-5, 0.3, 0.999, 1.001, 2.0, 3.0, np.pi - 1e-9, np.pi])
AXES = RNG.normal(size=(5, 1, 3))
THETA = ANGLES[:, None] * AXES / np.linalg.norm(AXES, axis=-1, keepdims=True)
"""Rotation vectors [axis, angle, 3]."""
MU = RNG.normal(size=THETA.shape)


def rows(values: np.ndarray) -> np.ndarray:
    return values.reshape(-1, 3)


def screws(count: int = 6) -> list[np.ndarray]:
    return [RNG.normal(size=(4, 2, 3)) for _ in range(count)]


def test_exp_agrees_with_fifty_digits_and_with_matrix_exponentials(verified):
    R, r = frames.se3_exp(THETA, MU)
    assert R.shape == (5, 11, 3, 3) and r.shape == (5, 11, 3)
    exact = [reference.rotation_exp(theta) for theta in rows(THETA)]
    screw = [reference.se3_exp(theta, mu)[1] for theta, mu in zip(rows(THETA), rows(MU), strict=True)]
    verified.below(
        "independent", "wr.frames: exp of SO(3) and SE(3), angles 0 to π",
        measured=[abs(R.reshape(-1, 3, 3) - exact).max(), abs(rows(r) - screw).max()], bound=5e-15,
        reference="Rodrigues' formula with 50 digits, SciPy's `expm`",
    )  # fmt: skip
    np.testing.assert_array_equal(frames.rotation_exp(THETA), R)
    np.testing.assert_allclose(frames.left_jacobian(THETA) @ MU[..., None], r[..., None], atol=1e-15)


@pytest.mark.parametrize("angle", [1e-9, 1e-4, 0.99, 1.01, 3.1, 6.0])
def test_coefficients_have_all_digits(angle):
    from warp_rods.frames.rotations import coefficients, inverse_coefficient

    theta = angle * np.array([2.0, -1.0, 2.0]) / 3
    found = [*coefficients(theta), inverse_coefficient(theta)]
    np.testing.assert_allclose(found, reference.coefficients(np.linalg.norm(theta)), rtol=3e-15)


def test_log_inverts_exp_up_to_half_turns(verified):
    theta, mu = frames.se3_log(*frames.se3_exp(THETA, MU))
    sign = np.where(np.sum(theta * THETA, axis=-1, keepdims=True) < 0, -1.0, 1.0)
    half = np.linalg.norm(THETA, axis=-1, keepdims=True) > 3.14159
    assert (sign[~half] == 1).all()  # at half turns both signs of the axis are right
    again = frames.se3_exp(theta, mu)
    verified.below(
        "exact", "wr.frames: log of exp, angles 0 to π",
        measured=[abs(sign * theta - THETA).max(), abs(mu - MU)[(sign == 1)[..., 0]].max(),
                  abs(again[0] - frames.rotation_exp(THETA)).max()],
        bound=1e-14, reference="the screw itself",
    )  # fmt: skip
    np.testing.assert_allclose(frames.rotation_log(np.diag([-1.0, 1.0, -1.0])), [0, np.pi, 0])
    np.testing.assert_allclose(frames.rotation_log(frames.rotation_exp([1e-200, 0, 0])), [0, 0, 0], atol=1e-199)


def test_quaternions_are_those_of_trajectories():
    R = frames.rotation_exp(THETA)
    q = frames.quaternion(R)
    assert (q[..., 3] >= 0).all()
    np.testing.assert_allclose(frames.from_quaternion(-3 * q), R, atol=2e-15)
    scipy = Rotation.from_matrix(R.reshape(-1, 3, 3)).as_quat().reshape(q.shape)
    np.testing.assert_allclose(abs(np.sum(q * scipy, axis=-1)), 1, atol=1e-14)


def test_jacobians_are_derivatives_and_inverses():
    theta, change = np.array([0.4, -1.2, 2.0]), np.array([0.3, 0.1, -0.7])
    rate = frames.hat(frames.left_jacobian(theta) @ change) @ frames.rotation_exp(theta)
    np.testing.assert_allclose(rate, reference.exp_derivative(theta, change), atol=1e-14)
    both = frames.left_jacobian(THETA) @ frames.left_jacobian_inverse(THETA)
    np.testing.assert_allclose(both, np.broadcast_to(np.eye(3), both.shape), atol=5e-15)


def test_hat_and_vee():
    a, b, *_ = screws()
    np.testing.assert_allclose((frames.hat(a) @ b[..., None])[..., 0], np.cross(a, b), atol=1e-15)
    np.testing.assert_allclose(frames.vee(frames.hat(a)), a)
    R = frames.rotation_exp(a)
    np.testing.assert_allclose(
        R @ frames.hat(b) @ np.swapaxes(R, -1, -2), frames.hat((R @ b[..., None])[..., 0]), atol=5e-15
    )


def test_adjoint_actions_are_their_matrices():
    a, a1, b, b1, c, c1 = (x[0, 0] for x in screws())
    R, r = frames.se3_exp(a, a1)
    np.testing.assert_allclose(np.concatenate(frames.Ad(R, r, b, b1)), reference.adjoint_matrix(R, r) @ [*b, *b1])
    np.testing.assert_allclose(np.concatenate(frames.ad(a, a1, b, b1)), reference.ad_matrix(a, a1) @ [*b, *b1])
    star = reference.adjoint_matrix(R, r).T @ [*c, *c1]
    np.testing.assert_allclose(np.concatenate(frames.Ad_star(R, r, c, c1)), star)
    np.testing.assert_allclose(np.concatenate(frames.ad_star(a, a1, c, c1)), reference.ad_matrix(a, a1).T @ [*c, *c1])


def test_composition_and_inverse():
    a, a1, b, b1, *_ = screws()
    S, Q = frames.se3_exp(a, a1), frames.se3_exp(b, b1)
    R, r = frames.se3_compose(*S, *Q)
    product = reference.frame_matrix(S[0][1, 1], S[1][1, 1]) @ reference.frame_matrix(Q[0][1, 1], Q[1][1, 1])
    np.testing.assert_allclose(reference.frame_matrix(R[1, 1], r[1, 1]), product, atol=1e-15)
    one, zero = frames.se3_compose(*S, *frames.se3_inverse(*S))
    np.testing.assert_allclose(one, np.broadcast_to(np.eye(3), one.shape), atol=2e-15)
    np.testing.assert_allclose(zero, 0, atol=2e-15)


def test_the_metric_is_left_invariant_and_not_right_invariant():
    """(3.34): of tangent vectors S A, S A′ at one frame it is the product of their body velocities."""
    omega, u, omega1, u1, a, a1 = screws()
    R, _ = frames.se3_exp(a, a1)

    def tangent(w, v):
        return R @ frames.hat(w), (R @ v[..., None])[..., 0]

    first, second = tangent(omega, u), tangent(omega1, u1)
    expected = np.sum(omega * omega1 + u * u1, axis=-1)
    np.testing.assert_allclose(frames.metric(*first, *second), expected, atol=1e-13)
    Q, q = frames.se3_exp([0.3, 0.2, -0.5], [1.0, 2.0, 3.0])
    left = [(Q @ dR, (Q @ dr[..., None])[..., 0]) for dR, dr in (first, second)]
    np.testing.assert_allclose(frames.metric(*left[0], *left[1]), expected, atol=1e-13)
    turned = [(dR @ Q, dr) for dR, dr in (first, second)]
    np.testing.assert_allclose(frames.metric(*turned[0], *turned[1]), expected, atol=1e-13)
    moved = [(dR @ Q, dr + dR @ q) for dR, dr in (first, second)]
    assert abs(frames.metric(*moved[0], *moved[1]) - expected).min() > 1e-3


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: frames.rotation_log(np.diag([1.0, 1.0, 2.0])), "R: must be a rotation.*RᵀR − 1 has the entry 3"),
        (lambda: frames.rotation_log(np.stack([np.eye(3), -np.eye(3)])), r"R\[1\]: must be a rotation.*left-handed"),
        (lambda: frames.rotation_exp([1.0, 2.0]), r"theta: must be vectors \[..., 3\]; has shape \(2,\)"),
        (lambda: frames.rotation_exp([1.0, np.nan, 0.0]), "theta = nan: must be finite"),
        (lambda: frames.se3_exp(np.zeros((2, 3)), np.zeros((4, 3))), "theta, mu: must have shapes that broadcast"),
        (lambda: frames.from_quaternion([[0, 0, 0, 1], [0, 0, 0, 0]]), r"q\[1\] = 0"),
        (lambda: frames.hat("x"), "v = 'x': must be a number"),
    ],
)
def test_wrong_arguments_are_named(call, words):
    with pytest.raises(wr.SceneError, match=words):
        call()

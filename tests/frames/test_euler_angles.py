"""wr.frames: Euler angles (A.36) to (A.47), and gimbal lock."""

import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import warp_rods as wr
from warp_rods import frames

ORDERS = ["zxz", "zyz", "xyx", "xzx", "yxy", "yzy", "xyz", "xzy", "yxz", "yzx", "zxy", "zyx"]
R = Rotation.random(200, random_state=3).as_matrix()


@pytest.mark.parametrize("axes", ORDERS)
def test_angles_and_rotations_agree_with_scipy(axes):
    angles = frames.euler_angles(R, axes)
    np.testing.assert_allclose(frames.euler_rotation(angles, axes), R, atol=3e-15)
    np.testing.assert_allclose(angles, Rotation.from_matrix(R).as_euler(axes.upper()), atol=1e-12)


def test_the_order_of_rotations_is_that_of_the_text():
    """(A.42): R_z(α) R_x(β) R_z(γ), with the matrices (A.31) and (A.33)."""
    a, b, c = 0.4, 1.1, -2.0

    def about_z(t):
        return np.array([[np.cos(t), -np.sin(t), 0], [np.sin(t), np.cos(t), 0], [0, 0, 1]])

    about_x = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    np.testing.assert_allclose(frames.euler_rotation([a, b, c]), about_z(a) @ about_x @ about_z(c), atol=1e-15)


def test_the_jacobian_gives_the_angular_velocity_and_its_determinant():
    """(A.45) against differences, (A.46) = −sin β, and (A.47) for three oblique axes."""
    axes = np.array([[1.0, 0.2, 0.0], [0.0, 2.0, 0.3], [0.4, 0.0, 1.0]])
    angles, rates, h = np.array([0.3, 0.9, -1.4]), np.array([0.7, -0.2, 0.5]), 1e-6
    for which in ("zxz", "xyz", axes):
        E = frames.euler_jacobian(angles, which)
        ahead, behind = (frames.euler_rotation(angles + d * h * rates, which) for d in (1, -1))
        omega = frames.rotation_log(behind.T @ ahead) / (2 * h)
        np.testing.assert_allclose(E @ rates, omega, atol=1e-8)
    a, b, c = axes / np.linalg.norm(axes, axis=1, keepdims=True)
    expected = (frames.rotation_exp(-angles[1] * b) @ a) @ np.cross(b, c)
    assert np.linalg.det(E) == pytest.approx(expected, abs=1e-14)
    assert np.linalg.det(frames.euler_jacobian(angles)) == pytest.approx(-np.sin(0.9), abs=1e-14)


@pytest.mark.parametrize("axes, locked", [("zxz", 0.0), ("zxz", np.pi), ("xyz", np.pi / 2), ("xyz", -np.pi / 2)])
@pytest.mark.parametrize("off", [0.0, 1e-10])
def test_gimbal_lock_is_told_and_the_rotation_kept(axes, locked, off):
    given = np.array([[0.1, 0.2, 0.3], [0.7, locked + off, -0.4]])
    rotation = frames.euler_rotation(given, axes)
    assert abs(np.linalg.det(frames.euler_jacobian(given, axes))[1]) <= 2e-10
    with pytest.warns(RuntimeWarning, match=r"gimbal lock at R\[1\]"):
        angles = frames.euler_angles(rotation, axes)
    np.testing.assert_allclose(angles[0], given[0], atol=1e-14)
    np.testing.assert_allclose(frames.euler_rotation(angles, axes), rotation, atol=2e-15)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        frames.euler_angles(frames.euler_rotation([0.7, locked + 1e-3, -0.4], axes), axes)


def test_at_lock_the_first_angle_is_zero():
    with pytest.warns(RuntimeWarning, match="gimbal lock at R, β = 0"):
        np.testing.assert_allclose(frames.euler_angles(np.eye(3)), 0, atol=1e-15)


@pytest.mark.parametrize(
    "axes, words",
    [("zzx", "neighbours are not parallel"), ("xy", "three letters"), ("abc", "three letters"), (3.0, "three letters")],
)
def test_wrong_axes_are_named(axes, words):
    with pytest.raises(wr.SceneError, match=f"axes.*{words}"):
        frames.euler_angles(np.eye(3), axes)
    with pytest.raises(wr.SceneError, match="axes"):
        frames.euler_rotation([0.0, 0.0, 0.0], axes if axes != 3.0 else [[1, 0, 0], [2, 0, 0], [0, 0, 1]])

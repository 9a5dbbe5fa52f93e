"""Group functions in NumPy, SciPy and mpmath, written directly from the equations."""

import mpmath
import numpy as np
from scipy.linalg import expm, expm_frechet

# --- SO(3), SE(3) -------------------------------------------------------------------------------------------


def hat(v: np.ndarray) -> np.ndarray:
    """The matrix of ``v x`` (A.7)."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def twist_matrix(theta: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """The 4 x 4 matrix of an element of se(3)."""
    matrix = np.zeros((4, 4))
    matrix[:3, :3] = hat(theta)
    matrix[:3, 3] = mu
    return matrix


def frame_matrix(R: np.ndarray, r: np.ndarray) -> np.ndarray:
    """The 4 x 4 matrix of a frame."""
    matrix = np.eye(4)
    matrix[:3, :3] = R
    matrix[:3, 3] = r
    return matrix


def ad_matrix(theta: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """The 6 x 6 matrix of ``ad`` on (angular, linear) (B.33)."""
    return np.block([[hat(theta), np.zeros((3, 3))], [hat(mu), hat(theta)]])


def adjoint_matrix(R: np.ndarray, r: np.ndarray) -> np.ndarray:
    """The 6 x 6 matrix of ``Ad`` on (angular, linear)."""
    return np.block([[R, np.zeros((3, 3))], [hat(r) @ R, R]])


def se3_exp(theta: np.ndarray, mu: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The frame of a screw, by SciPy's matrix exponential."""
    S = expm(twist_matrix(theta, mu))
    return S[:3, :3], S[:3, 3]


def exp_derivative(theta: np.ndarray, change: np.ndarray) -> np.ndarray:
    """The change of ``exp(hat theta)`` with ``theta``, by SciPy's Fréchet derivative."""
    return expm_frechet(hat(theta), hat(change), compute_expm=False)


def rotation_exp(theta: np.ndarray) -> np.ndarray:
    """Rodrigues' formula with 50 digits, rounded once."""
    with mpmath.workdps(50):
        x, y, z = (mpmath.mpf(float(c)) for c in theta)
        angle = mpmath.sqrt(x * x + y * y + z * z)
        if angle == 0:
            return np.eye(3)
        cross = mpmath.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]]) / angle
        R = mpmath.eye(3) + mpmath.sin(angle) * cross + (1 - mpmath.cos(angle)) * cross * cross
        return np.array(R.tolist(), dtype=float)


def coefficients(angle: float) -> np.ndarray:
    """A, B, C of (B.15), (B.16) and the one of (B.20) with 100 digits (1 − A loses half of them), rounded once."""
    with mpmath.workdps(100):
        t = mpmath.mpf(float(angle))
        a, b = mpmath.sin(t) / t, (1 - mpmath.cos(t)) / t**2
        return np.array([a, b, (1 - a) / t**2, (1 - a / (2 * b)) / t**2], dtype=float)


def integrate_frames(
    strain: np.ndarray, spacing: np.ndarray, start: int, R: np.ndarray, r: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Frames ``[rod, node, ...]`` outwards from those at node ``start`` (2.48), (D.77), by SciPy's expm."""
    R, r = R.copy(), r.copy()
    rods, nodes, _ = strain.shape
    outwards = [(i, i - 1, 1.0) for i in range(start + 1, nodes)] + [(i, i + 1, -1.0) for i in range(start - 1, -1, -1)]
    for rod in range(rods):
        for i, inner, sign in outwards:
            mean = 0.5 * (strain[rod, i] + strain[rod, inner])
            cell = expm(sign * spacing[rod] * twist_matrix(mean, np.array([1.0, 0.0, 0.0])))
            S = frame_matrix(R[rod, inner], r[rod, inner]) @ cell
            R[rod, i], r[rod, i] = S[:3, :3], S[:3, 3]
    return R, r

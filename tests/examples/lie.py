"""Kernels that evaluate the group functions with one thread per element, for test_lie.py."""

import numpy as np
import warp as wp

from warp_rods.kernels import lie
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})


@wp.kernel
def rotation_functions(
    theta: wp.array[wp.vec3d],
    R: wp.array[wp.mat33d],
    V: wp.array[wp.mat33d],
    V_inverse: wp.array[wp.mat33d],
    log: wp.array[wp.vec3d],
    hat: wp.array[wp.mat33d],
):
    i = wp.tid()
    hat[i] = lie.hat(theta[i])
    R[i] = lie.rotation_exp(theta[i])
    V[i] = lie.left_jacobian(theta[i])
    V_inverse[i] = lie.left_jacobian_inverse(theta[i])
    log[i] = lie.rotation_log(R[i])


@wp.kernel
def matrix_functions(
    R: wp.array[wp.mat33d],
    log: wp.array[wp.vec3d],
    again: wp.array[wp.mat33d],
    quaternion: wp.array[wp.quatd],
    orthonormal: wp.array[wp.mat33d],
):
    i = wp.tid()
    log[i] = lie.rotation_log(R[i])
    again[i] = lie.rotation_exp(log[i])
    quaternion[i] = lie.quaternion(R[i])
    orthonormal[i] = lie.orthonormalise(R[i])


@wp.kernel
def coefficient_functions(theta: wp.array[wp.vec3d], values: wp.array2d[real]):
    i = wp.tid()
    a, b, c = lie.coefficients(theta[i])
    values[i, 0] = a
    values[i, 1] = b
    values[i, 2] = c
    values[i, 3] = lie.inverse_coefficient(theta[i])


@wp.func
def store_frame(Q: wp.mat33d, q: wp.vec3d, i: int, k: int, R: wp.array2d[wp.mat33d], v: wp.array2d[wp.vec3d]):
    R[i, k] = Q
    v[i, k] = q


@wp.func
def store_pair(a: wp.vec3d, b: wp.vec3d, i: int, k: int, v: wp.array2d[wp.vec3d]):
    v[i, k] = a
    v[i, k + 1] = b


@wp.kernel
def screw_functions(x: wp.array2d[wp.vec3d], R: wp.array2d[wp.mat33d], v: wp.array2d[wp.vec3d]):
    """From screws ``x[i] = (a, a', b, b', c, c')``: frames of a, b, ab, a^-1; log of a; Ad, ad, Ad*, ad* of a on c."""
    i = wp.tid()
    a, a1, c, c1 = x[i, 0], x[i, 1], x[i, 4], x[i, 5]
    Q, q = lie.se3_exp(a, a1)
    P, p = lie.se3_exp(x[i, 2], x[i, 3])
    QP, qp = lie.se3_compose(Q, q, P, p)
    back, back_r = lie.se3_inverse(Q, q)
    log, log1 = lie.se3_log(Q, q)
    moved, moved1 = lie.Ad(Q, q, c, c1)
    bracket, bracket1 = lie.ad(a, a1, c, c1)
    body, body1 = lie.Ad_star(Q, q, c, c1)
    rate, rate1 = lie.ad_star(a, a1, c, c1)
    store_frame(Q, q, i, 0, R, v)
    store_frame(P, p, i, 1, R, v)
    store_frame(QP, qp, i, 2, R, v)
    store_frame(back, back_r, i, 3, R, v)
    store_pair(log, log1, i, 4, v)
    store_pair(moved, moved1, i, 6, v)
    store_pair(bracket, bracket1, i, 8, v)
    store_pair(body, body1, i, 10, v)
    store_pair(rate, rate1, i, 12, v)


def launch(kernel, data: np.ndarray, dtype, outputs: list, device: str) -> list[np.ndarray]:
    """Launch with one thread per row of ``data``; ``outputs``: (dtype, columns), columns None for a 1-d array."""
    rows = len(data)
    given_array = wp.array(data, dtype=dtype, device=device)
    arrays = [wp.zeros(rows if n is None else (rows, n), dtype=t, device=device) for t, n in outputs]
    wp.launch(kernel, rows, [given_array, *arrays], device=device)
    return [a.numpy() for a in arrays]


def coefficients(theta: np.ndarray, device: str) -> np.ndarray:
    """A, B, C and the coefficient of (B.20); one row for each of ``theta``."""
    return launch(coefficient_functions, theta, wp.vec3d, [(real, 4)], device)[0]


def rotations(theta: np.ndarray, device: str) -> list[np.ndarray]:
    """exp, V, V^-1, log of exp, and hat, of each of ``theta``."""
    kinds = [(wp.mat33d, None)] * 3 + [(wp.vec3d, None), (wp.mat33d, None)]
    return launch(rotation_functions, theta, wp.vec3d, kinds, device)


def matrices(R: np.ndarray, device: str) -> list[np.ndarray]:
    """log, exp of log, quaternion and orthonormalised frame of each of ``R``."""
    kinds = [(wp.vec3d, None), (wp.mat33d, None), (wp.quatd, None), (wp.mat33d, None)]
    return launch(matrix_functions, R, wp.mat33d, kinds, device)


def screws(x: np.ndarray, device: str) -> tuple[np.ndarray, np.ndarray]:
    """Matrices ``[row, 4]`` and vectors ``[row, 14]`` in the order of ``screw_functions``."""
    R, v = launch(screw_functions, x, wp.vec3d, [(wp.mat33d, 4), (wp.vec3d, 14)], device)
    return R, v

"""SO(3) and SE(3): exp, log, adjoint and coadjoint actions, path-ordered products (dissertation, appendices A, B).

The columns of ``R`` in a frame ``S = (R, r)`` are the directors, the tangent first. An element of se(3) is a pair
``(theta, mu)``, angular part first. An element of its dual is a pair ``(moment, force)`` in the same order.
"""

import warp as wp

from warp_rods.kernels.layout import Matrices2D, Scalars1D, Vectors2D, real

wp.set_module_options({"enable_backward": False})

SERIES_BELOW = wp.constant(real(1.0))
"""The theta^2 below which power series replace the trigonometric forms, which lose digits for small angles."""


def factorial(n: int) -> int:
    """``n!``; evaluated on the host."""
    return n * factorial(n - 1) if n > 1 else 1


# Eight terms reach round-off at theta^2 = 1. The quotients are formed here: in a kernel they would be float32.
series = wp.types.vector(8, real)
SERIES_C = wp.constant(series(*[(-1) ** j / factorial(2 * j + 3) for j in range(8)]))
SERIES_F = wp.constant(series(*[(-1) ** j / factorial(2 * j + 4) for j in range(8)]))


# --- Coefficients -------------------------------------------------------------------------------------------


@wp.func
def power_series(terms: series, t: real):
    """``sum terms[j] t^j``."""
    total = terms[7]
    for j in range(7):
        total = terms[6 - j] + t * total
    return total


@wp.func
def coefficients(theta: wp.vec3d):
    """A, B, C of (B.15), (B.16): ``exp = 1 + A hat + B hat^2``, ``V = 1 + B hat + C hat^2``."""
    t = wp.dot(theta, theta)
    if t < SERIES_BELOW:
        # A = 1 - theta^2 C and B = 1/2 - theta^2 F need no series of their own; (B.24) has a misprint.
        c = power_series(SERIES_C, t)
        return real(1.0) - t * c, real(0.5) - t * power_series(SERIES_F, t), c
    angle = wp.sqrt(t)
    half_sine = wp.sin(real(0.5) * angle)
    a = real(2.0) * half_sine * wp.cos(real(0.5) * angle) / angle
    return a, real(2.0) * half_sine * half_sine / t, (real(1.0) - a) / t


@wp.func
def inverse_coefficient(theta: wp.vec3d):
    """``(1 - A/(2B))/theta^2`` of (B.20); finite below 2 pi."""
    t = wp.dot(theta, theta)
    if t < SERIES_BELOW:
        f = power_series(SERIES_F, t)
        return (power_series(SERIES_C, t) - real(2.0) * f) / (real(1.0) - real(2.0) * t * f)
    half = real(0.5) * wp.sqrt(t)
    return (real(1.0) - half * wp.cos(half) / wp.sin(half)) / t


# --- Rotations ----------------------------------------------------------------------------------------------


@wp.func
def hat(v: wp.vec3d):
    """The matrix of ``v x``."""
    zero = real(0.0)
    return wp.mat33d(zero, -v[2], v[1], v[2], zero, -v[0], -v[1], v[0], zero)


@wp.func
def hat_polynomial(theta: wp.vec3d, first: real, second: real):
    """``1 + first hat + second hat^2``, with ``hat^2 = theta theta^T - theta^2``."""
    x, y, z = theta[0], theta[1], theta[2]
    xy, xz, yz = second * x * y, second * x * z, second * y * z
    xx, yy, zz = second * x * x, second * y * y, second * z * z
    x, y, z = first * x, first * y, first * z
    one = real(1.0)
    return wp.matrix_from_rows(
        wp.vec3d(one - yy - zz, xy - z, xz + y),
        wp.vec3d(xy + z, one - xx - zz, yz - x),
        wp.vec3d(xz - y, yz + x, one - xx - yy),
    )


@wp.func
def rotation_exp(theta: wp.vec3d):
    """The rotation by ``|theta|`` about ``theta`` (B.14)."""
    a, b, _c = coefficients(theta)
    return hat_polynomial(theta, a, b)


@wp.func
def left_jacobian(theta: wp.vec3d):
    """V of (B.14): ``exp(theta, mu) = (exp theta, V mu)``; ``d exp(theta) = hat(V dtheta) exp(theta)``."""
    _a, b, c = coefficients(theta)
    return hat_polynomial(theta, b, c)


@wp.func
def left_jacobian_inverse(theta: wp.vec3d):
    """The inverse of V (B.20), for angles below 2 pi."""
    return hat_polynomial(theta, real(-0.5), inverse_coefficient(theta))


@wp.func
def quaternion(R: wp.mat33d):
    """The unit quaternion (x, y, z, w) with ``w >= 0`` of any rotation, including those by pi."""
    q = wp.quat_from_matrix(R)
    if q[3] < real(0.0):
        return -q
    return q


@wp.func
def rotation_log(R: wp.mat33d):
    """The rotation vector, of length 0 to pi, from the quaternion, because (A.34) divides by ``sin theta``."""
    q = quaternion(R)
    axis = wp.vec3d(q[0], q[1], q[2])
    half_sine = wp.length(axis)
    if half_sine == real(0.0):
        return real(2.0) * axis
    return (real(2.0) * wp.atan2(half_sine, q[3]) / half_sine) * axis


@wp.func
def orthonormalise(R: wp.mat33d):
    """The right-handed orthonormal frame with the same tangent, column 0 (Gram-Schmidt)."""
    q0 = wp.normalize(wp.vec3d(R[0, 0], R[1, 0], R[2, 0]))
    q1 = wp.vec3d(R[0, 1], R[1, 1], R[2, 1])
    q1 = wp.normalize(q1 - wp.dot(q0, q1) * q0)
    return wp.matrix_from_cols(q0, q1, wp.cross(q0, q1))


# --- Rigid motions ------------------------------------------------------------------------------------------


@wp.func
def se3_exp(theta: wp.vec3d, mu: wp.vec3d):
    """The frame ``(R, r)`` of a screw (B.13)."""
    a, b, c = coefficients(theta)
    rotated = wp.cross(theta, mu)
    return hat_polynomial(theta, a, b), mu + b * rotated + c * wp.cross(theta, rotated)


@wp.func
def se3_log(R: wp.mat33d, r: wp.vec3d):
    """The screw ``(theta, mu)`` of a frame (B.17), ``|theta| <= pi``."""
    theta = rotation_log(R)
    rotated = wp.cross(theta, r)
    mu = r - real(0.5) * rotated + inverse_coefficient(theta) * wp.cross(theta, rotated)
    return theta, mu


@wp.func
def se3_compose(R: wp.mat33d, r: wp.vec3d, Q: wp.mat33d, q: wp.vec3d):
    """The product ``(R, r)(Q, q)``."""
    return R * Q, R * q + r


@wp.func
def se3_inverse(R: wp.mat33d, r: wp.vec3d):
    """The inverse frame."""
    return wp.transpose(R), -(wp.transpose(R) * r)


@wp.func
def Ad(R: wp.mat33d, r: wp.vec3d, theta: wp.vec3d, mu: wp.vec3d):
    """``S (theta, mu) S^-1``: the spatial velocity of a body velocity."""
    rotated = R * theta
    return rotated, R * mu + wp.cross(r, rotated)


@wp.func
def ad(theta: wp.vec3d, mu: wp.vec3d, phi: wp.vec3d, nu: wp.vec3d):
    """The commutator ``[(theta, mu), (phi, nu)]`` (B.33)."""
    return wp.cross(theta, phi), wp.cross(theta, nu) - wp.cross(phi, mu)


@wp.func
def Ad_star(R: wp.mat33d, r: wp.vec3d, moment: wp.vec3d, force: wp.vec3d):
    """The dual of Ad, ``<Ad* p, A> = <p, Ad A>``: the body momentum of a spatial momentum."""
    inverse = wp.transpose(R)
    return inverse * (moment - wp.cross(r, force)), inverse * force


@wp.func
def ad_star(theta: wp.vec3d, mu: wp.vec3d, moment: wp.vec3d, force: wp.vec3d):
    """The dual of ad, ``<ad* p, A> = <p, ad A>`` (B.34). The momentum of a free body obeys ``dp/dt = ad*_A p``."""
    return -(wp.cross(theta, moment) + wp.cross(mu, force)), -wp.cross(theta, force)


# --- Path-ordered products ----------------------------------------------------------------------------------


@wp.func
def advance(R: wp.mat33d, r: wp.vec3d, omega: wp.vec3d, u: wp.vec3d, dt: real):
    """``S exp(dt A)``: second order if ``A = (omega, u)`` is the midpoint value (Magnus) or the mean of both ends."""
    Q, q = se3_exp(dt * omega, dt * u)
    return se3_compose(R, r, Q, q)


@wp.func
def advance_along(R: wp.mat33d, r: wp.vec3d, strain: wp.vec3d, ds: real):
    """``S exp(ds (strain, e0))`` (D.81), (D.82): the frame one cell further along an inextensible, unshearable rod."""
    theta = ds * strain
    a, b, c = coefficients(theta)
    x, y, z = theta[0], theta[1], theta[2]
    step = wp.vec3d(real(1.0) - c * (y * y + z * z), c * x * y + b * z, c * x * z - b * y)
    return R * hat_polynomial(theta, a, b), r + R * (ds * step)


@wp.kernel
def integrate_frames(
    strain: Vectors2D,
    spacing: Scalars1D,
    start_node: int,
    R: Matrices2D,
    r: Vectors2D,
):
    """Frames from the given one at ``start_node`` outwards, one thread for each rod (2.48), (D.77)."""
    rod = wp.tid()
    half = real(0.5)
    nodes = strain.shape[1]
    ds = spacing[rod]
    Q = R[rod, start_node]
    q = r[rod, start_node]
    for i in range(start_node + 1, nodes):
        Q, q = advance_along(Q, q, half * (strain[rod, i - 1] + strain[rod, i]), ds)
        R[rod, i] = Q
        r[rod, i] = q
    Q = R[rod, start_node]
    q = r[rod, start_node]
    for back in range(start_node):
        i = start_node - 1 - back
        Q, q = advance_along(Q, q, half * (strain[rod, i] + strain[rod, i + 1]), -ds)
        R[rod, i] = Q
        r[rod, i] = q

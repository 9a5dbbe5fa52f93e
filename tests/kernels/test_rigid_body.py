"""The rigid body (3.44), (3.45), a Cosserat medium of dimension zero, as a test of the group functions.

The step is the implicit midpoint rule for the body momentum, ``p1 - p0 = dt ad*_A (p0 + p1)/2`` with A the velocity of
the mean momentum. It conserves the energy, a quadratic form, exactly. It is also the coadjoint action of one group
element, the Cayley transform of ``dt A``. The frame is advanced by the same element, so the spatial momentum is
conserved exactly as well. The motion is second order in time.
"""

import numpy as np
import pytest
import warp as wp
from reference import lie as reference
from scipy.integrate import solve_ivp

from warp_rods.kernels import lie
from warp_rods.kernels.layout import real

wp.set_module_options({"enable_backward": False})

INERTIA = np.array([1.0, 2.0, 3.0])
MASSES = {"rigid body": np.array([1.5, 1.5, 1.5]), "body in an ideal fluid": np.array([1.0, 2.5, 1.7])}
MOMENT, FORCE = np.array([0.8, 1.0, -0.7]), np.array([0.5, -0.4, 0.9])


@wp.func
def cayley(theta: wp.vec3d, mu: wp.vec3d):
    """The screw whose exp has ``Ad = (1 - ad/2)^-1 (1 + ad/2)``: ``2 arctan(t/2)/t`` of the dual vector."""
    x = wp.dot(theta, theta)
    angle = wp.sqrt(x)
    c = real(2.0) * wp.atan(real(0.5) * angle) / angle
    slope = (real(1.0) / (real(1.0) + real(0.25) * x) - c) / (real(2.0) * x)
    return c * theta, c * mu + (real(2.0) * slope * wp.dot(theta, mu)) * theta


@wp.func
def mean_momentum(moment: wp.vec3d, force: wp.vec3d, inertia: wp.vec3d, mass: wp.vec3d, dt: real):
    """The mean p of both ends of the step: ``p = p0 + (dt/2) ad*_A p``, by iteration."""
    half = real(0.5) * dt
    p = moment
    l = force
    for _ in range(60):
        dp, dl = lie.ad_star(wp.cw_div(p, inertia), wp.cw_div(l, mass), p, l)
        p = moment + half * dp
        l = force + half * dl
    return p, l


@wp.kernel
def move_freely(
    inertia: wp.vec3d,
    mass: wp.vec3d,
    dt: real,
    R: wp.array2d[wp.mat33d],
    r: wp.array2d[wp.vec3d],
    moment: wp.array2d[wp.vec3d],
    force: wp.array2d[wp.vec3d],
):
    i = wp.tid()
    for k in range(R.shape[1] - 1):
        p, l = mean_momentum(moment[i, k], force[i, k], inertia, mass, dt)
        theta, mu = cayley(dt * wp.cw_div(p, inertia), dt * wp.cw_div(l, mass))
        Q, q = lie.se3_exp(theta, mu)
        R1, r1 = lie.se3_compose(R[i, k], r[i, k], Q, q)
        p1, l1 = lie.Ad_star(Q, q, moment[i, k], force[i, k])
        R[i, k + 1] = R1
        r[i, k + 1] = r1
        moment[i, k + 1] = p1
        force[i, k + 1] = l1


def motion(mass: np.ndarray, dt: float, steps: int, device: str) -> list[np.ndarray]:
    """R, r, moment, force at every step of one body, from the origin."""
    R = wp.array(np.tile(np.eye(3), (1, steps + 1, 1, 1)), dtype=wp.mat33d, device=device)
    r = wp.zeros((1, steps + 1), dtype=wp.vec3d, device=device)
    moment, force = (wp.array(np.tile(p, (1, steps + 1, 1)), dtype=wp.vec3d, device=device) for p in (MOMENT, FORCE))
    arguments = [wp.vec3d(*INERTIA), wp.vec3d(*mass), dt, R, r, moment, force]
    wp.launch(move_freely, 1, arguments, device=device)
    return [a.numpy()[0] for a in (R, r, moment, force)]


def exact_motion(mass: np.ndarray, end: float) -> list[np.ndarray]:
    """The motion at one time from (3.44), (3.45) and ``dS/dt = S A``, by SciPy."""

    def rate(_, y):
        R, p, l = y[:9].reshape(3, 3), y[12:15], y[15:]
        omega, u = p / INERTIA, l / mass
        dp, dl = -np.cross(omega, p) - np.cross(u, l), -np.cross(omega, l)
        return np.concatenate([(R @ reference.hat(omega)).ravel(), R @ u, dp, dl])

    y0 = np.concatenate([np.eye(3).ravel(), np.zeros(3), MOMENT, FORCE])
    y = solve_ivp(rate, (0.0, end), y0, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return [y[:9].reshape(3, 3), y[9:12], y[12:15], y[15:]]


@pytest.mark.parametrize("kind", MASSES)
def test_energy_and_spatial_momentum_are_conserved_to_round_off(device, kind, verified):
    mass, steps = MASSES[kind], 2000
    R, r, moment, force = motion(mass, 0.05, steps, device)
    energy = 0.5 * np.sum(moment**2 / INERTIA + force**2 / mass, axis=-1)
    linear = np.einsum("kij,kj->ki", R, force)
    angular = np.einsum("kij,kj->ki", R, moment) + np.cross(r, linear)
    # The lever arm grows with the path, to about 100, and round-off with it.
    for name, error, bound in (
        ("energy, relative", abs(energy / energy[0] - 1).max(), 1e-12),
        ("spatial momentum", abs(linear - FORCE).max(), 1e-12),
        ("spatial angular momentum", abs(angular - MOMENT).max(), 1e-10),
    ):
        verified.below(
            "conservation", f"{kind} (3.44), (3.45): change of {name}", measured=error, bound=bound,
            reference="0 over 2000 steps",
        )  # fmt: skip
    assert np.ptp(moment, axis=0).min() > 0.2  # it tumbles


@pytest.mark.parametrize("kind", MASSES)
def test_the_motion_is_second_order_in_time(device, kind, verified):
    end, sizes = 4.0, [40, 80, 160, 320]
    exact = exact_motion(MASSES[kind], end)
    found = [[a[-1] for a in motion(MASSES[kind], end / n, n, device)] for n in sizes]
    errors = [[abs(a - b).max() for a, b in zip(state, exact, strict=True)] for state in found]
    orders = -np.polyfit(np.log(sizes), np.log(errors), 1)[0]
    verified.order(f"{kind}: order in Δt of R, r and momenta", measured=orders, reference="SciPy's `solve_ivp`")

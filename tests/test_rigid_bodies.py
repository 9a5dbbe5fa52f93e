"""wr.RigidBody (3.35) to (3.45): exact motions of tops, conservation, order, and the way back."""

import numpy as np
import pytest
from examples.free import slope
from reference import lie as reference
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

import warp_rods as wr
from warp_rods import frames

J, M = np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.5, 1.7])
OMEGA, U = np.array([0.8, 0.5, -0.7]), np.array([0.5, -0.4, 0.9])
RATE, MASS_G_L = 6.0, 1.3
TOP = np.array([1.2, 1.2, 0.5])
"""Moments of a symmetric top, its third axis the axis of symmetry."""


def weight(R, r):
    """m g l cos θ of a top that turns about its point."""
    slopes = np.zeros_like(R)
    slopes[..., 2, 2] = MASS_G_L
    return MASS_G_L * R[..., 2, 2], slopes, np.zeros_like(r)


STIFF, DIPOLE = np.array([1.0, 1.0, 2.5]), np.array([0.3, 0.2, 0.6])


def coupled(R, r):
    """Of place and orientation, symmetric about the z axis: ½ Σ k r² − (R d)·r (1 + z) + …"""
    d = np.einsum("...ij,j->...i", R, DIPOLE)
    high = 1 + r[..., 2]
    V = 0.5 * np.sum(STIFF * r**2, axis=-1) - np.sum(d * r, axis=-1) * high
    by_d = -r * high[..., None]
    by_r = STIFF * r - d * high[..., None]
    by_r[..., 2] -= np.sum(d * r, axis=-1)
    return V, by_d[..., :, None] * DIPOLE, by_r


def slow_precession(tilt: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Rate φ̇ of steady precession, J φ̇² cos θ − J3 ω3 φ̇ + m g l = 0, and the frame and ω at the start."""
    a, b = TOP[0] * np.cos(tilt), TOP[2] * RATE
    rate = (b - np.sqrt(b * b - 4 * a * MASS_G_L)) / (2 * a)
    R = frames.rotation_exp([tilt, 0.0, 0.0])
    omega = rate * R[2] + np.array([0.0, 0.0, RATE - rate * np.cos(tilt)])
    return rate, R, omega


def exact_motion(mass: np.ndarray, end: float, potential=None) -> list[np.ndarray]:
    """R, r, ω, u at one time from (3.44), (3.45) and dS/dt = S A, by SciPy."""

    def rate(_, y):
        R, r, p, l = y[:9].reshape(3, 3), y[9:12], y[12:15], y[15:]
        omega, u = p / J, l / mass
        moment, force = np.zeros(3), np.zeros(3)
        if potential is not None:
            _, by_R, by_r = potential(R, r)
            moment = -R.T @ np.sum([np.cross(R[:, i], by_R[:, i]) for i in range(3)], axis=0)
            force = -R.T @ by_r
        dp, dl = moment - np.cross(omega, p) - np.cross(u, l), force - np.cross(omega, l)
        return np.concatenate([(R @ reference.hat(omega)).ravel(), R @ u, dp, dl])

    y0 = np.concatenate([np.eye(3).ravel(), np.zeros(3), J * OMEGA, mass * U])
    y = solve_ivp(rate, (0.0, end), y0, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return [y[:9].reshape(3, 3), y[9:12], y[12:15] / J, y[15:] / mass]


def readings(body: wr.RigidBody) -> list[np.ndarray]:
    return [body.rotation, body.position, body.angular_velocity, body.velocity]


def history(body: wr.RigidBody, dt: float, steps: int, every: int, what) -> np.ndarray:
    found = [what(body)]
    for _ in range(steps // every):
        body.step(dt, every)
        found.append(what(body))
    return np.array(found)


# --- exact motions ---------------------------------------------------------------------------------------------------


def test_a_free_symmetric_top_precesses_as_it_must(verified):
    """R(t) = exp(t L/J) exp(t (1 − J3/J) ω3 e3): precession about L, spin about the axis; u constant in space."""
    omega, end = np.array([0.9, 0.0, 2.0]), 3.0
    turning = Rotation.from_rotvec(end * TOP * omega / TOP[0]).as_matrix()
    spinning = Rotation.from_rotvec([0, 0, end * (1 - TOP[2] / TOP[0]) * omega[2]]).as_matrix()
    sizes, errors = [40, 80, 160], []
    for steps in sizes:
        body = wr.RigidBody(TOP, 2.0, angular_velocity=omega, velocity=U)
        body.step(end / steps, steps)
        errors.append(abs(body.rotation - turning @ spinning).max())
    verified.order(
        "wr.RigidBody: free symmetric top: order in Δt of its frame", measured=slope(sizes, errors),
        reference="precession in closed form",
    )  # fmt: skip
    verified.below(
        "exact", "wr.RigidBody: place of a free symmetric top", measured=abs(body.position - end * U).max(),
        bound=1e-13, reference="uniform motion of the centre of mass",
    )  # fmt: skip


def test_the_intermediate_axis_flips_as_elliptic_functions_say(verified):
    """ω = (a cn, b sn, c dn) for J1 < J2 < J3: a nut in zero gravity (Dzhanibekov) turns over again and again."""
    omega0 = np.array([np.sqrt(3), 0.0, 1.02])
    energy2, momentum2 = np.sum(J * omega0**2), np.sum((J * omega0) ** 2)  # 2E, L²
    up, down = energy2 * J[2] - momentum2, momentum2 - energy2 * J[0]
    pace = np.sqrt((J[2] - J[1]) * down / np.prod(J))
    m = (J[1] - J[0]) * up / ((J[2] - J[1]) * down)
    assert 0.95 < m < 1  # near the separatrix, where it rests at each end for a while
    end = 5 * ellipk(m) / pace  # past the second flip
    sizes, errors = [250, 500, 1000], []
    for steps in sizes:
        body = wr.RigidBody(J, angular_velocity=omega0)
        found = history(body, end / steps, steps, steps // 50, lambda body: body.angular_velocity)
        sn, cn, dn, _ = ellipj(np.linspace(0, end, 51) * pace, m)
        size = np.sqrt([up / (J[0] * (J[2] - J[0])), up / (J[1] * (J[2] - J[1])), down / (J[2] * (J[2] - J[0]))])
        exact = size * np.stack([cn, sn, dn], axis=-1)
        errors.append(abs(found - exact).max())
    assert exact[:, 1].max() > 1.7 and exact[:, 1].min() < -1.7
    verified.order(
        "wr.RigidBody: rotation about the intermediate axis: order in Δt", measured=slope(sizes, errors),
        reference="Jacobi's elliptic functions",
    )  # fmt: skip
    verified.below(
        "exact", "wr.RigidBody: ω about the intermediate axis over two flips", measured=errors[-1], bound=1e-2,
        reference="Jacobi's elliptic functions",
    )  # fmt: skip


def test_a_heavy_top_precesses_steadily(verified):
    tilt, end = 0.6, 4.0
    rate, R, omega = slow_precession(tilt)
    sizes, errors = [100, 200, 400], []
    for steps in sizes:
        top = wr.RigidBody(TOP, None, rotation=R, angular_velocity=omega, potential=weight)
        axes = history(top, end / steps, steps, steps // 20, lambda top: top.rotation[:, 2])
        phi = rate * np.linspace(0, end, 21)
        exact = np.stack([np.sin(tilt) * np.sin(phi), -np.sin(tilt) * np.cos(phi), np.cos(tilt) + 0 * phi], axis=-1)
        errors.append((abs(axes - exact).max(), abs(axes[:, 2] - np.cos(tilt)).max()))
    verified.order(
        "wr.RigidBody: steady precession of a heavy top: order in Δt of its axis, and of the nutation",
        measured=[slope(sizes, [e[i] for e in errors]) for i in (0, 1)], reference="precession in closed form",
    )  # fmt: skip
    assert errors[-1][0] < 2e-3


# --- order and conservation ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["rigid body", "body in an ideal fluid", "in a potential of place and orientation"])
def test_the_motion_is_second_order(kind, verified):
    mass = np.full(3, 1.5) if kind == "rigid body" else M
    potential = coupled if "potential" in kind else None
    exact, sizes, errors = exact_motion(mass, 3.0, potential), [40, 80, 160], []
    for steps in sizes:
        body = wr.RigidBody(J, mass, angular_velocity=OMEGA, velocity=U, potential=potential)
        body.step(3.0 / steps, steps)
        apart = [abs(a - b).max() for a, b in zip(readings(body), exact, strict=True)]
        if kind == "rigid body":
            assert apart.pop(1) < 1e-11  # the centre of mass moves uniformly
        errors.append(apart)
    verified.order(
        f"wr.RigidBody: {kind}: order in Δt of R, r, ω, u",
        measured=[slope(sizes, column) for column in zip(*errors, strict=True)], reference="SciPy's `solve_ivp`",
    )  # fmt: skip


def test_spatial_momentum_is_conserved_and_the_energy_does_not_drift(verified):
    """Two free bodies at once, one of them in an ideal fluid, over 2000 steps."""
    bodies = wr.RigidBody(J, [[1.5], [1.0]] * np.array([np.ones(3), M]), angular_velocity=OMEGA, velocity=U)
    angular, linear = bodies.spatial_momentum

    def now(bodies):
        p, l = bodies.spatial_momentum
        return np.concatenate([[bodies.energy], [abs(p - angular).max(-1)], [abs(l - linear).max(-1)]])

    found = history(bodies, 0.05, 2000, 10, now)
    verified.below(
        "conservation", "wr.RigidBody: change of spatial momentum, linear and angular", bound=1e-10,
        measured=[found[:, 2].max(), found[:, 1].max()], reference="0 over 2000 steps",
    )  # fmt: skip
    energies = found[:, 0]
    amplitude = np.ptp(energies, axis=0)
    assert (amplitude > 1e-6).all() and (amplitude < 2e-3 * energies[0]).all()
    early, late = (abs(part - energies[0]).max(axis=0) for part in (energies[:20], energies[20:]))
    verified.below(
        "conservation", "wr.RigidBody: largest error of the energy in steps 200 to 2000, over that before",
        measured=late / early, bound=1.5, reference="1 without drift, 10 with a steady one",
    )  # fmt: skip
    gram = np.swapaxes(bodies.rotation, -1, -2) @ bodies.rotation
    assert abs(gram - np.eye(3)).max() < 3e-15


def test_momenta_of_symmetric_potentials_are_conserved(verified):
    """A heavy symmetric top: about the vertical, and about its axis. A potential symmetric about z: about z alone."""
    _, R, _ = slow_precession(0.6)
    top = wr.RigidBody(TOP, None, rotation=R, angular_velocity=[0.9, 0.3, 4.0], potential=weight)
    body = wr.RigidBody(J, M, angular_velocity=OMEGA, velocity=U, potential=coupled)

    def of_top(top):
        return [top.spatial_momentum[0][2], top.momentum[0][2], top.energy, top.rotation[2, 2]]

    def of_body(body):
        return [body.spatial_momentum[0][2], body.energy, body.spatial_momentum[0][0]]

    tops, found = (history(b, 0.02, 600, 3, what) for b, what in ((top, of_top), (body, of_body)))
    assert np.ptp(tops[:, 3]) > 0.1 and np.ptp(found[:, 2]) > 0.5  # it nutates; other momenta change
    verified.below(
        "conservation", "wr.RigidBody: momenta of a heavy top, and of a potential symmetric about z",
        measured=[np.ptp(tops[:, 0]), np.ptp(tops[:, 1]), np.ptp(found[:, 0])], bound=1e-12,
        reference="0 over 600 steps",
    )  # fmt: skip
    for energy in (tops[:, 2], found[:, 1]):
        early, late = (abs(part - energy[0]).max() for part in (energy[:40], energy[40:]))
        assert 1e-7 < early < 5e-3 * abs(energy[0]) and late < 2 * early  # a drift would make it five times as large


def test_the_way_back_is_the_same(verified):
    body = wr.RigidBody(J, M, angular_velocity=OMEGA, velocity=U, potential=coupled)
    start = [*readings(body), body.time]
    body.step(0.05, 150)
    assert body.time == pytest.approx(7.5)
    body.step(-0.05, 150)
    verified.below(
        "symmetry", "wr.RigidBody: 150 steps and as many back", bound=1e-11, reference="the start",
        measured=[np.abs(a - b).max() for a, b in zip([*readings(body), body.time], start, strict=True)],
    )  # fmt: skip


# --- how it is used --------------------------------------------------------------------------------------------------


def test_bodies_in_a_batch_move_as_alone():
    masses = np.array([[1.0], [2.0]])
    places = np.array([[0.1, 0.0, 0.2], [0.4, -0.2, 0.0]])
    both = wr.RigidBody(J, masses, position=places, angular_velocity=OMEGA, potential=coupled)
    both.step(0.02, 20)
    for i in range(2):
        one = wr.RigidBody(J, masses[i], position=places[i], angular_velocity=OMEGA, potential=coupled)
        one.step(0.02, 20)
        for whole, single in zip(readings(both), readings(one), strict=True):
            np.testing.assert_allclose(whole[i], single, atol=1e-14)
    assert both.energy.shape == (2,) and one.energy.shape == ()
    assert repr(both) == "<RigidBody: bodies [2], t = 0.4>" and repr(one) == "<RigidBody: a body, t = 0.4>"


@pytest.mark.parametrize(
    "given, words",
    [
        ({"inertia": [1.0, 2.0]}, r"inertia: must be vectors \[..., 3\]"),
        ({"inertia": [1.0, 2.0, 0.0]}, "inertia = 0: must be positive"),
        ({"mass": -1.0}, "mass = -1: must be positive"),
        ({"mass": None, "velocity": U}, "velocity.*zero for a body that turns about a fixed point"),
        ({"position": np.zeros((2, 3)), "velocity": np.zeros((4, 3))}, "leading axes must agree"),
        ({"rotation": 2 * np.eye(3)}, "rotation: must be a rotation"),
        ({"potential": lambda r: 0}, "potential: must be a function"),
        ({"potential": lambda R, r: R[..., 2, 2]}, r"potential.*returns \(V, dV/dR, dV/dr\)"),
        ({"potential": lambda R, r: (0.0, 0.0, np.zeros(2))}, "potential, dV/dr: must be finite numbers"),
        ({"potential": lambda R, r: (r[..., 2], 0 * R, 0 * r)}, "moving along axis 2 .* changes V at the rate 1"),
        ({"potential": lambda R, r: (R[..., 2, 1], 0 * R, 0 * r)}, "turning about axis 0 of the body changes V"),
    ],
)  # fmt: skip
def test_wrong_arguments_are_named(given, words):
    with pytest.raises(wr.SceneError, match=words):
        wr.RigidBody(**({"inertia": J} | given))


def test_units_are_those_of_the_user():
    """In micrometres and newtons a body moves as in its own units; the check of its potential, too."""
    length, time, mass = 1e-6, 1e-3, 1e-15

    def tiny(R, r):
        V, by_R, by_r = coupled(R, r / length)
        energy = mass * length**2 / time**2
        return V * energy, by_R * energy, by_r * energy / length

    one = wr.RigidBody(J, M, angular_velocity=OMEGA, velocity=U, potential=coupled)
    other = wr.RigidBody(
        J * mass * length**2, M * mass, angular_velocity=OMEGA / time, velocity=U * length / time, potential=tiny
    )
    one.step(0.05, 20)
    other.step(0.05 * time, 20)
    np.testing.assert_allclose(other.rotation, one.rotation, atol=1e-13)
    np.testing.assert_allclose(other.position / length, one.position, atol=1e-13)


def test_a_step_that_is_too_long_is_named():
    body = wr.RigidBody(J, angular_velocity=[0.0, 30.0, 0.0])
    with pytest.raises(wr.SceneError, match=r"dt = 0.1: at t = 0 a body turns by more than a radian.*try dt = 0.01"):
        body.step(0.1)
    with pytest.raises(wr.SceneError, match=r"dt = 0.0: must be different from zero"):
        body.step(0.0)

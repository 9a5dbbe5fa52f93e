"""The forces (5.41), (5.42) and end conditions (D.59)-(D.61) are minus the gradient of the energy.

The formulas are those of the twin, with which the kernels agree to round-off, on curves resolved to round-off. A motion
in the surface that conserves arc length, with any u2(s) and u1' = Ω u2, changes the energy by −∫(F1 u1 + F2 u2) ds and
end terms (D.58). The motion moves the middle frame and changes Ω by (D.27), so the kinematics is tested as well.
"""

import numpy as np
import pytest
from examples.bound import INTRINSIC, LENGTH, STIFFNESS, TWINS, graded_parameters, start_frame, trace, wave
from numpy.polynomial import Chebyshev, chebyshev
from reference import bound as twin

POINTS = 41
X = chebyshev.chebpts2(POINTS)
MIDDLE = POINTS // 2
VALUES = chebyshev.chebvander(X, POINTS)
STEP = 3e-4
ACCURACY = 1e-9
"""Relative error of differences of fourth order, for energies known to 1e-13."""


def coefficients(values):
    """Chebyshev coefficients of values at the points X [point, ...]."""
    return np.linalg.solve(VALUES[:, :-1], values)


def derivative(values, half):
    """d/ds on a rod of length 2 half."""
    return VALUES[:, : POINTS - 1] @ chebyshev.chebder(coefficients(values)) / half


def antiderivative(values, half):
    """∫ from the start of the rod."""
    return VALUES @ chebyshev.chebint(coefficients(values), lbnd=-1) * half


def random_points(rng):
    return wave(rng)(X)


def parameters(rod, along):
    """Parameters of a rod for the twin; spacing and drag are not used. along: whether they change along the rod."""
    B, sigma = STIFFNESS[rod], INTRINSIC[rod]
    if along:
        B, sigma = (graded_parameters(X)[name][rod] for name in ("stiffness", "intrinsic"))
    return twin.Rod(None, np.nan, B, sigma, np.full(3, np.nan))


class Curve:
    """A filament given by Ω at the points X and by the frame of its middle."""

    def __init__(self, kind, rod, geodesic, r, q, along):
        self.half, self.geodesic, self.along = LENGTH[rod] / 2, geodesic, along
        turn, surface = Chebyshev(coefficients(geodesic)), TWINS[kind]
        self.position, self.tangent = trace(surface, lambda s: turn(s / self.half), r, q, self.half * X)
        self.K = surface.curvature(self.position, self.tangent)
        values = parameters(rod, along)
        self.moment = twin.moments(values, self.K, geodesic)
        density = self.moment**2 / values.stiffness / 2
        self.energy = antiderivative(density.sum(-1), self.half)[-1]


def motion(curve, rng):
    """u1, u2, ω[2] and ∂Ω/∂t at the points for a random u2: (D.24), (D.25), (D.27)."""
    u2 = random_points(rng)
    u1 = rng.normal() + antiderivative(curve.geodesic * u2, curve.half)
    slope = derivative(u2, curve.half)
    omega2 = slope + curve.geodesic * u1
    bend = derivative(slope, curve.half) + (curve.geodesic**2 + twin.gaussian(curve.K)) * u2
    return u1, u2, omega2, bend + derivative(curve.geodesic, curve.half) * u1


def moved(kind, rod, curve, velocities, t):
    """The curve after a motion for the time t."""
    u1, u2, omega2, rate = velocities
    surface, r, q = TWINS[kind], curve.position[MIDDLE], curve.tangent[MIDDLE]
    n = surface.normal(r)
    q1 = np.cross(n, q)
    omega1 = -curve.K[MIDDLE, 0] * u1[MIDDLE] - curve.K[MIDDLE, 1] * u2[MIDDLE]
    x = r + t * (u1[MIDDLE] * q + u2[MIDDLE] * q1)
    for _ in range(4):
        x = surface.newton(x)
    tangent = surface.frame(x, q + t * (omega2[MIDDLE] * q1 - omega1 * n))[:, 0]
    return Curve(kind, rod, curve.geodesic + t * rate, x, tangent, curve.along)


def energy_rate(kind, rod, curve, velocities):
    """dE/dt by differences of fourth order."""
    E = [moved(kind, rod, curve, velocities, k * STEP).energy for k in (-2, -1, 1, 2)]
    return (E[0] - 8 * E[1] + 8 * E[2] - E[3]) / (12 * STEP)


def virtual_power(curve, velocities, tension):
    """−∫(F1 u1 + F2 u2) ds and the end terms (D.58); the result does not depend on λ(s), which does no work."""
    u1, u2, omega2, _rate = velocities
    K, m, geodesic, half = curve.K, curve.moment, curve.geodesic, curve.half
    dm = derivative(m, half)
    dshear = derivative(twin.shear(K, m), half)
    F1 = derivative(tension, half) + twin.tangential_force(twin.strain(K, geodesic), dm, 0.0)
    F2 = geodesic * tension + twin.transverse_force(K, geodesic, m, dm, derivative(dm[:, 2], half), dshear, 0.0)
    at_ends = (tension - twin.end_tension(K, m)) * u1 - (dm[:, 2] - twin.end_slope(K, m)) * u2 + m[:, 2] * omega2
    return at_ends[-1] - at_ends[0] - antiderivative(F1 * u1 + F2 * u2, half)[-1]


@pytest.mark.parametrize("kind", TWINS)
@pytest.mark.parametrize("rod", range(len(LENGTH)))
@pytest.mark.parametrize("along", [False, True], ids=["uniform", "graded"])
def test_forces_are_minus_the_energy_gradient(kind, rod, along, verified):
    rng = np.random.default_rng(11 + rod + 30 * along)
    curve = Curve(kind, rod, random_points(rng), *start_frame(kind, rod), along)
    powers, rates = [], []
    for _ in range(2):
        velocities = motion(curve, rng)
        rates.append(energy_rate(kind, rod, curve, velocities))
        powers.append(virtual_power(curve, velocities, random_points(rng)))
    assert np.abs(rates).min() > 0.1
    verified(
        "conservation",
        f"{'graded ' * along}filament {rod} on {kind}: virtual power of forces and end conditions, two motions",
        measured=powers, expected=rates, relative=ACCURACY, reference="dE/dt by differences of fourth order; (D.58)",
    )  # fmt: skip

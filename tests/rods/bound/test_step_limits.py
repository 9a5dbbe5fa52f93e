"""The bounds on the time step: orientation stiffness against closed forms, and runs on either side of the bound."""

from types import SimpleNamespace

import numpy as np
import pytest

from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.step_limits import filament_limits, orientation_limit, orientation_stiffness

TORUS = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
CYLINDER = surfaces.make("cylinder", {"radius": 1.0})


def energy_on_torus(alpha: np.ndarray, theta: float, stiffness, intrinsic) -> np.ndarray:
    """Energy per length of a geodesic piece at angle α from the tube's small circle, at angle θ round it."""
    round_tube, along_tube = -1 / 0.4, -np.cos(theta) / (1 + 0.4 * np.cos(theta))
    K11 = round_tube * np.cos(alpha) ** 2 + along_tube * np.sin(alpha) ** 2
    K12 = (along_tube - round_tube) * np.sin(alpha) * np.cos(alpha)
    return 0.5 * stiffness[0] * (K12 - intrinsic[0]) ** 2 + 0.5 * stiffness[1] * (-K11 - intrinsic[1]) ** 2


@pytest.mark.parametrize("intrinsic", [(0.0, 0.0, 0.0), (0.8, 1.5, 0.3), (-0.8, -2.0, 0.0), (2.0, 0.0, 0.0)])
def test_orientation_stiffness_is_the_second_difference_of_the_energy(intrinsic):
    stiffness, theta = (1.0, 2.5, 0.8), np.array([0.0, 1.0, 2.5])
    rho = 1 + 0.4 * np.cos(theta)
    points = np.stack([rho * np.cos(0.3), rho * np.sin(0.3), 0.4 * np.sin(theta)], axis=-1)
    alpha, h = np.linspace(0, np.pi, 721), 1e-3
    for point, angle in zip(points, theta, strict=True):
        e = [energy_on_torus(alpha + shift, angle, stiffness, intrinsic) for shift in (-h, 0, h)]
        exact = ((e[0] - 2 * e[1] + e[2]) / h**2).max()
        found = orientation_stiffness(TORUS, point[None], np.array(stiffness), np.array(intrinsic))
        assert found == pytest.approx(exact, rel=5e-3)  # the angles it looks at are 2.5° apart
    largest = [orientation_stiffness(TORUS, p, np.array(stiffness), np.array(intrinsic)) for p in (points, points[:1])]
    assert largest[0] >= largest[1]


STATES = [(1.0, 1.0), (10.0, 1.0), (10.0, 0.6), (10.0, 0.4), (10.0, 0.1)]
"""B1 = B2 and B3: e'' L²/B3 = 2, 20, 34, 50 and 202 on the hoop, through each branch of the bound."""


def near_the_hoop(bend: float, geodesic: float, angle: float = 0.1) -> BoundRods:
    """A filament that is at rest along the hoop, where e'' is largest, and starts at an angle to it."""
    direction = [[0, np.cos(angle), np.sin(angle)]]
    stiffness = (bend, bend, geodesic)
    return BoundRods(
        CYLINDER, [[1.0, 0, 0]], direction, nodes=33, length=1.2, stiffness=stiffness, intrinsic=(0, 1.2, 0)
    )


def settled(share: float, bend: float, geodesic: float) -> bool:
    """Whether it is at rest along the hoop after the time of 500 steps of the bound."""
    rods = near_the_hoop(bend, geodesic)
    dt = share * filament_limits(CYLINDER, np.array([[1.0, 0, 0]]), rods).step
    rods.step(dt, int(500 / share))
    found = rods.variables()
    rest = 0.5 * bend * (1 - 1.2) ** 2 * 1.2
    still = found["status"][0] == 0 and found["dissipation"][0] < 1e-8
    return bool(still and found["energy"][0] == pytest.approx(rest, rel=1e-8))


@pytest.mark.parametrize(("bend", "geodesic"), STATES)
def test_the_bound_is_kept_by_the_scheme_and_not_far_from_its_own(bend, geodesic):
    assert settled(0.3, bend, geodesic)
    assert settled(0.9, bend, geodesic)
    assert not settled(3.0, bend, geodesic)


def test_no_stiffness_no_bound():
    assert orientation_limit(0.0, 1.0, 2.0, 1.0) == np.inf


def test_the_stiffest_rod_of_an_ensemble_sets_the_bound():
    def bound(*stiffest: float) -> float:
        B = np.array([[b, b, 1.0] for b in (1.0, *stiffest)])
        rods = SimpleNamespace(stiffness=B, intrinsic=0 * B, drag=0 * B + [1, 2, 0.1], length=np.full(len(B), 1.2))
        return filament_limits(CYLINDER, np.array([[1.0, 0, 0]]), rods).step

    assert bound(5.0) == bound(5.0, 2.0) < bound(2.0) < bound()

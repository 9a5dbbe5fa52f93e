"""Bounds on the time step: orientation stiffness against closed forms, and runs below and above the bound."""

from types import SimpleNamespace

import numpy as np
import pytest

from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.step_limits import (
    BENDING,
    SLIDING,
    bent_start_limit,
    filament_limits,
    membrane_limit,
    node_limit,
    orientation_limit,
    orientation_stiffness,
    sliding_limit,
)
from warp_rods.scene.scene import Scene
from warp_rods.simulation import Simulation

TORUS = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
CYLINDER = surfaces.make("cylinder", {"radius": 1.0})


def energy_on_torus(alpha: np.ndarray, theta: float, stiffness, intrinsic) -> np.ndarray:
    """Energy per length of a geodesic filament at angle α to the small circle of the tube, at the angle θ on it."""
    around_tube, along_tube = -1 / 0.4, -np.cos(theta) / (1 + 0.4 * np.cos(theta))
    K11 = around_tube * np.cos(alpha) ** 2 + along_tube * np.sin(alpha) ** 2
    K12 = (along_tube - around_tube) * np.sin(alpha) * np.cos(alpha)
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
        assert found == pytest.approx(exact, rel=5e-3)  # it is evaluated at angles 2.5° apart
    largest = [orientation_stiffness(TORUS, p, np.array(stiffness), np.array(intrinsic)) for p in (points, points[:1])]
    assert largest[0] >= largest[1]


STATES = [(1.0, 1.0), (10.0, 1.0), (10.0, 0.6), (10.0, 0.4), (10.0, 0.1)]
"""B1 = B2 and B3: e'' L²/B3 = 2, 20, 34, 50 and 202 along the circumference, for each branch of the bound."""


def near_circumference(bend: float, geodesic: float, angle: float = 0.1) -> BoundRods:
    """A filament that starts at an angle to its rest state along the circumference, where e'' is largest."""
    direction = [[0, np.cos(angle), np.sin(angle)]]
    stiffness = (bend, bend, geodesic)
    return BoundRods(
        CYLINDER, [[1.0, 0, 0]], direction, nodes=33, length=1.2, stiffness=stiffness, intrinsic=(0, 1.2, 0)
    )


def relaxed(fraction: float, bend: float, geodesic: float) -> bool:
    """Whether it is at rest along the circumference after the time of 500 steps of the bound."""
    rods = near_circumference(bend, geodesic)
    dt = fraction * filament_limits(CYLINDER, np.array([[1.0, 0, 0]]), rods).step
    rods.step(dt, int(500 / fraction))
    found = rods.variables()
    rest = 0.5 * bend * (1 - 1.2) ** 2 * 1.2
    still = found["status"][0] == 0 and found["dissipation"][0] < 1e-8
    return bool(still and found["energy"][0] == pytest.approx(rest, rel=1e-8))


@pytest.mark.parametrize(("bend", "geodesic"), STATES)
def test_the_scheme_is_stable_below_the_bound_and_unstable_at_three_times_it(bend, geodesic):
    assert relaxed(0.3, bend, geodesic)
    assert relaxed(0.9, bend, geodesic)
    assert not relaxed(3.0, bend, geodesic)


def test_a_loop_of_ones_own_is_told_that_its_step_is_too_long(caplog):
    """Above its bound the filament swings for ever, with a thousand times the energy that it has at rest."""
    energies = []
    for fraction in (0.9, 3.0):
        rods = near_circumference(10.0, 1.0)
        bound = filament_limits(CYLINDER, np.array([[1.0, 0, 0]]), rods)
        assert rods.step_limit.step == pytest.approx(bound.step, rel=1e-12)
        rods.step(fraction * rods.step_limit.step, int(500 / fraction))
        energies.append(float(rods.energy[0] - 0.5 * 10.0 * (1 - 1.2) ** 2 * 1.2))
        assert len(caplog.messages) == (fraction > 1)
    assert energies[1] > 1000 * abs(energies[0])


def test_a_run_says_it_in_its_own_words_only(caplog):
    """The bound of a run is that of its ensembles; what contact and warming up do is not a loop of one's own."""
    filament = {"name": "f", "count": 1, "nodes": 17, "length": 1.0, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
    table = {"surface": {"kind": "torus", "major": 1.0, "minor": 0.4}, "filaments": [filament]}
    simulation = Simulation(Scene.parse(table | {"time": {"end": 1.0, "step": 0.5}}), "cpu")
    simulation.warm_up()
    list(simulation.to_next_frame())
    (warning,) = simulation.warnings
    assert f"above {simulation.ensembles['f'].step_limit.step:.3g}, the bound for f" in warning
    assert not caplog.messages


def test_passive_free_rods_have_no_bound(caplog):
    rods = FreeRods(1, 17, bend=1.0, twist=1.0, flagella=None, shape={"kind": "mode", "amplitude": 1e-3})
    rods.step(1.0)
    assert rods.step_limit.step == np.inf and not caplog.messages


def test_without_orientation_stiffness_there_is_no_bound():
    assert orientation_limit(0.0, 1.0, 2.0, 1.0) == np.inf


def test_the_stiffest_rod_of_an_ensemble_sets_the_bound():
    def bound(*stiffest: float) -> float:
        B = np.array([[b, b, 1.0] for b in (1.0, *stiffest)])
        rods = SimpleNamespace(stiffness=B, intrinsic=0 * B, drag=0 * B + [1, 2, 0.1], length=np.full(len(B), 1.2))
        return filament_limits(CYLINDER, np.array([[1.0, 0, 0]]), rods).step

    assert bound(5.0) == bound(5.0, 2.0) < bound(2.0) < bound()


def filaments(length: float = 0.5, intrinsic=(0.0, 1.0, 0.0), drag=(1.0, 2.0, 0.1)) -> SimpleNamespace:
    one = {"stiffness": (1.0, 1.0, 1.0), "intrinsic": intrinsic, "drag": drag, "length": length}
    return SimpleNamespace(nodes=33, **{name: np.array([value]) for name, value in one.items()})


THIN = {
    "cassini": ({"a": 1.0, "b": 1.003}, [[np.sqrt(1.003**2 - 1), 0.0, 0.0]]),
    "bridge": ({"neck": 0.06, "body": 1.0, "width": 0.3, "length": 6.0}, [[0.06, 0.0, 0.0]]),
}
"""Surfaces with thin necks, and a point of the neck."""


@pytest.mark.parametrize("kind", THIN)
def test_the_bound_is_that_of_the_thinnest_neck(kind):
    """400 points that are uniform in area miss it."""
    values, neck = THIN[kind]
    surface, rods = surfaces.make(kind, values), filaments(length=0.1, drag=(1e3, 2.0, 0.1))
    exact = filament_limits(surface, np.array(neck), rods).step
    assert membrane_limit(surface, rods).step == pytest.approx(exact, rel=0.05)


def test_the_bound_counts_where_the_nodes_are():
    """A neck far from everything else: of 3000 lengths of tube one is curved."""
    surface = surfaces.make("bridge", {"neck": 0.4, "body": 1.0, "width": 1.0, "length": 3000.0})
    rods = BoundRods(surface, [[0.4, 0, 0]], [[0, 1, 0]], nodes=33, length=0.4)
    exact = filament_limits(surface, rods.position.reshape(-1, 3), rods).step
    assert membrane_limit(surface, rods, rods.position).step == pytest.approx(exact, rel=0.05)
    assert node_limit(rods.curvature, rods)[0] == pytest.approx(exact, rel=1e-2)


def test_the_bound_of_sliding_on_a_crest():
    """On z = a cos kx at x = 0: e'' = B2 (σ2 − a k²) a k² (k² + 3 a² k⁴) along x."""
    a, k, sigma = 0.2, 1.5, 2.0
    values = {"phi": "z - a*cos(k*x)", "box": [[-3, 3]] * 3, "parameters": {"a": a, "k": k}}
    sheet = surfaces.make("expression", values)
    exact = (sigma - a * k**2) * a * k**2 * (k**2 + 3 * a**2 * k**4)
    rods = filaments(intrinsic=(0.0, sigma, 0.0), drag=(0.01, 2.0, 0.1))
    beside = np.array([[x, 0.0, a * np.cos(k * x)] for x in (0.0, 0.5)])
    found = sliding_limit(sheet, beside, rods).step
    assert found == pytest.approx(SLIDING * 0.01 / exact, rel=1e-3)
    sphere = surfaces.make("sphere", {"radius": 1.0})
    assert sliding_limit(sphere, np.array([[0.0, 0.0, 1.0]]), rods).step > 1e6


def test_a_bent_start_bounds_the_step_by_its_relaxation():
    rods = filaments(length=0.5)
    assert bent_start_limit(rods, np.zeros((1, 33))).step == np.inf
    bent = bent_start_limit(rods, np.full((1, 33), 1.0)).step
    assert bent == pytest.approx(BENDING * 2.0 * 0.5**4 / 4.73004**4, rel=1e-4)

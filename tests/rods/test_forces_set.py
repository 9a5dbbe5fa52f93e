"""Forces that are set between steps, in steps of a given length and by error, and from hooks of a run by error."""

import numpy as np
import pytest

from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.free.rods import FreeRods
from warp_rods.scene.scene import Scene
from warp_rods.simulation.hooks import every
from warp_rods.simulation.loop import Simulation

ZETA = 2.0
"""Drag across of both rods."""


def free() -> FreeRods:
    return FreeRods(1, 33, bend=5e-3, twist=1e-3, flagella=None, shape={"kind": "straight"}, device="cpu")


def bound() -> BoundRods:
    plane = surfaces.make("plane", {})
    return BoundRods(plane, [[0, 0, 0]], [[1, 0, 0]], nodes=17, drag=(1.0, ZETA, 0.1), device="cpu")


def height(rods) -> float:
    return float(rods.position[0, rods.middle if isinstance(rods, BoundRods) else rods.nodes // 2, 1])


@pytest.mark.parametrize("make", [free, bound])
def test_a_force_holds_in_steps_by_error(make, verified):
    """A straight rod moves at F/ζ⊥; the force of the last steps is not extrapolated beyond them."""
    rods = make()
    rods.force = [0.0, 1.0, 0.0]
    rods.step(1e-3, 5)
    rods.force = [0.0, 1.1, 0.0]
    rods.step(1e-3, 1)
    rods.advance_to(1.0)
    verified(
        "exact", f"{make.__name__} rod under a force that changes once: path", measured=height(rods),
        expected=(0.005 + 0.995 * 1.1) / ZETA, within=1e-4, reference="∫F dt/ζ⊥",
    )  # fmt: skip
    assert rods.power[0] == pytest.approx(1.1**2 / ZETA, rel=1e-9)


@pytest.mark.parametrize("make", [free, bound])
def test_a_force_that_ends_does_not_act_backwards(make):
    rods = make()
    rods.force = [0.0, 1.0, 0.0]
    rods.step(1e-3, 5)
    before = height(rods)
    rods.force = [0.0, 0.0, 0.0]
    rods.step(1e-3, 1)
    assert -1e-9 < height(rods) - before < 2e-4
    rods.step(1e-3, 20)
    assert height(rods) == pytest.approx(0.005 / ZETA, abs=3e-4)


@pytest.mark.parametrize("make", [free, bound])
def test_a_force_that_changes_from_step_to_step_keeps_second_order(make, verified):
    errors = []
    for count in (25, 50, 100):
        rods = make()
        for k in range(count):
            rods.force = [0.0, np.sin(3 * k / count), 0.0]
            rods.step(1 / count)
        errors.append(abs(height(rods) - (1 - np.cos(3)) / 3 / ZETA))
    verified.order(
        f"{make.__name__} rod under a force set at each step: order in Δt",
        measured=-np.polyfit(np.log([25, 50, 100]), np.log(errors), 1)[0], reference="(1 − cos 3)/3ζ⊥ for sin 3t",
    )  # fmt: skip


@pytest.mark.parametrize("kind", ["swimmers", "filaments"])
def test_a_hook_sets_a_force_in_a_run_by_error(kind):
    """From t = ½ on; rods that have taken steps of their own beyond it begin anew there."""
    swimmer = {"bend": 5e-3, "twist": 1e-3, "flagella": {"law": "held", "profile": "uniform"}}
    placed = {"position": [[0, 0, 0]], "direction": [[1, 0, 0]]}
    filament = {"length": 1.0, "stiffness": [1, 1, 1], "drag": [1.0, ZETA, 0.1], "placement": placed}
    table = {"name": "rod", "count": 1, "nodes": 33} | (filament if kind == "filaments" else swimmer)
    if kind == "swimmers":
        table["shape"] = {"kind": "straight"}
    scene = {kind: [table], "surface": {"kind": "plane"}, "time": {"end": 1.0, "save_every": 0.1}}
    if kind == "swimmers":
        del scene["surface"]
    run = Simulation(Scene.parse(scene), "cpu")

    def push(simulation: Simulation) -> None:
        simulation.ensembles["rod"].force = np.array([0.0, 0.3 * (simulation.now > 0.4), 0.0])

    run.attach(every(time=0.25), push)
    for _ in run.advance():
        pass
    assert run.now == 1.0 and run.steps_taken > 10
    assert height(run.ensembles["rod"]) == pytest.approx(0.5 * 0.3 / ZETA, rel=1e-3)


def test_a_restored_filament_shows_the_same_time():
    """Within a step of its own that goes beyond."""
    torus = surfaces.make("torus", {"major": 1.0, "minor": 0.4})

    def make() -> BoundRods:
        given = {"nodes": 17, "length": 0.6, "intrinsic": (0.5, 0.8, 2.0), "device": "cpu"}
        return BoundRods(torus, [[1.3, 0.1, 0.25]], [[0.3, 1.0, 0.4]], **given)

    rods, other = make(), make()
    rods.advance_to(0.01)
    other.restore(rods.state())
    np.testing.assert_array_equal(other.position, rods.position)
    rods.step(1e-3, 3)
    other.step(1e-3, 3)
    np.testing.assert_array_equal(other.position, rods.position)

"""The estimate of time knows the events of behaviours, and what is said of bodies."""

import pytest

from warp_rods.scene.scene import Scene
from warp_rods.simulation import timing
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.units import lines_of_units

CELL = {"name": "a", "count": 2, "nodes": 17, "bend": 1e-2, "twist": 1e-2, "flagella": {"law": "driven"}}


def test_events_shorten_the_usual_step():
    plain = Simulation(Scene(swimmers=[CELL], time={"end": 10.0}), "cpu")
    behaviour = {"reversal": {"rate": [1.0, 3.0]}, "tumble": {"rate": 4.0, "duration": 0.1, "turn": 1.0}}
    often = Simulation(Scene(swimmers=[CELL | {"behaviour": behaviour}], time={"end": 10.0}), "cpu")
    assert timing._events(plain) == 0 and timing._events(often) == pytest.approx(2 + 2 * 4)
    steps = 1 / timing._settled_step(often) - 1 / timing._settled_step(plain)
    assert steps == pytest.approx(timing.STEPS_OF_EVENT * 10)


def test_a_swimmer_without_a_body_beside_one_is_told():
    body = {"length": "20 um", "diameter": "0.8 um", "viscosity": "1 mPa s", "speed": "25 um/s"}
    scene = Scene(swimmers=[CELL | {"body": body}, CELL | {"name": "b"}], time={"end": 1.0})
    assert any(line.startswith("b: has no body: its drag_ratio, 2") for line in lines_of_units(scene))

"""Functions attached to a simulation: called when due, without a change of the bits of the run."""

import numpy as np
import pytest
from examples.scene import small

from warp_rods.errors import SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.hooks import every
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.runner import simulate

CELL = {"name": "cell", "count": 2, "nodes": 33, "bend": 5e-3, "twist": 1e-3}
TIME = {"end": 0.1, "step": 1e-3, "save_every": 0.04}
CROSSED = {"position": [[-0.6, 0, 0], [0, -0.62, 0.02]], "direction": [[1, 0, 0], [0, 1, 0]]}
STERIC = {"strength": 2000.0, "range": 0.02, "core": 0.08}


def free() -> Simulation:
    return Simulation(Scene(swimmers=[CELL], time=TIME), "cpu")


def crossed() -> Simulation:
    cell = {**CELL, "placement": CROSSED, "flagella": {"profile": "uniform"}, "shape": {"kind": "straight"}}
    return Simulation(Scene(swimmers=[cell], steric=STERIC, time={**TIME, "step": 0.01, "save_every": 0.1}), "cpu")


def run(simulation: Simulation) -> Simulation:
    for _ in simulation.advance():
        pass
    return simulation


def test_hooks_are_called_when_they_are_due():
    simulation = free()
    calls = {"steps": [], "time": [], "once a step": []}
    simulation.attach(every(steps=25), lambda s: calls["steps"].append(s.steps_taken))
    simulation.attach(every(time=0.03), lambda s: calls["time"].append(s.now))
    simulation.attach(every(steps=1), lambda s: calls["once a step"].append(s.now))
    run(simulation)
    assert calls["steps"] == [0, 25, 50, 75, 100]
    np.testing.assert_allclose(calls["time"], [0.0, 0.03, 0.06, 0.09], atol=1e-12)
    np.testing.assert_allclose(calls["once a step"], np.arange(101) * 1e-3, atol=1e-12)


@pytest.mark.parametrize("make", [free, crossed])
def test_hooks_do_not_change_the_bits(make):
    seen = []
    plain, watched = make(), make()
    watched.attach(every(steps=1), lambda s: seen.append(s.ensembles["cell"].energy.sum()))
    run(plain), run(watched)
    assert len(seen) > 2
    np.testing.assert_array_equal(watched.ensembles["cell"].position, plain.ensembles["cell"].position)


def test_hooks_see_accepted_steps_only():
    simulation, times = crossed(), []
    simulation.attach(every(steps=1), lambda s: times.append(s.now))
    run(simulation)
    assert simulation.contact.finest > 1
    assert times[0] == 0.0 and times[-1] == pytest.approx(0.1)
    assert (np.diff(times) > 0).all()


def test_a_hook_may_stop_the_run(tmp_path):
    """At the next frame, which is saved. The run can be resumed to its end."""

    def enough(simulation):
        if simulation.now > 0.05:
            simulation.stop("that was enough")

    scene = Scene(swimmers=[CELL], time=TIME)
    stopped = simulate(scene, tmp_path / "run", device="cpu", hooks=[(every(steps=10), enough)])
    np.testing.assert_allclose(stopped.data["cell"].time, [0.0, 0.04, 0.08])
    assert stopped.messages[-1] == "stopped at t = 0.08: that was enough"
    assert stopped.data.attrs["messages"] == stopped.messages
    resumed = simulate(scene, tmp_path / "run", device="cpu", resume=True)
    whole = simulate(scene, tmp_path / "whole", device="cpu")
    np.testing.assert_array_equal(resumed.data["cell"].position, whole.data["cell"].position)
    assert resumed.data.attrs["messages"] == stopped.messages + resumed.messages


def test_a_hook_is_not_called_for_times_before_a_restart():
    simulation, times = free(), []
    for _ in simulation.to_next_frame():
        pass
    state, again = simulation.state(), free()
    again.attach(every(time=0.03), lambda s: times.append(s.now))
    again.restore(state)
    run(again)
    np.testing.assert_allclose(times, [0.06, 0.09], atol=1e-12)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "give steps or time"),
        ({"steps": 1, "time": 1.0}, "give steps or time"),
        ({"steps": 0}, "steps = 0: must be a whole number, 1 or more"),
        ({"steps": 1.5}, "steps = 1.5"),
        ({"time": 0.0}, "time = 0.0: must be positive"),
        ({"time": float("nan")}, "time = nan: must be positive"),
    ],
)
def test_impossible_cadences_are_refused(given, said):
    with pytest.raises(SceneError, match=said):
        every(**given)


def test_hooks_work_for_filaments():
    simulation, seen = Simulation(Scene.parse(small(time__end=0.1, time__step=0.01)), "cpu"), []
    simulation.attach(every(steps=1), lambda s: seen.append(s.now))
    run(simulation)
    assert len(seen) == simulation.frames.steps_to(simulation.frames.last) + 1

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
    assert simulation.together.control.taken > 2 * simulation.steps_taken  # they are divided
    np.testing.assert_allclose(times, np.arange(11) * 0.01, atol=1e-12)
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
        ({"steps": "x"}, "every: steps = 'x': must be a whole number"),
        ({"steps": float("nan")}, "every: steps = nan: must be a whole number"),
        ({"steps": float("inf")}, "every: steps = inf: must be a whole number"),
        ({"steps": True}, "every: steps = True: must be a whole number"),
        ({"time": 0.0}, "every: time = 0: must be positive"),
        ({"time": float("nan")}, "every: time = nan: must be positive and finite"),
        ({"time": "x"}, "every: time = 'x': must be a number"),
        ({"time": True}, "every: time = True: must be a number"),
        ({"time": np.array([1, 2])}, r"every: time = array\(\[1, 2\]\): must be one number"),
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


@pytest.mark.parametrize(
    ("hooks", "said"),
    [
        (5, "hooks = 5: must be a list of pairs"),
        (None, "hooks = None: must be a list of pairs"),
        ([every(steps=1)], r"hooks\[0\] = Every.*: must be a pair of a cadence"),
        ((every(time=1.0), print), r"hooks\[0\] = Every.*: must be a pair of a cadence"),
        ([(every(steps=1), print), print], r"hooks\[1\] = <built-in function print>: must be a pair"),
        ([(0.1, print)], r"hooks\[0\]: cadence = 0.1: must be every"),
        ([("steps", print)], r"hooks\[0\]: cadence = 'steps': must be every"),
        ([(every(steps=1), None)], r"hooks\[0\]: function = None: must be a function of the simulation"),
        ([(every(steps=1), lambda: 0)], r"hooks\[0\]: function: must be a function of the simulation: too many"),
    ],
)
def test_bad_hooks_are_refused_before_anything_is_made(tmp_path, hooks, said):
    with pytest.raises(SceneError, match=said):
        simulate(Scene(swimmers=[CELL], time=TIME), tmp_path / "run", device="cpu", hooks=hooks)
    assert not (tmp_path / "run").exists()


def test_a_bad_hook_cannot_be_attached():
    with pytest.raises(SceneError, match="attach: function = 5: must be a function of the simulation"):
        free().attach(every(steps=1), 5)


def test_the_first_reason_to_stop_is_kept():
    """And the hook that stopped the run is not called again, while the others are."""
    simulation, calls, others = free(), [], []

    def enough(simulation):
        calls.append(simulation.now)
        if simulation.now > 0.0205:
            simulation.stop(f"at {simulation.now:.3f}")

    def other(simulation):
        others.append(simulation.steps_taken)
        if simulation.now > 0.0205:
            simulation.stop("too late")

    simulation.attach(every(steps=1), enough)
    simulation.attach(every(steps=10), other)
    run(simulation)
    assert simulation.stopped == "at 0.021" and len(calls) == 22
    assert others == [0, 10, 20, 30, 40]
    assert simulation.time == pytest.approx(0.04)


@pytest.mark.parametrize("reason", [None, 5, True])
def test_a_reason_to_stop_is_text(reason):
    simulation = free()
    with pytest.raises(SceneError, match=f"reason = {reason}: must be text"):
        simulation.stop(reason)
    assert simulation.stopped is None


def test_a_force_cannot_be_set_where_contact_gives_it():
    simulation = crossed()
    with pytest.raises(SceneError, match=r"force: it cannot be set, because contact .* gives it at every step"):
        simulation.ensembles["cell"].force = [0, 0, 1.0]
    slab = Scene(swimmers=[CELL], time=TIME, box={"kind": "slab", "size": [6, 6], "height": 3.0})
    with pytest.raises(SceneError, match="force: it cannot be set"):
        Simulation(slab, "cpu").ensembles["cell"].force = [0, 0, 1.0]


def test_a_state_that_does_not_fit_leaves_a_simulation_as_it_was():
    simulation, other = free(), Simulation(Scene(swimmers=[{**CELL, "count": 3}], time=TIME), "cpu")
    before = simulation.state()
    for wrong in (other.state(), {}, {name: array for name, array in before.items() if name != "frame"}):
        with pytest.raises(SceneError, match=r"cell: state|state\['frame'\]"):
            simulation.restore(wrong)
        for name, values in simulation.state().items():
            np.testing.assert_array_equal(values, before[name])
    with pytest.raises(SceneError, match=r"scene = 'x\.toml': must be a Scene"):
        Simulation("x.toml")

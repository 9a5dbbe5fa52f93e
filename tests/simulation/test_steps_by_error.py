"""Runs without ``time.step``: resumed to the same bits, with frames and hooks at odd times, of every kind of scene."""

import numpy as np
import pytest

import warp_rods as wr
from warp_rods.errors import RunFolderError
from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner, saver
from warp_rods.simulation.loop import Simulation

CELL = {"name": "c", "count": 3, "nodes": 33, "bend": [5e-3, 2e-3, 1e-3], "twist": 1e-3}
PLACED = {"placement": {"position": [[0, 0, 0], [0, 0.05, 0.01], [0.3, 0.02, 0.06]]}, "shape": {"kind": "straight"}}
FILAMENT = {
    "name": "f", "count": 3, "nodes": 17, "length": 0.5, "stiffness": [1, 1.2, 0.8], "intrinsic": [0.3, 1.2, 0.2],
    "drag": [1, 2, 0.1],
}  # fmt: skip
GROWTH = {"rate": 1.0, "until": 0.58, "spacing": 0.5 / 16 + 1e-3}
STERIC = {"strength": 0.1, "range": 0.03, "core": 0.05}
REST = {"kind": "sphere", "radius": 1.0}
MOVING = {"kind": "torus", "major": "1 + 0.2*sin(20*t)", "minor": 0.4}
SCENES = {
    "swimmers in steps of their own": {"swimmers": [CELL]},
    "filaments in steps of their own": {"surface": REST, "filaments": [FILAMENT]},
    "contact of both": {
        "surface": REST, "filaments": [FILAMENT], "swimmers": [CELL | PLACED], "steric": STERIC,
    },
    "walls": {"swimmers": [CELL], "box": {"kind": "slab", "size": [6, 6], "height": 1.2}},
    "growth with refinement": {"surface": REST, "filaments": [FILAMENT | {"growth": GROWTH}]},
    "a moving membrane": {"surface": MOVING, "filaments": [FILAMENT]},
    "all that, and swimmers": {
        "surface": MOVING, "filaments": [FILAMENT | {"growth": GROWTH}], "steric": STERIC, "swimmers": [CELL | PLACED],
    },
}  # fmt: skip
OWN = {"swimmers in steps of their own", "filaments in steps of their own"}


def scene(name: str, end: float = 0.1, **time: float) -> Scene:
    return Scene.parse({"seed": 4, **SCENES[name], "time": {"end": end, "save_every": 0.023, **time}})


def same(data, other) -> None:
    assert set(data.children) == set(other.children)
    for name, group in data.children.items():
        for label, values in group.to_dataset().items():
            np.testing.assert_array_equal(values, other[name][label], err_msg=f"{name}/{label}")


@pytest.mark.parametrize("name", SCENES)
def test_a_run_by_error_resumes_with_the_same_bits(name, tmp_path, monkeypatch, verified):
    """Stopped at a frame and resumed, with a hook at odd times in one of the two parts only."""
    monkeypatch.setattr(saver, "CHECKPOINT_EVERY", 0.0)
    seen = []

    def stop(simulation: Simulation) -> None:
        seen.append(sum(float(rods.energy.sum()) for rods in simulation.ensembles.values()))
        if simulation.now > 0.04:
            simulation.stop("enough")

    whole = runner.simulate(scene(name), tmp_path / "whole", device="cpu")
    runner.simulate(scene(name), tmp_path / "run", device="cpu", hooks=[(wr.every(time=0.0071), stop)])
    assert len(seen) == 7 and "step" not in (tmp_path / "run" / "scene.toml").read_text().split("[time]")[1]
    resumed = runner.simulate(scene(name), tmp_path / "run", device="cpu", resume=True)
    assert resumed.data.sizes == whole.data.sizes and resumed.data.attrs["step"] == "chosen by error"
    same(resumed.data, whole.data)
    saved = [
        {f"{one}/{label}": v.to_numpy() for one, group in data.children.items() for label, v in group.items()}
        for data in (resumed.data, whole.data)
    ]
    verified.same(f"run by error, stopped and resumed: {name}", *saved, reference="a run without a stop")


@pytest.mark.parametrize("name", SCENES)
def test_a_run_by_error_can_be_made_longer(name, tmp_path):
    """The bits are those of a run that was as long from the start, where the first end is one of its frames."""
    runner.simulate(scene(name, 0.046), tmp_path / "run", device="cpu")
    longer = runner.simulate(scene(name, 0.069), tmp_path / "run", device="cpu", resume=True)
    same(longer.data, runner.simulate(scene(name, 0.069), tmp_path / "whole", device="cpu").data)


def test_an_end_that_is_no_frame_of_the_longer_run_is_refused(tmp_path):
    name = "swimmers in steps of their own"
    runner.simulate(scene(name, 0.06), tmp_path / "run", device="cpu")
    with pytest.raises(RunFolderError, match="not a frame of this scene"):
        runner.simulate(scene(name, 0.1), tmp_path / "run", device="cpu", resume=True)


def test_a_run_by_error_is_not_continued_with_other_steps(tmp_path):
    name = "swimmers in steps of their own"
    runner.simulate(scene(name, 0.046), tmp_path / "run", device="cpu")
    for time, said in (({"step": 1e-3}, "time.step: None in the run"), ({"tolerance": 1e-3}, "time.tolerance: None")):
        with pytest.raises(RunFolderError, match=said):
            runner.simulate(scene(name, 0.069, **time), tmp_path / "run", device="cpu", resume=True)


@pytest.mark.parametrize("name", SCENES)
def test_steps_by_error_end_where_short_steps_do(name):
    chosen, fixed = (Simulation(scene(name, 0.1, **time), "cpu") for time in ({}, {"step": 1e-4}))
    assert chosen.own_steps == (name in OWN)
    for simulation in (chosen, fixed):
        for _ in simulation.advance():
            pass
    for group, rods in chosen.ensembles.items():
        assert rods.nodes == fixed.ensembles[group].nodes and not rods.failures()
        assert (rods.nodes == 33) == (group == "c" or "growth" in str(SCENES[name]))
        np.testing.assert_allclose(rods.position, fixed.ensembles[group].position, atol=2e-3)
        assert rods.energy == pytest.approx(
            fixed.ensembles[group].energy, rel=0.02, abs=1e-6
        )  # quadratic in the strains
    assert chosen.steps_taken < fixed.steps_taken / 2
    assert not chosen.new_warnings() and not fixed.new_warnings()


@pytest.mark.parametrize("name", SCENES)
def test_hooks_of_a_run_by_error(name):
    """``time``: at its times, also several within a step; ``steps``: after that many, or where a run stops."""
    simulation, times, steps = Simulation(scene(name), "cpu"), [], []
    simulation.attach(wr.every(time=0.0007), lambda s: times.append(s.now))
    simulation.attach(wr.every(steps=10), lambda s: steps.append(s.steps_taken))
    for _ in simulation.advance():
        pass
    np.testing.assert_allclose(times, 0.0007 * np.arange(143), atol=1e-12)
    assert (np.diff(np.array(steps) // 10) >= 1).all() and steps[0] == 0
    assert len(steps) == simulation.steps_taken // 10 + 1 if name not in OWN else len(steps) > 2


@pytest.mark.parametrize("name", ["walls", "filaments in steps of their own"])
def test_what_a_hook_reads_is_the_state_at_its_time(name):
    """Between the ends of steps: as a frame saved at that time has it."""
    read, frames = {}, Simulation(scene(name, 0.1, save_every=0.02), "cpu")
    watched = Simulation(scene(name, 0.1, save_every=0.1), "cpu")
    watched.attach(wr.every(time=0.02), lambda s: read.update({s.frame or round(s.now, 9): state(s)}))
    for _ in watched.advance():
        pass
    while not frames.finished:
        for _ in frames.to_next_frame():
            pass
        np.testing.assert_array_equal(state(frames), read[round(frames.now, 9) if not frames.finished else 1])


def state(simulation: Simulation) -> np.ndarray:
    (rods,) = simulation.ensembles.values()
    return np.concatenate([rods.position, rods.strain], axis=1)

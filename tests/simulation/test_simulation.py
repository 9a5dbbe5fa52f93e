"""From a scene to a trajectory: determinism, restart, frames, interaction, refused scenes."""

import numpy as np
import pytest

from warp_rods import workflow
from warp_rods.errors import RodFailure, RunFolderError, SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner, saver
from warp_rods.simulation.loop import Frames, Simulation
from warp_rods.simulation.reading import open_run
from warp_rods.simulation.run_folder import RunFolder

SCENE = {
    "title": "two kinds of sensors",
    "seed": 3,
    "surface": {"kind": "cassini", "a": 1.0, "b": 1.1},
    "filaments": [
        {"name": "convex", "count": 4, "nodes": 17, "length": 0.5, "stiffness": [1, 1, 1],
         "intrinsic": [0, 1.5, 0], "drag": [1, 2, 0.1]},
        {"name": "saddle", "count": 3, "nodes": 21, "length": [0.3, 0.4, 0.5], "stiffness": [1, 1, 1],
         "intrinsic": [0, -1.2, 0], "drag": [1, 2, 0.1]},
    ],
    "steric": {"strength": 1e-3, "range": 0.02, "core": 0.03},
    "time": {"end": 0.05, "save_every": 0.01, "step": 5e-4},
}  # fmt: skip


def scene(**changes) -> Scene:
    return Scene.parse({**SCENE, **changes})


def positions(simulation: Simulation) -> list[np.ndarray]:
    return [values["position"] for values in simulation.variables().values()]


def finish(simulation: Simulation) -> Simulation:
    while simulation.frame < len(simulation.frames.times) - 1:
        for _ in simulation.to_next_frame():
            pass
    return simulation


def test_frames_end_where_the_scene_ends():
    frames = Frames.plan(end=1.0, every=0.3, step=0.07)
    np.testing.assert_allclose(frames.times, [0, 0.3, 0.6, 0.9, 1.0])
    assert frames.steps.tolist() == [0, 5, 5, 5, 2]
    assert Frames.plan(end=1.0, every=0.1, step=0.1).steps.tolist() == [0] + [1] * 10


def test_the_same_scene_gives_the_same_bits(device, verified):
    first, second = (finish(Simulation(scene(), device)) for _ in range(2))
    found = [{str(k): values for k, values in enumerate(positions(s))} for s in (first, second)]
    verified.same("the same scene twice: places", *found, reference="the first time")


def test_another_seed_gives_another_start():
    a, b = Simulation(scene()), Simulation(scene(seed=4))
    assert np.abs(positions(a)[0] - positions(b)[0]).max() > 0.1


def test_warming_up_changes_nothing():
    cold, warm = Simulation(scene()), Simulation(scene())
    warm.warm_up()
    for a, b in zip(positions(finish(cold)), positions(finish(warm)), strict=True):
        assert a.tobytes() == b.tobytes()


def test_ensembles_interact_and_lose_energy():
    simulation = Simulation(scene(steric={"strength": 1e-2, "range": 0.3, "core": 0.1}))
    assert all((v["steric_energy"] > 0).all() for v in simulation.variables().values())
    totals = []
    while simulation.frame < 5:
        values = simulation.variables().values()
        totals.append(sum((v["energy"] + v["steric_energy"]).sum() for v in values))
        for _ in simulation.to_next_frame():
            pass
    assert (np.diff(totals) < 0).all()


def test_the_folder_of_a_run_can_be_read(tmp_path):
    run = workflow.run(scene(), tmp_path / "run", device="cpu")
    assert {p.name for p in run.folder.iterdir()} == {
        "scene.toml", "trajectory.zarr", "checkpoint.npz", "animation.usdc", ".lock"
    }  # fmt: skip
    data = run.data
    assert set(data.children) == {"convex", "saddle"}
    convex = data["convex"].to_dataset()
    named = {"axis": 3, "strain_component": 3, "quaternion": 4, "end": 2}
    assert dict(convex.sizes) == {"frame": 6, "rod": 4, "node": 17, **named}
    assert {"position", "strain", "orientation", "tension", "energy", "dissipation", "status", "gauss", "load"} <= set(
        convex
    )
    np.testing.assert_allclose(convex.time, [0, 0.01, 0.02, 0.03, 0.04, 0.05])
    np.testing.assert_array_equal(data["saddle"]["length"][0], [0.3, 0.4, 0.5])
    assert Scene.load(run.folder / "scene.toml") == scene()
    assert data.attrs["scene_hash"] == scene().hash()


def test_an_interrupted_run_resumes_with_the_same_bits(tmp_path, monkeypatch, verified):
    whole = runner.simulate(scene(), tmp_path / "whole", device="cpu").data
    monkeypatch.setattr(saver, "CHECKPOINT_EVERY", 0.0)
    stopped = tmp_path / "stopped"

    real, calls = Simulation.to_next_frame, []

    def interrupted(self):
        calls.append(self.frame)
        if len(calls) == 4:
            raise KeyboardInterrupt
        return real(self)

    with monkeypatch.context() as m:
        m.setattr(Simulation, "to_next_frame", interrupted)
        with pytest.raises(KeyboardInterrupt):
            runner.simulate(scene(), stopped, device="cpu")
    assert open_run(stopped)["convex"].sizes["frame"] == 4
    again = runner.simulate(scene(), stopped, device="cpu", resume=True).data
    keys = [(group, name) for group in ("convex", "saddle") for name in ("position", "time")]
    found = [{"/".join(key): data[key[0]][key[1]].to_numpy() for key in keys} for data in (again, whole)]
    verified.same("run in equal steps, interrupted and resumed", *found, reference="a run without a stop")


def test_a_folder_with_a_run_is_refused_or_replaced(tmp_path):
    runner.simulate(scene(), tmp_path, device="cpu")
    with pytest.raises(RunFolderError, match="--overwrite"):
        runner.simulate(scene(), tmp_path, device="cpu")
    shorter = scene(time={"end": 0.02, "save_every": 0.01, "step": 5e-4})
    with pytest.raises(RunFolderError, match=r"beyond time\.end = 0\.02"):
        runner.simulate(shorter, tmp_path, device="cpu", resume=True)
    with pytest.raises(RunFolderError, match="differs from the scene given in seed"):
        runner.simulate(scene(seed=9), tmp_path, device="cpu", resume=True)
    longer = scene(time={**SCENE["time"], "end": 0.07})
    assert runner.simulate(longer, tmp_path, device="cpu", resume=True).data["convex"].sizes["frame"] == 8
    assert runner.simulate(shorter, tmp_path, device="cpu", overwrite=True).data["convex"].sizes["frame"] == 3


@pytest.mark.parametrize("time", [{"step": 4e-3, "save_every": 0.1}, {"save_every": 0.1}, {}], ids=str)
def test_a_finished_run_can_be_made_longer(time, tmp_path):
    """With a given or a chosen step: the bits are those of a run that was as long from the start."""

    def run(end, folder, **kind):
        return runner.simulate(
            Scene(swimmers=[CELL], time={"end": end, **time}), tmp_path / folder, device="cpu", **kind
        )

    run(0.3, "run")
    longer = run(0.6, "run", resume=True).data
    begun = Scene.load(tmp_path / "run" / "scene.toml").time
    assert Scene.parse(longer.attrs["scene"]).time.end == begun.end == 0.6
    time = {"step": begun.step, "save_every": begun.save_every}
    whole = run(0.6, "whole").data["cells"]
    for name in ("time", "position", "activity"):
        np.testing.assert_array_equal(longer["cells"][name], whole[name])


def test_nothing_is_written_for_an_impossible_scene(tmp_path):
    long = {**SCENE["filaments"][0], "length": 20.0}
    with pytest.raises(SceneError, match=r"filaments\[0\]\.length = 20"):
        runner.simulate(scene(filaments=[long]), tmp_path / "none", device="cpu")
    dense = {**SCENE["filaments"][0], "count": 40}
    with pytest.raises(SceneError, match=r"filaments\[0\]\.count = 40: .* at most \d+ could fit"):
        runner.simulate(scene(filaments=[dense], steric={"strength": 1, "range": 1, "core": 0.5}), tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_a_step_that_is_too_long_is_told_in_the_run():
    table = SCENE["filaments"][0] | {"nodes": "auto"}
    given = scene(filaments=[table], steric=None, time={"end": 2.7, "step": 0.9, "save_every": 0.9})
    simulation = Simulation(given)
    assert not simulation.warnings
    finish(simulation), simulation.variables()
    (line,) = simulation.new_warnings()
    assert line.startswith("convex: by t = 2.7 a step of rod") and "leave time.step out" in line


def test_steps_that_are_not_given_are_chosen_by_their_error():
    simulation = Simulation(scene(time={"end": 0.05}))
    assert simulation.by_error and not simulation.own_steps  # they feel each other
    assert "chosen by their error for all rods together" in simulation.pace
    finish(simulation), simulation.variables()
    assert not simulation.new_warnings() and simulation.scene.time.step is None
    fixed = finish(Simulation(scene(time={"end": 0.05, "step": 2e-5})))
    assert simulation.steps_taken < fixed.steps_taken / 8
    for found, exact in zip(positions(simulation), positions(fixed), strict=True):
        np.testing.assert_allclose(found, exact, atol=2e-3)


def test_frozen_rods_are_named_and_a_run_stops_when_all_are_frozen(tmp_path):
    simulation = Simulation(scene())
    convex, saddle = simulation.ensembles.values()
    convex._f.intrinsic.fill_(float("nan"))
    for _ in simulation.to_next_frame():
        pass
    lines = simulation.new_failures()
    assert len(lines) == 4 and "convex: rod 0 became non-finite at t = 0" in lines[0] and "length" in lines[0]
    assert not simulation.new_failures()
    saddle._f.intrinsic.fill_(float("nan"))
    for _ in simulation.to_next_frame():
        pass
    with pytest.raises(RodFailure, match=r"No rod is left: try time\.step below 0\.0005"):
        simulation.new_failures()


def test_swimmers_start_where_they_are_placed_and_swim(tmp_path):
    cells = {
        "name": "cells", "count": 2, "nodes": 65, "bend": [5e-3, 1e-3], "twist": 1e-3, "symmetric": True,
        "shape": {"kind": "mode", "amplitude": 3.0},
        "placement": {"position": [[1, 2, 3], [4, 5, 6]], "direction": [[0, 0, 2], [1, 0, 0]]},
    }  # fmt: skip
    tables = {"swimmers": [cells], "time": {"end": 0.2, "step": 1e-3, "save_every": 0.1}}
    data = runner.simulate(Scene.parse(tables), tmp_path / "run", device="cpu").data["cells"].to_dataset()
    np.testing.assert_allclose(data.position[0, :, 32], [[1, 2, 3], [4, 5, 6]], atol=1e-14)
    chord = (data.position[0, :, 33] - data.position[0, :, 31]).to_numpy()
    np.testing.assert_allclose(chord * 32, [[0, 0, 1], [1, 0, 0]], atol=2e-3)
    assert {"activity", "power", "energy_density", "dissipation"} <= set(data)
    assert (np.linalg.norm(data.position[-1, :, 32] - data.position[0, :, 32], axis=-1) > 0.01).all()


CELL = {"name": "cells", "count": 3, "nodes": 33, "bend": 5e-3, "twist": 1e-3}
STERIC = {"strength": 1e-3, "range": 0.03, "core": 0.05}


def test_swimmers_and_filaments_interact(tmp_path):
    """Three close swimmers side by side repel each other, and a filament beside them."""
    placed = {"placement": {"position": [[0, 0, 0], [0, 0.04, 0], [0, 0.08, 0]]}, "shape": {"kind": "straight"}}
    plane = {"kind": "plane"}
    filament = {**SCENE["filaments"][0], "count": 1, "intrinsic": [0, 0, 0]}
    placed_filament = {"placement": {"position": [[0, -0.04, 0]], "direction": [[1, 0, 0]]}}
    time = {"end": 0.1, "step": 1e-3, "save_every": 0.05}
    tables = {"surface": plane, "swimmers": [{**CELL, **placed}], "filaments": [{**filament, **placed_filament}]}
    data = runner.simulate(Scene.parse({**tables, "steric": STERIC, "time": time}), tmp_path / "run", device="cpu").data
    middles = data["cells"]["position"][:, :, 16, 1].to_numpy()
    assert (np.diff(middles[-1]) > np.diff(middles[0])).all()
    assert float(data["convex"]["position"][-1, 0, 8, 1]) < -0.04
    assert (data["cells"]["steric_energy"] > 0).all()


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"swimmers": [{**CELL, "symmetric": True}], "steric": STERIC}, "symmetric = true"),
        ({"swimmers": [{**CELL, "symmetric": True, "shape": {"kind": "mode", "mode": 1}}]}, "lacks the symmetry"),
        ({"swimmers": [{**CELL, "symmetric": True, "flagella": {"profile": "uniform"}}]}, "the flagella at the start"),
        (
            {
                "surface": SCENE["surface"],
                "filaments": [{**SCENE["filaments"][0], "growth": {"rate": 1.0, "until": 1.0, "spacing": 0.01}}],
            },
            r"growth\.spacing = 0\.01",
        ),
    ],
)
def test_incompatible_settings_are_reported_before_anything_is_written(tmp_path, tables, said):
    with pytest.raises(SceneError, match=said):
        runner.simulate(Scene.parse({**tables, "time": {"end": 0.1, "step": 1e-3}}), tmp_path / "none", device="cpu")
    assert not (tmp_path / "none").exists()


def test_a_filament_that_is_refined_in_the_first_step_runs(tmp_path):
    growing = {**SCENE["filaments"][0], "growth": {"rate": 1.0, "until": 1.0, "spacing": 0.5 / 16 + 1e-6}}
    tables = {"surface": SCENE["surface"], "filaments": [growing], "time": {"end": 0.01, "step": 5e-4}}
    assert runner.simulate(Scene.parse(tables), tmp_path / "run", device="cpu").data["convex"].sizes["node"] == 17


def test_a_folder_that_a_run_writes_to_is_refused(tmp_path):
    runner.simulate(scene(), tmp_path, device="cpu")
    kept, _state = RunFolder.resume(tmp_path, Scene.load(tmp_path / "scene.toml"), {})
    with kept, pytest.raises(RunFolderError, match="another run is writing to"):
        runner.simulate(scene(), tmp_path, device="cpu", overwrite=True)
    runner.simulate(scene(), tmp_path, device="cpu", overwrite=True)

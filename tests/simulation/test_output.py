"""The table [output]: variables that are saved, frames in a file; and an animation that fails does not lose a run."""

import logging

import numpy as np
import pytest

import warp_rods as wr
from warp_rods import workflow
from warp_rods.analysis.summary import summary
from warp_rods.draw.selection import Selection
from warp_rods.errors import RunFolderError, SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.check import check_run
from warp_rods.simulation.reading import open_run

FILAMENT = {"name": "f", "count": 9, "nodes": 9, "length": 0.3, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
CELL = {"name": "c", "count": 2, "nodes": 17, "bend": 5e-3, "twist": 1e-3}
TABLES = {
    "surface": {"kind": "sphere", "radius": 1.0}, "filaments": [FILAMENT], "swimmers": [CELL],
    "time": {"end": 0.05, "step": 1e-3, "save_every": 0.01},
}  # fmt: skip


def scene(**output) -> Scene:
    return Scene.parse({**TABLES, "output": output})


def test_only_the_chosen_variables_are_saved(tmp_path):
    """Those of all ensembles that have them, with the values of a run that saves all."""
    everything = wr.run(Scene.parse(TABLES), tmp_path / "all", device="cpu").data
    run = wr.run(scene(usd=False, variables=["energy", "gauss"]), tmp_path / "some", device="cpu")
    assert not (run.folder / "animation.usdc").exists()
    always = {"position", "status"}
    static = {name for name, v in everything["f"].data_vars.items() if "frame" not in v.dims}
    assert set(run.data["f"].data_vars) == always | {"energy", "gauss"} | static
    assert "gauss" not in run.data["c"] and "energy" in run.data["c"] and "tension" not in run.data["c"]
    for name in ("position", "energy", "gauss", "time"):
        np.testing.assert_array_equal(run.data["f"][name], everything["f"][name])
    assert summary(run.data, run.order).row_count == 2
    assert "no damage" in check_run(run.folder)
    with pytest.raises(RunFolderError, match=r"no energy_density.*output\.variables"):
        wr.export_usd(run.folder, selection=Selection(colour="energy_density"))
    assert wr.export_usd(run.folder).is_file()  # in another colour


def test_a_run_without_energies_has_a_summary(tmp_path):
    run = wr.run(scene(variables=[]), tmp_path / "run", device="cpu")
    assert (run.folder / "animation.usdc").is_file()
    assert set(run.data["c"].data_vars) & {"position", "status", "energy"} == {"position", "status"}
    assert summary(run.data, run.order).row_count == 2


@pytest.mark.parametrize(("frames", "files"), [(1, 6), (4, 2), (100, 1)])
def test_frames_in_a_file(tmp_path, frames, files):
    run = wr.run(scene(usd=False, frames_per_file=frames), tmp_path / "run", device="cpu")
    for name in ("position", "energy", "time"):
        assert len(list((run.folder / "trajectory.zarr" / "f" / name).glob("c.*"))) == files
    assert open_run(run.folder)["f"].sizes["frame"] == 6
    assert "no damage" in check_run(run.folder)
    longer = {**TABLES, "time": {**TABLES["time"], "end": 0.09}, "output": {"usd": True, "frames_per_file": frames}}
    longer = wr.run(Scene.parse(longer), run.folder, device="cpu", resume=True)
    assert longer.data["f"].sizes["frame"] == 10 and (run.folder / "animation.usdc").exists()
    assert "no damage" in check_run(run.folder)


def test_a_scene_without_the_table_has_the_identity_that_it_had():
    assert "output" not in Scene.parse(TABLES).to_toml()
    assert Scene.parse(TABLES).hash() == "8f700cc53497a6ce95af8579d6d3a06b1922ca2a9fb3ec2e5679f0c492a45df1"


@pytest.mark.parametrize(
    ("output", "said"),
    [
        ({"usdd": True}, r"output\.usdd: unknown key \(did you mean usd\?\)"),
        ({"usd": "no"}, r'output\.usd = "no": must be true or false'),
        ({"frames_per_file": 0}, r"output\.frames_per_file = 0: must be a whole number, 1 or more"),
        ({"variables": "energy"}, r"output\.variables = .*: must be a list of names"),
    ],
)
def test_faults_of_the_table(output, said):
    with pytest.raises(SceneError, match=said):
        scene(**output)


def test_unknown_variables_are_named_with_the_nearest_ones(tmp_path):
    given = scene(variables=["positon", "energy", "tensoin"])
    with pytest.raises(SceneError) as caught:
        wr.run(given, tmp_path / "none", device="cpu")
    said = str(caught.value)
    assert 'output.variables[0] = "positon"' in said and "did you mean position?" in said
    assert 'output.variables[2] = "tensoin"' in said and "did you mean tension?" in said
    assert not (tmp_path / "none").exists()


def test_a_large_animation_is_made_in_parts(tmp_path, monkeypatch):
    """USD holds a whole file in memory; what the run had before, when it was shorter, is not left beside it."""
    run = wr.run(Scene.parse(TABLES), tmp_path / "run", device="cpu")
    assert (run.folder / "animation.usdc").is_file()
    monkeypatch.setattr(workflow, "WHOLE_ANIMATION", 1e5)
    longer = {**TABLES, "time": {**TABLES["time"], "end": 0.06}}
    run = wr.run(Scene.parse(longer), run.folder, device="cpu", resume=True)
    made = run.folder / "animation_clips" / "animation.usdc"
    assert made.is_file() and not (run.folder / "animation.usdc").exists()
    said = next(line for line in run.messages if line.startswith("animation: "))
    assert str(made) in said and "in parts, as it is above" in said


def test_an_animation_that_fails_does_not_lose_the_run(tmp_path, monkeypatch, caplog):
    def broken(_folder):
        raise OSError("no space left")

    caplog.set_level(logging.WARNING, "warp_rods")
    with monkeypatch.context() as m:
        m.setattr(workflow, "export_usd", broken)
        run = wr.run(Scene.parse(TABLES), tmp_path / "run", device="cpu")
    assert "no space left" in run.messages[-1] and f"warp-rods export {run.folder} --usd" in run.messages[-1]
    assert run.data["f"].sizes["frame"] == 6 and "no damage" in check_run(run.folder)
    assert wr.export_usd(run.folder).is_file()

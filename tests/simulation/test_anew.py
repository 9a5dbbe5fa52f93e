"""``resume`` where there is nothing to continue from: it starts anew, never at the cost of something that is there."""

import shutil
from pathlib import Path

import numpy as np
import pytest
import trimesh

from warp_rods.errors import RunFolderError
from warp_rods.scene.scene import Scene
from warp_rods.simulation import checkpoint, runner
from warp_rods.simulation.check import check_run
from warp_rods.simulation.reading import open_run
from warp_rods.simulation.run_folder import RunFolder

FILAMENT = {"name": "f", "count": 2, "nodes": 17, "length": 0.7, "stiffness": [1.0, 1.2, 0.8],
            "intrinsic": [0.3, 1.2, 0.0], "drag": [1.0, 2.0, 0.1]}  # fmt: skip
CELL = {"name": "f", "count": 2, "nodes": 33, "bend": 5e-3, "twist": 1e-3}
TIME = {"end": 0.02, "step": 1e-3, "save_every": 0.01}
ANEW = "nothing to continue from"


def scene(**changes) -> Scene:
    return Scene.parse({"swimmers": [CELL], "time": TIME, "seed": 5, **changes})


def on_ball(folder: Path) -> Scene:
    surface = {"kind": "grid", "file": folder / "ball.ply", "spacing": 0.2}
    return Scene.parse({"surface": surface, "filaments": [FILAMENT], "time": TIME})


def contents(folder: Path) -> dict[str, bytes]:
    files = {str(f.relative_to(folder)): f for f in sorted(folder.rglob("*")) if f.is_file() and f.name != ".lock"}
    return {name: file.read_bytes() for name, file in files.items()}


@pytest.fixture(scope="module")
def top(tmp_path_factory) -> Path:
    """A whole run, and what is there of it without a frame, and with one before the first checkpoint."""
    folder = tmp_path_factory.mktemp("anew")
    runner.simulate(scene(), folder / "whole", device="cpu")

    for name, method in (("no frame", "append"), ("one frame", "checkpoint")):
        killed(scene(), folder / name, method)
        assert len(open_run(folder / name)["f"].time) == (name == "one frame")
    return folder


class Killed(BaseException):
    pass


def killed(given: Scene, folder: Path, method: str) -> None:
    """A run that ended when it was about to save its first frame, or its first checkpoint."""

    def kill(*_arguments) -> None:
        raise Killed

    with pytest.MonkeyPatch.context() as patched, pytest.raises(Killed):
        patched.setattr(RunFolder, method, kill)
        runner.simulate(given, folder, device="cpu")


def absent(folder: Path, top: Path) -> None:
    pass


def empty(folder: Path, top: Path) -> None:
    (folder / "logs of the job").mkdir(parents=True)


def without_store(folder: Path, top: Path) -> None:
    shutil.copytree(top / "no frame", folder)
    (folder / "trajectory.zarr").rename(folder / ".trajectory.zarr.new")
    (folder / ".scene.toml.partial").write_text("a half")


def being_replaced(folder: Path, top: Path) -> None:
    shutil.copytree(top / "whole", folder)
    (folder / "trajectory.zarr").rename(folder / ".trajectory.zarr.old")


def without_a_frame(folder: Path, top: Path) -> None:
    shutil.copytree(top / "no frame", folder)


def with_one_frame(folder: Path, top: Path) -> None:
    shutil.copytree(top / "one frame", folder)
    (folder / ".checkpoint.npz.partial").write_bytes(b"a half")


@pytest.mark.parametrize("state", [absent, empty, without_store, being_replaced, without_a_frame, with_one_frame])
def test_resume_starts_anew_before_the_first_checkpoint(top, tmp_path, state):
    """With one line that says so; with the bits, the files and the record of a run that was started without it."""
    folder = tmp_path / "run"
    state(folder, top)
    run = runner.simulate(scene(), folder, device="cpu", resume=True)
    assert ANEW in run.messages[0] and "starting anew" in run.messages[0]
    assert "no damage" in check_run(folder)
    for name, values in open_run(top / "whole")["f"].data_vars.items():
        np.testing.assert_array_equal(open_run(folder)["f"][name], values, err_msg=name)
    left = {file.name for file in folder.iterdir()} - {"logs of the job"}
    assert left == {file.name for file in (top / "whole").iterdir()}
    assert ANEW not in str(runner.simulate(scene(), folder, device="cpu", resume=True).messages)


@pytest.mark.parametrize("state", [without_a_frame, with_one_frame])
def test_another_scene_is_refused_with_its_differences(top, tmp_path, state):
    folder = tmp_path / "run"
    state(folder, top)
    before = contents(folder)
    for changes, said in (({"seed": 6}, "seed: 5 in the run, 6"), ({"title": "x"}, "title"),
                          ({"time": {"end": 0.02, "step": 5e-4, "save_every": 0.01}}, r"time\.step")):  # fmt: skip
        with pytest.raises(RunFolderError, match=said):
            runner.simulate(scene(**changes), folder, device="cpu", resume=True)
        assert contents(folder) == before
    longer = scene(time={"end": 0.03, "step": 1e-3, "save_every": 0.01})
    assert runner.simulate(longer, folder, device="cpu", resume=True).data["f"].sizes["frame"] == 4


def drop_checkpoint(folder: Path) -> None:
    (folder / "checkpoint.npz").unlink()


def damage_checkpoint(folder: Path) -> None:
    (folder / "checkpoint.npz").write_bytes((folder / "checkpoint.npz").read_bytes()[:-30])


def age_checkpoint(folder: Path) -> None:
    state = dict(np.load(folder / "checkpoint.npz"))
    np.savez(folder / "checkpoint.npz", **state | {"format": np.array(checkpoint.FORMAT - 1)})


def drop_store(folder: Path) -> None:
    shutil.rmtree(folder / "trajectory.zarr")
    drop_checkpoint(folder)


def drop_metadata(folder: Path) -> None:
    (folder / "trajectory.zarr" / "zarr.json").unlink()
    drop_checkpoint(folder)


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        (drop_checkpoint, "holds 3 frames of this scene, but checkpoint.npz"),
        (damage_checkpoint, "checkpoint.npz is damaged"),
        (age_checkpoint, "checkpoint.npz is of another version"),
        (drop_store, "holds a scene.toml that belongs to no run"),
        (drop_metadata, "zarr.json is missing"),
    ],
)
def test_what_no_kill_leaves_is_kept(top, tmp_path, harm, said):
    """Frames without their checkpoint, or a checkpoint that cannot be read, are worth keeping."""
    folder = tmp_path / "run"
    shutil.copytree(top / "whole", folder)
    harm(folder)
    before = contents(folder)
    with pytest.raises(RunFolderError, match=said):
        runner.simulate(scene(), folder, device="cpu", resume=True)
    assert contents(folder) == before


@pytest.mark.long
def test_a_run_is_started_anew_from_its_own_scene(tmp_path):
    """From the copy in the folder, on the membrane that the folder keeps; the original scene continues it, too."""
    trimesh.creation.icosphere(subdivisions=2).export(tmp_path / "ball.ply")
    folder = tmp_path / "run"
    killed(on_ball(tmp_path), folder, "checkpoint")
    membrane, position = (folder / "membrane.npz").read_bytes(), open_run(folder)["f"].position.values
    again = runner.simulate(folder / "scene.toml", folder, device="cpu", resume=True)
    assert ANEW in again.messages[0] and (folder / "membrane.npz").read_bytes() == membrane
    np.testing.assert_array_equal(again.data["f"].position[:1], position)
    assert ANEW not in str(runner.simulate(on_ball(tmp_path), folder, device="cpu", resume=True).messages)

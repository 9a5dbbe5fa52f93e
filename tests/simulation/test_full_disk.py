"""A disk that is full, a quota, a folder that becomes read-only: words, a readable store, and a run that goes on."""

import contextlib
import errno
import os
import pathlib
import subprocess
from pathlib import Path

import numpy as np
import pytest
from half_writes import Halves, opening

import warp_rods as wr
from warp_rods import workflow
from warp_rods.errors import SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation import run_folder, runner
from warp_rods.simulation.check import check_run
from warp_rods.simulation.reading import open_run
from warp_rods.simulation.storage import StorageError

CELL = {"name": "cell", "count": 3, "nodes": 33, "bend": 5e-3, "twist": 1e-3}


def scene(**output) -> Scene:
    tables = {"output": output} if output else {}
    return Scene.parse({"swimmers": [CELL], "time": {"end": 0.04, "save_every": 0.01}, **tables})


def same(one: Path, other: Path) -> None:
    assert "no damage" in check_run(one)
    for variable, values in open_run(other)["cell"].data_vars.items():
        np.testing.assert_array_equal(open_run(one)["cell"][variable], values, err_msg=str(variable))
    assert {file.name for file in one.iterdir()} <= {file.name for file in other.iterdir()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    return wr.run(scene(), tmp_path_factory.mktemp("whole") / "run", device="cpu").folder


@contextlib.contextmanager
def full_from(write: int, folder: Path, code: int, monkeypatch):
    """From the nth write to a file in the folder on, all fail."""
    writes = []

    def limited(file):
        def fail() -> None:
            raise OSError(code, os.strerror(code), file.name)

        writes.append(file.name)
        return Halves(file, fail) if len(writes) >= write else file

    with monkeypatch.context() as patched:
        patched.setattr(pathlib.Path, "open", opening(folder, limited))
        yield writes


SAID = {
    errno.ENOSPC: "No space left on the disk of .*free some space, then",
    errno.EDQUOT: "The disk quota is used up in .*larger quota, then",
    errno.EACCES: "may not be written any more .*permission to write there, then",
    errno.EROFS: "is read-only now .*make it writable again, then",
}


ALONE = [(9, "ENOSPC", 0.0), (30, "EACCES", 0.0), (44, "EROFS", 0.0), (61, "EDQUOT", 0.0), (88, "ENOSPC", 0.0)]
TOGETHER = [(30, "ENOSPC", np.inf), (43, "EDQUOT", np.inf), (50, "EROFS", np.inf)]


@pytest.mark.parametrize(("write", "code", "waits"), [*ALONE, *TOGETHER])
def test_a_run_that_cannot_write_says_so_and_goes_on_later(tmp_path, whole, monkeypatch, write, code, waits):
    """Every write fails from the nth on: in the start, in frames, in checkpoints; frames written alone or together."""
    monkeypatch.setattr(run_folder, "FRAMES_EVERY", waits)
    folder, code = tmp_path / "a run", getattr(errno, code)
    with full_from(write, folder, code, monkeypatch) as writes, pytest.raises(StorageError, match=SAID[code]) as caught:
        runner.simulate(scene(), folder, device="cpu")
    assert len(writes) >= write and caught.value.exit_code == 1 and not list(folder.glob(".*.partial"))
    if (folder / "trajectory.zarr").exists():
        position = open_run(folder)["cell"].position
        np.testing.assert_array_equal(position, open_run(whole)["cell"].position[: len(position)])
        assert f"warp-rods run '{folder}/scene.toml' --out '{folder}' --resume" in str(caught.value)
    runner.simulate(scene(), folder, device="cpu", resume=True)
    same(folder, whole)


@pytest.mark.long
@pytest.mark.parametrize(
    ("write", "waits"), [*((n, 0.0) for n in range(1, 103, 4)), *((n, np.inf) for n in range(1, 58, 4))]
)
def test_a_full_disk_at_every_fourth_write(tmp_path, whole, monkeypatch, write, waits):
    test_a_run_that_cannot_write_says_so_and_goes_on_later(tmp_path, whole, monkeypatch, write, "ENOSPC", waits)


def test_an_animation_that_does_not_fit_is_a_warning(tmp_path, whole, monkeypatch):
    """The run is complete, and no half of the file is left."""
    from warp_rods.draw.usd import export

    class Full:
        def GetRootLayer(self):
            return self

        def Export(self, path: str) -> bool:
            Path(path).write_bytes(b"half")
            Path(path).with_suffix(".abcdef").write_bytes(b"half of a writer's own")
            return False

    monkeypatch.setattr(export.Stage, "finish", lambda self: setattr(self, "stage", Full()))
    run = wr.run(scene(), tmp_path / "run", device="cpu")
    assert "warning: the run is complete, but its animation could not be made" in run.messages[-1]
    same(run.folder, whole)
    assert not (run.folder / "animation.usdc").exists()
    monkeypatch.undo()
    assert wr.export_usd(run.folder).stat().st_size > 1000


# --- real file systems -----------------------------------------------------------------------------------------------


@pytest.fixture
def disk(tmp_path):
    """A small file system of its own; mounting one needs the rights of root."""
    place = tmp_path / "disk"
    place.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", place], capture_output=True, text=True)
    if done.returncode:
        pytest.skip(f"no file system can be mounted here: {done.stderr.strip()}")
    yield place
    subprocess.run(["mount", "-o", "remount,rw", place], capture_output=True)
    subprocess.run(["umount", place], check=True)


def fill(place: Path) -> None:
    """Leave a few bytes on a file system."""
    with (place / "filler").open("wb", buffering=0) as file, contextlib.suppress(OSError):
        while file.write(b"0" * 4096):
            pass


@pytest.mark.skipif(os.name != "posix", reason="mount is a command of Unix")
@pytest.mark.parametrize("frame", [0, 2])
def test_a_disk_that_becomes_full(disk, whole, frame):
    folder = disk / "run"
    hook = (wr.every(time=0.01), lambda s: fill(disk) if s.frame == frame else None)
    with pytest.raises(StorageError, match="No space left on the disk"):
        runner.simulate(scene(), folder, device="cpu", hooks=[hook])
    position = open_run(folder)["cell"].position
    assert len(position) <= frame + 1
    np.testing.assert_array_equal(position, open_run(whole)["cell"].position[: len(position)])
    (disk / "filler").unlink()
    runner.simulate(scene(), folder, device="cpu", resume=True)
    same(folder, whole)


@pytest.mark.skipif(os.name != "posix", reason="mount is a command of Unix")
def test_a_disk_that_is_full_from_the_start_and_then_for_the_animation(disk, whole, monkeypatch, caplog):
    folder, export, opened = disk / "run", workflow.export_usd, runner.opened
    fill(disk)
    with pytest.raises(SceneError, match=r"5 frames need about .* are free: none fits"):
        runner.simulate(scene(), folder, device="cpu")
    (disk / "filler").unlink()

    def late(*arguments):
        """The space was there when it was looked at, and is used by others since."""
        fill(disk)
        return opened(*arguments)

    with monkeypatch.context() as m:
        m.setattr(runner, "opened", late)
        with pytest.raises(StorageError, match=r"No space left .*then run the same command again, with --resume"):
            runner.simulate(scene(), folder, device="cpu")
    (disk / "filler").unlink()

    def full(path: Path) -> Path:
        fill(disk)
        return export(path)

    monkeypatch.setattr(workflow, "export_usd", full)
    run = wr.run(scene(), folder, device="cpu", resume=True)
    assert "warning: the run is complete, but its animation could not be made" in run.messages[-1]
    assert not [file for file in folder.iterdir() if "animation" in file.name]
    assert "messages of the run are not in its trajectory: No space left on the disk" in caplog.text
    same(folder, whole)

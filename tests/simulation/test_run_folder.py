"""The run folder: it stands by itself, is never half-written, and a refusal changes nothing in it."""

import contextlib
import shutil
import tarfile
from pathlib import Path

import numpy as np
import pytest
import trimesh

import warp_rods as wr
from warp_rods.analysis.membrane import membrane_of
from warp_rods.errors import RunFolderError, SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation import run_folder, runner
from warp_rods.simulation.check import check_run
from warp_rods.simulation.document import Document
from warp_rods.simulation.reading import open_run
from warp_rods.simulation.run_folder import RunFolder
from warp_rods.simulation.trajectory import TrajectoryWriter

HERE = Path(__file__).parent
FILAMENT = {"name": "f", "count": 2, "nodes": 17, "length": 0.7, "stiffness": [1.0, 1.2, 0.8],
            "intrinsic": [0.3, 1.2, 0.0], "drag": [1.0, 2.0, 0.1]}  # fmt: skip
CELL = {"name": "c", "count": 2, "nodes": 17, "bend": 5e-3, "twist": 1e-3}
TIME = {"end": 0.03, "step": 1e-3, "save_every": 0.01}
SPHERE = {"kind": "sphere", "radius": 1.0}


def scene(surface=SPHERE, **changes) -> Scene:
    return Scene.parse({"surface": surface, "filaments": [FILAMENT], "time": TIME, "seed": 5, **changes})


def contents(folder: Path) -> dict[str, bytes]:
    return {str(f.relative_to(folder)): f.read_bytes() for f in sorted(folder.rglob("*")) if f.is_file()}


def ellipsoid(path: Path, *radii: float) -> Path:
    mesh = trimesh.creation.icosphere(subdivisions=3)
    mesh.vertices *= radii
    mesh.export(path)
    return path


def on_mesh(file: Path, container: Path | None = None, end: float = 0.03) -> Scene:
    boxed = {"box": {"kind": "container", "surface": {"kind": "grid", "file": container, "spacing": 0.2}}}
    swimmers = {"swimmers": [CELL]} if container else {}
    surface = {"kind": "grid", "file": file, "spacing": 0.1}
    return scene(surface, time={**TIME, "end": end}, **(swimmers | boxed if container else {}))


# --- a run stands by itself ------------------------------------------------------------------------------------------


def test_a_moved_run_is_opened_exported_measured_and_resumed_on_its_membrane(tmp_path):
    """The folder alone, elsewhere; the bits are those of a run that was not moved."""
    source = tmp_path / "source"
    source.mkdir()
    given = {
        end: on_mesh(ellipsoid(source / "cell.ply", 1.2, 1.0, 0.8), ellipsoid(source / "box.ply", 3, 3, 3), end)
        for end in (0.03, 0.05)
    }
    whole = runner.simulate(given[0.05], tmp_path / "whole", device="cpu").data
    runner.simulate(given[0.03], source / "run", device="cpu")
    moved = tmp_path / "elsewhere" / "moved"
    moved.parent.mkdir()
    shutil.move(source / "run", moved)
    shutil.rmtree(source)
    assert "no damage" in check_run(moved)
    assert wr.export_usd(moved).is_file()
    data = open_run(moved)
    measured = wr.measure(data["f"].to_dataset(), "enrichment")
    np.testing.assert_allclose(measured.enrichment[:, 0], 1.0)  # all filaments are on convex membrane, as all of it is
    points = np.random.default_rng(1).uniform(-1, 1, (20, 3))
    np.testing.assert_array_equal(membrane_of(data).phi(points), membrane_of(whole).phi(points))
    text = (moved / "scene.toml").read_text().replace("end = 0.03", "end = 0.05")
    (tmp_path / "elsewhere" / "moved" / "longer.toml").write_text(text)
    again = runner.simulate(moved / "longer.toml", moved, device="cpu", resume=True).data
    for group in ("f", "c"):
        for name in ("position", "strain", "energy"):
            np.testing.assert_array_equal(again[group][name], whole[group][name])


def test_an_edited_membrane_is_refused_with_both_hashes_and_what_to_do(tmp_path):
    given = on_mesh(ellipsoid(tmp_path / "cell.ply", 1.2, 1.0, 0.8))
    runner.simulate(given, tmp_path / "run", device="cpu")
    before = contents(tmp_path / "run")
    longer = on_mesh(tmp_path / "cell.ply", end=0.05)
    ellipsoid(tmp_path / "cell.ply", 1.3, 1.0, 0.8)
    with pytest.raises(RunFolderError) as caught:
        runner.simulate(longer, tmp_path / "run", device="cpu", resume=True)
    said = str(caught.value)
    assert "differs from the scene given in surface.file" in said and said.count("SHA-256") == 2
    assert "membrane.npz" in said and "--resume" in said and "another --out" in said
    assert contents(tmp_path / "run") == before
    assert runner.simulate(tmp_path / "run" / "scene.toml", tmp_path / "run", device="cpu", resume=True).lost == []


def test_the_same_file_elsewhere_is_the_same_membrane(tmp_path):
    runner.simulate(on_mesh(ellipsoid(tmp_path / "cell.ply", 1.2, 1.0, 0.8)), tmp_path / "run", device="cpu")
    (tmp_path / "cell.ply").rename(tmp_path / "renamed.ply")
    longer = on_mesh(tmp_path / "renamed.ply", end=0.05)
    assert runner.simulate(longer, tmp_path / "run", device="cpu", resume=True).data["f"].sizes["frame"] == 6


def test_a_kept_membrane_is_not_sampled_again(tmp_path):
    """Its spacing is that of the run; another one would have no effect, so it is refused."""
    runner.simulate(on_mesh(ellipsoid(tmp_path / "cell.ply", 1.2, 1.0, 0.8)), tmp_path / "run", device="cpu")
    kept = {"kind": "grid", "file": tmp_path / "run" / "membrane.npz", "spacing": 0.1, "origin": [0, 0, 0]}
    first = runner.simulate(scene(kept), tmp_path / "again", device="cpu").data
    np.testing.assert_array_equal(first["f"].position, open_run(tmp_path / "run")["f"].position)
    with pytest.raises(SceneError, match=r"sampled with spacing = \[0\.1, 0\.1, 0\.1\]"):
        runner.simulate(scene({**kept, "spacing": 0.05}), tmp_path / "finer", device="cpu")


# --- earlier versions ------------------------------------------------------------------------------------------------


@pytest.fixture
def earlier(tmp_path) -> Path:
    """Folders of version 0.1.0: a finished run, and one that was killed after its third frame."""
    with tarfile.open(HERE.parent / "data" / "runs_0.1.0.tar.gz") as archive:
        archive.extractall(tmp_path, filter="data")
    return tmp_path


def test_a_run_of_an_earlier_version_is_opened_and_drawn(earlier):
    """It cannot be resumed, as its checkpoint has other arrays; to try it changes nothing."""
    finished, killed = open_run(earlier / "finished"), open_run(earlier / "killed")
    assert (finished["one"].sizes["frame"], killed["one"].sizes["frame"]) == (4, 3)
    for group in ("one", "cell"):
        for name, values in killed[group].data_vars.items():
            np.testing.assert_array_equal(values, finished[group][name][:3] if "frame" in values.dims else values)
    with pytest.raises(wr.RunFolderError, match=r"1 fault\n.*checkpoint\.npz is of another version"):
        check_run(earlier / "killed")
    assert wr.export_usd(earlier / "killed").is_file()
    before = {path: path.read_bytes() for path in sorted(earlier.rglob("*")) if path.is_file()}
    with pytest.raises(wr.RunFolderError, match="version"):
        begun = Scene.load(earlier / "killed" / "scene.toml")
        runner.simulate(begun, earlier / "killed", device="cpu", resume=True)
    assert before == {path: path.read_bytes() for path in sorted(earlier.rglob("*")) if path.is_file()}


@pytest.mark.long
def test_damaged_metadata_of_an_earlier_version_give_one_message(earlier):
    """Without checksums not all damage can be seen, but none gives a traceback, when it is read nor when resumed."""
    folder, outcomes = earlier / "killed", {"read": 0, "told": 0}
    store = folder / "trajectory.zarr"
    files = [store / name / "zarr.json" for name in ("", "_complete_frames", "one", "one/position", "cell/time")]
    for file in files:
        data, rng = file.read_bytes(), np.random.default_rng(3)
        changed = [bytearray(data) for _ in range(6)]
        for copy in changed:
            copy[rng.integers(len(data))] ^= 1 << int(rng.integers(6))
        for content in [b"", data[: len(data) // 2], b"[]", b"{}", data.replace(b'"array"', b'"arrow"'), *changed]:
            file.write_bytes(content)
            try:
                for group in open_run(folder).children.values():
                    group.to_dataset().load()
                check_run(folder)
                outcomes["read"] += 1
            except wr.WarpRodsError:
                outcomes["told"] += 1
            shutil.copytree(folder, earlier / "copy")
            with contextlib.suppress(wr.WarpRodsError):
                TrajectoryWriter.resume(earlier / "copy" / "trajectory.zarr")
            shutil.rmtree(earlier / "copy")
            file.write_bytes(data)
    assert outcomes["told"] >= 25


# --- nothing is half-written -----------------------------------------------------------------------------------------


def test_a_refused_resume_changes_nothing(tmp_path):
    folder = tmp_path / "run"
    runner.simulate(scene(), folder, device="cpu")
    (folder / ".lock").unlink()
    before = contents(folder)
    refused = {
        "seed: 5 in the run, 6 in the scene": scene(seed=6),
        r"filaments\[0\]\.length: 0\.7 in the run, 0\.6 in the scene": scene(filaments=[{**FILAMENT, "length": 0.6}]),
        "steric: not given in the run|steric.strength": scene(steric={"strength": 1, "range": 0.1, "core": 0.1}),
        r"time\.step: 0\.001 in the run": scene(time={**TIME, "step": 5e-4}),
        r"beyond time\.end": scene(time={**TIME, "end": 0.02}),
    }
    for said, other in refused.items():
        with pytest.raises(RunFolderError, match=said):
            runner.simulate(other, folder, device="cpu", resume=True)
        assert contents(folder) == before, said
    whole = (folder / "checkpoint.npz").read_bytes()
    for damaged in (b"", whole[:-40], whole[:300] + b"x" + whole[301:]):
        (folder / "checkpoint.npz").write_bytes(damaged)
        before = contents(folder)
        with pytest.raises(RunFolderError, match=r"checkpoint\.npz is damaged"):
            runner.simulate(scene(time={**TIME, "end": 0.04}), folder, device="cpu", resume=True)
        assert contents(folder) == before


@pytest.mark.parametrize("overwrite", [False, True])
def test_a_run_that_appeared_since_the_check_is_not_deleted(tmp_path, monkeypatch, overwrite):
    folder, real, appeared = tmp_path / "run", RunFolder.create, {}

    def late(path, *arguments, **named):
        with monkeypatch.context() as m:
            m.setattr(RunFolder, "create", real)
            runner.simulate(scene(seed=8), folder, device="cpu")
        appeared.update(contents(folder))
        return real(path, *arguments, **named)

    with monkeypatch.context() as m:
        m.setattr(RunFolder, "create", late)
        with pytest.raises(RunFolderError, match=r"another run than before|holds a run already"):
            runner.simulate(scene(), folder, device="cpu", overwrite=overwrite)
    assert appeared and contents(folder) == appeared
    assert runner.simulate(scene(), folder, device="cpu", overwrite=True).data.attrs["seed"] == 5


@pytest.mark.parametrize("what", ["trajectory.zarr", "trajectory.zarr/f/position", "trajectory.zarr/zarr.json", "."])
def test_a_store_that_is_deleted_during_a_run_is_noticed_at_the_next_frame(tmp_path, what, monkeypatch):
    """Of a part of it, at the next frame that is written."""
    if what == "trajectory.zarr/f/position":
        monkeypatch.setattr(run_folder, "FRAMES_EVERY", 0.0)
    folder, frames = tmp_path / "run", []

    def delete(simulation: wr.Simulation) -> None:
        frames.append(simulation.frame)
        if simulation.frame == 1:
            target = folder / what
            shutil.rmtree(target) if target.is_dir() else target.unlink()
            frames.append(set(contents(folder)) if folder.exists() else set())

    with pytest.raises(RunFolderError, match=r"trajectory\.zarr: .* while the run was writing to it"):
        runner.simulate(scene(), folder, device="cpu", hooks=[(wr.every(time=0.01), delete)])
    assert frames[-2] == 1 or frames[-1] == 1
    left = next(entry for entry in frames if isinstance(entry, set))
    assert set(contents(folder) if folder.exists() else ()) - {".lock"} <= left


def test_a_step_equal_to_save_every_up_to_round_off_runs_exports_and_resumes(tmp_path):
    """The frames' spacing over one step is longer than save_every in its last digit for many of these."""
    for end, every in ((0.1, 1e-4), (0.3, 0.1), (0.7, 1e-3)):
        tables = {"swimmers": [{**CELL, "count": 1}]}
        given = Scene.parse({**tables, "time": {"end": end, "save_every": every, "step": every}})
        planned = wr.Simulation(given, "cpu").scene
        assert Scene.parse(planned.to_toml()) == planned
    tables |= {"time": {"end": 0.007, "save_every": 1e-4, "step": 1e-4}}
    run = wr.run(Scene.parse(tables), tmp_path / "run", device="cpu")
    begun = Scene.load(run.folder / "scene.toml")
    assert wr.export_usd(run.folder).is_file()
    longer = Scene.parse({**tables, "time": {"end": 0.009, "save_every": 1e-4, "step": 1e-4}})
    assert wr.run(longer, run.folder, device="cpu", resume=True).data["c"].sizes["frame"] == 91
    assert begun.time.step == pytest.approx(1e-4, rel=1e-9)


def test_frames_wait_for_a_moment_only(tmp_path, monkeypatch):
    """The first one and those that are rare are written at once; a checkpoint is never ahead of the frames."""
    now, seen = [0.0], []
    monkeypatch.setattr(run_folder, "clock", lambda: now[0])
    append, checkpoint = RunFolder.append, RunFolder.checkpoint

    def appended(self, *frame):
        now[0] += 0.1 if self.writer.frames < 8 else 10.0
        append(self, *frame)
        seen.append(Document.read(self.path / "trajectory.zarr").frames)

    def kept(self, state):
        checkpoint(self, state)
        assert Document.read(self.path / "trajectory.zarr").frames == int(state["frame"]) + 1

    monkeypatch.setattr(RunFolder, "append", appended)
    monkeypatch.setattr(RunFolder, "checkpoint", kept)
    cell = {"name": "cell", "count": 1, "nodes": 17, "bend": 5e-3, "twist": 1e-3}
    runner.simulate(Scene.parse({"swimmers": [cell], "time": {"end": 0.011, "save_every": 1e-3}}), tmp_path / "run")
    assert seen == [1, 1, 1, 4, 4, 4, 7, 7, 7, 10, 11, 12]

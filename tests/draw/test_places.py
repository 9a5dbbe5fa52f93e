"""Where exports go: what is not of an export is never replaced, and exports at the same time leave each other alone."""

import os
import subprocess
import sys

import pytest
from examples.drawn import write_run
from typer.testing import CliRunner

import warp_rods as wr
from warp_rods import cli
from warp_rods.draw.content import content
from warp_rods.draw.exporters import EXPORTERS
from warp_rods.draw.selection import Selection
from warp_rods.errors import RunFolderError, SceneError, WarpRodsError
from warp_rods.simulation.leftovers import aside_of, partial_of, remove_partial

FOLDERS = [name for name, row in EXPORTERS.items() if not row.suffix]
ONE = Selection(frames=slice(0, 1))


@pytest.fixture
def run(tmp_path):
    write_run(tmp_path / "run")
    return tmp_path / "run"


def tree(folder) -> dict[str, bytes]:
    """Every file below a folder, with its bytes."""
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def export(run, *arguments):
    return CliRunner().invoke(cli.app, ["export", str(run), "--frames", "0", *map(str, arguments)])


@pytest.mark.parametrize("name", FOLDERS)
def test_a_folder_is_replaced_only_where_all_in_it_is_of_such_an_export(run, tmp_path, name):
    row = EXPORTERS[name]
    made = row.export(run, selection=ONE)
    (made / ".DS_Store").touch()  # a file manager has shown it
    assert row.export(run, selection=ONE) == made and not (made / ".DS_Store").exists()
    for own in ("holiday.txt", "inner/frame_1.png"):
        kept = made / own
        kept.parent.mkdir(exist_ok=True)
        kept.write_text("mine")
        with pytest.raises(SceneError, match=f"holds .*{own.split('/')[0]}.*another --out"):
            row.export(run, selection=ONE)
        assert kept.read_text() == "mine"
        kept.unlink()
    (made / "inner").rmdir()
    mine = tmp_path / "mine"
    (mine / row.stem).mkdir(parents=True)
    (mine / row.stem / "holiday.txt").write_text("mine")
    done = export(run, f"--{name}", "--out", mine)
    assert isinstance(done.exception, SceneError) and "--out" in str(done.exception)
    assert tree(mine) == {f"{row.stem}/holiday.txt": b"mine"}


def test_a_file_goes_into_a_folder_and_never_replaces_one(run, tmp_path):
    """Given the folder of a run, the animation is written into it."""
    before = tree(run)
    assert wr.export_usd(run, run) == run / "animation.usdc"
    assert {name: data for name, data in tree(run).items() if name != "animation.usdc"} == before
    (tmp_path / "keep" / "animation.usdc").mkdir(parents=True)
    (tmp_path / "keep" / "animation.usdc" / "mine").write_text("mine")
    with pytest.raises(SceneError, match="is a folder, which no file replaces"):
        wr.export_usd(run, tmp_path / "keep")
    assert tree(tmp_path / "keep") == {"animation.usdc/mine": b"mine"}


@pytest.mark.parametrize(
    ("flag", "out", "said"),
    [
        ("poster", "run/trajectory.zarr/zarr.json", "belongs to the data of a run"),
        ("poster", "run/trajectory.zarr/poster.png", "belongs to the data of a run"),
        ("png", "run/trajectory.zarr", "belongs to the data of a run"),
        ("png", "run/checkpoint.npz", "belongs to the data of a run"),
        ("poster", "run/scene.toml", "belongs to the data of a run"),
        ("poster", "notes.txt", "must be a file with the suffix .png"),
        ("png", "notes.txt", "must be a folder, without the suffix of a file"),
        ("png", "notes", "is a file, which no folder replaces"),
        ("png", "x.png", "must be a folder, without the suffix of a file"),
        ("usd", "x.txt", "must be a file with the suffix .usdc or .usd or .usda"),
        ("mp4", "film.gif", "must be a file with the suffix .mp4"),
        ("csv", "new", "must be a file with the suffix .csv"),
        ("csv", "notes/rods.csv", "is a file: give another folder"),
    ],
)
def test_what_is_not_of_an_export_is_not_replaced(run, tmp_path, flag, out, said):
    for name in ("notes.txt", "notes", "run/scene.toml"):
        (tmp_path / name).write_text("mine")
    before = tree(tmp_path)
    done = export(run, f"--{flag}", "--out", tmp_path / out)
    assert isinstance(done.exception, WarpRodsError), done.output
    assert said in str(done.exception) and "out" in str(done.exception)
    assert tree(tmp_path) == before


def test_suffixes_choose_the_form_of_usd_and_folders_are_made(run, tmp_path):
    for name, begins in (("a.usda", b"#usda"), ("b.usdc", b"PXR-USDC"), ("c.usd", b"PXR-USDC")):
        assert not export(run, "--usd", "--out", tmp_path / "new" / name).exception
        assert (tmp_path / "new" / name).read_bytes().startswith(begins)
    assert not export(run, "--csv", "--out", tmp_path / "deep" / "er" / "x.csv").exception
    assert (tmp_path / "deep" / "er" / "x.csv").is_file()
    assert not export(run, "--csv", "--wcon", "--out", tmp_path / "both").exception
    assert sorted(path.name for path in (tmp_path / "both").iterdir()) == ["rods.csv", "rods.wcon"]


def test_an_export_that_fails_leaves_nothing_and_keeps_the_old_folder(run, tmp_path, monkeypatch):
    made = EXPORTERS["png"].export(run, tmp_path / "pictures", ONE, dpi=20)
    before = tree(tmp_path)

    def broken(shown, path, **_options):
        path.mkdir()
        (path / "frame_0.png").write_text("half")
        raise OSError(28, "No space left on device")

    row = EXPORTERS["png"]
    failing = type(row)(row.what, "", broken, row.size, row.stem, row.options, holds=row.holds)
    for path in (made, tmp_path / "new" / "pictures"):
        with pytest.raises(RunFolderError, match="cannot be written: No space left on device"):
            failing.write(content(run, ONE), path)
        assert tree(tmp_path) == before and not (tmp_path / "new").exists()


def test_exports_at_the_same_time_leave_each_other(run):
    """Temporary files of processes that live stay; those of ended ones and of this one go."""
    living = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    names = {name: run / EXPORTERS[name].file_name for name in ("mp4", "gif", "png")}
    own = str(os.getpid())
    theirs = {partial_of(path) for path in names.values()}
    assert len({path.name for path in theirs}) == 3
    alive = [path.with_name(path.name.replace(own, str(living.pid))) for path in theirs]
    for path in (*alive, *theirs):
        path.touch()
    partial_of(names["gif"]).with_suffix(".abcdef").touch()  # a writer's own
    EXPORTERS["gif"].export(run, selection=ONE)
    left = {path.name for path in run.iterdir()}
    assert {path.name for path in alive} <= left
    assert {path.name for path in theirs if "gif" not in path.name} <= left
    assert not [name for name in left if "gif" in name and own in name]
    living.communicate(b"\n")
    for path in names.values():
        remove_partial(path)
    assert {path.name for path in run.iterdir()} == {"trajectory.zarr", "film.gif"}


def test_a_folder_that_was_set_aside_returns(run, tmp_path):
    """The export was killed after it had renamed the old folder."""
    made = EXPORTERS["png"].export(run, tmp_path / "pictures", ONE, dpi=20)
    before = tree(made)
    made.rename(aside_of(made))
    remove_partial(made)
    assert tree(made) == before

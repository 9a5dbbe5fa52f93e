"""The command line as a new user meets it: the first page, scenes, completion, plots, errors in colour."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import warp_rods as wr
from warp_rods import cli, front_page
from warp_rods.errors import RunFolderError
from warp_rods.scene.shipped import shipped

COMMAND = [sys.executable, "-m", "warp_rods"]


def invoke(*arguments, code=0) -> str:
    done = CliRunner().invoke(cli.app, list(map(str, arguments)), terminal_width=200, color=False)
    assert done.exit_code == code, done.output
    return done.output


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Path:
    """The folder runs/cells of a run of two swimmers, below a folder of its own."""
    folder = tmp_path_factory.mktemp("user") / "runs" / "cells"
    table = {"name": "cells", "count": 2, "nodes": 17, "bend": 5e-3, "twist": 1e-3, "moment": 1e-3}
    scene = wr.Scene(swimmers=[table], time={"end": 0.1, "save_every": 0.01}, output={"usd": False})
    return wr.run(scene, folder, device="cpu").folder


def test_alone_it_says_what_one_can_do_next(tmp_path, monkeypatch, run):
    monkeypatch.chdir(tmp_path)
    assert all(part in invoke() for part in ("warp-rods scenes", f"warp-rods run {front_page.FIRST}", "--help"))
    assert "at every point of its [sweep];" in " ".join(invoke("sweep", "--help").split())
    (tmp_path / "mine.toml").touch()
    assert "warp-rods check mine.toml" in invoke()
    monkeypatch.chdir(run.parents[1])
    text = invoke()
    assert "warp-rods status" in text and f"warp-rods plot {Path('runs/cells')}" in text


def test_scenes_are_listed_and_copied(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    listed = invoke("scenes")
    assert "Steady U-swimmer" in listed and len(listed.splitlines()) == len(shipped()) + 1
    assert "swimmer.toml" in invoke("scenes", "copy", "swimmer") and (tmp_path / "swimmer.toml").is_file()


@pytest.mark.parametrize("command", ["status", "plot", "watch", "export"])
def test_the_name_of_a_run_in_runs_is_taken_for_a_slip(run, monkeypatch, command):
    monkeypatch.chdir(run.parents[1])
    done = CliRunner().invoke(cli.app, [command, "cells"], terminal_width=200, color=False)
    said = done.output + str(done.exception)
    assert done.exit_code != 0 and f"(did you mean {Path('runs/cells')}?)" in said


def test_a_finished_run_that_is_resumed_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = wr.Scene(
        swimmers=[{"name": "cells", "count": 1, "nodes": 17, "bend": 5e-3, "twist": 1e-3}],
        time={"end": 0.02},
        output={"usd": False, "poster": False},
    )
    (tmp_path / "small.toml").write_text(scene.to_toml())
    assert "rod-steps/s" in invoke("run", "small.toml", "--device", "cpu")
    again = invoke("run", "small.toml", "--device", "cpu", "--resume")
    assert "already finished at t = 0.02; give a larger time.end to go on" in again
    assert "rod-steps" not in again and "residuals" not in again and "steps a rod" not in again


def test_status_has_a_line_a_run_and_an_exit_code(run, monkeypatch):
    monkeypatch.chdir(run.parents[1])
    assert invoke("status").splitlines() == [
        f"{Path('runs/cells')}  finished  100 %  11 of 11 frames  t = 0.1 of 0.1  0 of 2 rods lost"
    ]
    lines = invoke("status", "runs/cells", "elsewhere", code=2).splitlines()
    assert len(lines) == 2 and lines[1].startswith("elsewhere   no run    There is no run in elsewhere")
    assert "finished" in invoke("watch", "runs/cells")


def test_plots_are_listed_and_drawn(run, tmp_path):
    listed = invoke("plot", run)
    for name in ("energies", "kymograph_bend2", "phase_portrait", "mode_coefficients", "polar_order"):
        assert name in listed
    assert not (run / "plots").exists()
    drawn = invoke("plot", run, "energies", "kymograph_bend2", "polar_order", "--rod", 1).split()
    names = ["cells-energies.png", "cells-kymograph_bend2.png", "polar_order.png"]
    assert drawn == [str(run / "plots" / name) for name in names]
    assert {path.name for path in (run / "plots").iterdir()} == {*names, *(n.replace(".png", ".svg") for n in names)}
    for words, message in [
        (["energys"], "energys: no plot of this run (did you mean energies?)"),
        (["energies", "--ensembles", "cell"], "there is no such ensemble (did you mean cells?)"),
        (["kymograph_twist", "--rod", "2"], "rod = 2: there are 2, counted from 0"),
    ]:
        done = CliRunner().invoke(cli.app, ["plot", str(run), *words, "--out", str(tmp_path)])
        assert message in str(done.exception)
    with pytest.raises(wr.RunFolderError, match="There is no run or study in"):
        CliRunner().invoke(cli.app, ["plot", str(tmp_path)], catch_exceptions=False)


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("run sw", {"swimmer", "swarm_2d"}),
        ("run mi", {"mine.toml"}),
        ("scenes copy real", {"real_shape"}),
        ("watch ", {"runs/", "runs/cells"}),
        ("watch runs/", {"runs/cells"}),
        ("plot runs/cells kymograph_a", {"kymograph_activity"}),
        ("reproduce fig5.", {"fig5.3", "fig5.4"}),
        ("bench ker", {"kernels"}),
    ],
)
def test_the_tab_key_offers_names(run, monkeypatch, words, offered):
    monkeypatch.chdir(run.parents[1])
    Path("mine.toml").touch()
    command = f"warp-rods {words}"
    environment = {"_WARP_RODS_COMPLETE": "complete_bash", "COMP_WORDS": command, "COMP_CWORD": str(command.count(" "))}
    done = CliRunner().invoke(cli.app, [], prog_name="warp-rods", env=environment)
    assert offered <= set(done.output.split())


@pytest.mark.parametrize(("command", "studies"), [("plot", True), ("watch", False)])
def test_folders_of_studies_are_completed_where_they_can_be_plotted(tmp_path, monkeypatch, command, studies):
    monkeypatch.chdir(tmp_path)
    for name in ("a_run/trajectory.zarr", "a_study/study.zarr"):
        (tmp_path / "runs" / name).mkdir(parents=True)
    words = f"warp-rods {command} runs/a"
    environment = {"_WARP_RODS_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": "2"}
    done = CliRunner().invoke(cli.app, [], prog_name="warp-rods", env=environment).output.split()
    assert "runs/a_run" in done and ("runs/a_study" in done) == studies


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="there are no pseudo-terminals")
@pytest.mark.parametrize(
    ("environment", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False), ({"TERM": "dumb"}, False)]
)
def test_errors_are_coloured_on_a_terminal_only(tmp_path, environment, coloured):
    kept = {key: value for key, value in os.environ.items() if key not in ("NO_COLOR", "FORCE_COLOR")}
    main, other = os.openpty()
    command = [*COMMAND, "scenes", "copy", "nothing"]
    subprocess.run(command, stderr=other, env=kept | {"TERM": "xterm"} | environment, cwd=tmp_path, check=False)
    os.close(other)
    said = os.read(main, 100_000).decode()
    assert said.startswith("\x1b[1;31merror:\x1b[0m NAME = " if coloured else "error: NAME = ")
    piped = subprocess.run(command, capture_output=True, text=True, env=kept, cwd=tmp_path, check=False)
    assert piped.returncode == 2 and "\x1b" not in piped.stderr and len(piped.stderr.splitlines()) == 1


def test_an_out_of_plots_that_is_a_file_is_told(run, tmp_path):
    (tmp_path / "afile").write_text("mine")
    done = CliRunner().invoke(cli.app, ["plot", str(run), "energies", "--out", str(tmp_path / "afile")])
    assert isinstance(done.exception, RunFolderError) and re.search("out = .*afile is a file", str(done.exception))
    assert (tmp_path / "afile").read_text() == "mine"

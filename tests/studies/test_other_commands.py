"""What commands for runs say of the folder of a study."""

import re
from pathlib import Path

import pytest
from examples.study import cells, put, store_of
from typer.testing import CliRunner

import warp_rods as wr
from warp_rods import cli
from warp_rods.errors import RunFolderError
from warp_rods.simulation.under_way import lock_folder
from warp_rods.studies.plan import Plan


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """The study runs/torus, half of which is done."""
    monkeypatch.chdir(tmp_path)
    made = Path("runs/torus")
    made.mkdir(parents=True)
    plan = Plan(cells())
    half = plan.first()
    half[..., 1] = False
    put(store_of(plan, made), half)
    return made


@pytest.mark.parametrize("command", [("watch",), ("check",), ("export",), ("export", "--csv")])
def test_commands_for_runs_say_what_reads_a_study(folder, command):
    done = CliRunner().invoke(cli.app, [command[0], str(folder), *command[1:]])
    assert isinstance(done.exception, RunFolderError)
    said = str(done.exception)
    for part in (
        f"sweep SCENE --out {folder} --status",
        f"warp-rods plot {folder}",
        f'open_zarr("{folder}/study.zarr")',
    ):
        assert part in said
    assert "trajectories" not in said


def test_open_run_says_where_the_runs_of_a_study_are(folder):
    (folder / "trajectories").mkdir()
    with pytest.raises(RunFolderError, match=re.escape(f"runs of its points are in {folder / 'trajectories'}")):
        wr.open_run(folder)


def test_status_has_a_line_for_a_study(folder):
    def said(*arguments) -> tuple[str, int]:
        done = CliRunner().invoke(cli.app, ["status", *arguments])
        return done.output.strip(), done.exit_code

    line = f"{folder}  stopped  a study: 12 of 24 points done (50 %)"
    assert said() == said(str(folder)) == (line, 1)
    held = lock_folder(folder)
    assert said() == (line.replace("stopped", "running"), 4)
    held.release()

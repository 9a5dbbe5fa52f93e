"""The table of exporters, and the options of ``warp-rods export`` that come from it."""

import re

import numpy as np
import pytest
import typer
from examples.drawn import FRAMES, scene_text, write_run
from typer.testing import CliRunner

from warp_rods import cli
from warp_rods.draw.exporters import EXPORTERS, Exporter
from warp_rods.errors import RunFolderError, SceneError
from warp_rods.simulation.trajectory import STORE, SWIMMER_VARIABLES, GroupSpec, TrajectoryWriter


def invoke(app: typer.Typer, *arguments) -> str:
    done = CliRunner().invoke(app, list(map(str, arguments)), terminal_width=200, color=False)
    assert done.exit_code == 0, done.output
    return done.output


def test_every_exporter_is_an_option_with_its_file_name():
    text = " ".join(invoke(cli.app, "export", "--help").split())
    assert "DIR" in text
    for name, exporter in EXPORTERS.items():
        assert f"--{name}" in text and exporter.file_name in text


def test_usd_writes_the_animation(tmp_path):
    """Where the script for Blender looks for it; a file of USD that plays all frames."""
    from pxr import Usd

    write_run(tmp_path)
    made = EXPORTERS["usd"].export(tmp_path)
    stage = Usd.Stage.Open(str(made))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0, FRAMES - 1)
    assert {prim.GetName() for prim in stage.GetPrimAtPath("/World/Ensembles").GetChildren()} == {"cell", "sensors"}
    assert f'"{made.name}"' in EXPORTERS["blender"].export(tmp_path).read_text()


@pytest.mark.parametrize("name", EXPORTERS)
def test_a_folder_without_a_run_is_refused(name, tmp_path):
    with pytest.raises(RunFolderError, match="no run"):
        EXPORTERS[name].export(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_function_and_a_row_add_an_exporter(tmp_path, monkeypatch):
    """The command takes its new option, and makes only what was asked for."""
    write_run(tmp_path / "run")

    def write_names(shown, path, fps):
        path.write_text(f"{shown.title}, {shown.frames}, {fps}")

    row = Exporter("the name of the run", ".txt", write_names, lambda shown, fps: 2e6, "names", ("fps",))
    monkeypatch.setitem(EXPORTERS, "names", row)
    app = typer.Typer()
    app.callback()(lambda: None)
    cli.add_export(app)
    listed = invoke(app, "export", tmp_path / "run")
    assert re.search(r"--names +names\.txt, about 2 MB: the name of the run", listed)
    dry = invoke(app, "export", tmp_path / "run", "--names", "--dry-run")
    assert "names.txt" in dry and "usd" not in dry
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["trajectory.zarr"]
    made = tmp_path / "run" / "names.txt"
    assert invoke(app, "export", tmp_path / "run", "--names", "--fps", 5, "--frames", "1:5:2").split() == [str(made)]
    assert made.read_text() == "Rods on a ball, 2, 5.0"
    invoke(app, "export", tmp_path / "run", "--names", "--out", tmp_path / "own.txt")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["own.txt", "run"]


def test_without_a_flag_it_says_what_there_is_and_what_could_be_made(tmp_path):
    write_run(tmp_path)
    said = invoke(cli.app, "export", tmp_path)
    for part in ("Rods on a ball", f"{FRAMES} frames, t = 0 to 0.5", "sensors: 4 rods of 9 nodes", "energy_density"):
        assert part in said
    assert "membrane: sphere" in said and "colours: energy_density, twist" in said
    for name, exporter in EXPORTERS.items():
        assert re.search(rf"--{name} +{re.escape(exporter.file_name)}, about .*B: {re.escape(exporter.what)}", said)
    assert [path.name for path in tmp_path.iterdir()] == ["trajectory.zarr"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--ensembles", "sensor"], r"ensembles: there is no 'sensor' \(did you mean sensors\?\)"),
        (["--frames", "9:"], "frames: none is chosen; the run has 6"),
        (["--frames", "1:2:x"], "frames = '1:2:x': must be first:last:step"),
        (["--colour", "bend"], "colour = 'bend': must be one of energy_density, twist"),
        (["--range", "2,1"], "range = '2,1': must be"),
        (["--range=-inf,inf"], "range = '-inf,inf': must be .* two increasing finite numbers"),
        (["--fps", "-5"], r"fps = -5\.0: must be a number from 0\.01 to 1000"),
        (["--gif", "--fps", "0"], r"fps = 0\.0: must be a number from 0\.01 to 1000"),
        (["--mp4", "--fps", "nan"], "fps = nan: must be a number"),
        (["--html", "--limit", "nan"], "limit = nan: must be a number from 0.001 to 1000"),
        (["--png", "--dpi", "0"], "dpi = 0: must be a whole number from 10 to 1200"),
        (["--png", "--dpi", "-10"], "dpi = -10: must be"),
        (["--png", "--dpi", "1"], "dpi = 1: must be"),
    ],
)
def test_a_selection_that_does_not_fit_is_refused(tmp_path, options, message):
    write_run(tmp_path)
    done = CliRunner().invoke(cli.app, ["export", str(tmp_path), "--usd", *options])
    made = sorted(path.name for path in tmp_path.iterdir() if path.name != "animation.usdc")
    assert made == ["trajectory.zarr"]
    assert isinstance(done.exception, SceneError) and re.search(message, str(done.exception))


def test_a_run_without_energies_is_listed_and_exported_in_a_colour_that_it_has(tmp_path):
    """Only a colour that was named is missed."""
    variables = {name: SWIMMER_VARIABLES[name] for name in ("position", "status")}
    spec = GroupSpec(2, 17, variables)
    writer = TrajectoryWriter.create(tmp_path / STORE, {"cell": spec}, {"scene": scene_text()})
    for number in range(2):
        saved = {name: np.zeros(spec.shape(v)) for name, v in variables.items()}
        saved["position"][..., 0] = np.linspace(0, 1, 17) + 0.1 * number
        writer.append(0.1 * number, {"cell": saved})
    writer.close()
    assert "colours: speed, heading, rod" in invoke(cli.app, "export", tmp_path)
    invoke(cli.app, "export", tmp_path, "--csv")
    assert (tmp_path / "rods.csv").read_text().splitlines()[0].endswith(",x,y,z,speed")
    refused = CliRunner().invoke(cli.app, ["export", str(tmp_path), "--csv", "--colour", "energy_density"])
    assert isinstance(refused.exception, RunFolderError) and "speed, heading, rod" in str(refused.exception)

"""The table of exporters, and the options of ``warp-rods export`` that come from it."""

import pytest
import typer
from typer.testing import CliRunner

from warp_rods import cli
from warp_rods.draw.exporters import EXPORTERS, Exporter
from warp_rods.errors import RunFolderError


def invoke(app: typer.Typer, *arguments) -> str:
    done = CliRunner().invoke(app, list(map(str, arguments)), terminal_width=200, color=False)
    assert done.exit_code == 0, done.output
    return done.output


def test_without_options_everything_that_can_be_made_is_listed(tmp_path):
    lines = invoke(cli.app, "export", tmp_path).splitlines()
    assert len(lines) == len(EXPORTERS)
    for line, (name, exporter) in zip(lines, EXPORTERS.items(), strict=True):
        assert line.startswith(f"--{name} ") and exporter.file_name in line and exporter.what in line
    assert list(tmp_path.iterdir()) == []


def test_every_exporter_is_an_option_with_its_file_name():
    text = " ".join(invoke(cli.app, "export", "--help").split())
    assert "DIR" in text
    for name, exporter in EXPORTERS.items():
        assert f"--{name}" in text and exporter.file_name in text


def test_usd_writes_the_animation():
    assert EXPORTERS["usd"].file_name == "animation.usdc"


@pytest.mark.parametrize("name", EXPORTERS)
def test_a_folder_without_a_run_is_refused(name, tmp_path):
    with pytest.raises(RunFolderError, match="no run"):
        EXPORTERS[name].export(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_function_and_a_row_add_an_exporter(tmp_path, monkeypatch):
    """The command takes its new option, and makes only what was asked for."""

    def write_names(run_dir, path):
        path.write_text(run_dir.name)
        return path

    monkeypatch.setitem(EXPORTERS, "names", Exporter("the name of the folder", ".txt", write_names, stem="names"))
    app = typer.Typer()
    app.callback()(lambda: None)
    cli.add_export(app)
    assert "--names     names.txt: the name of the folder" in invoke(app, "export", tmp_path)
    assert invoke(app, "export", tmp_path, "--names").split() == [str(tmp_path / "names.txt")]
    assert [path.name for path in tmp_path.iterdir()] == ["names.txt"]
    assert (tmp_path / "names.txt").read_text() == tmp_path.name

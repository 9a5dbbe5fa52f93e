"""The host of the reproductions: names, files, failures; and every quick form against stored numbers."""

import csv
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool

import pytest
from rich.console import Console
from typer.testing import CliRunner

from warp_rods import cli
from warp_rods.errors import UnknownReproduction
from warp_rods.reproductions import reproduce
from warp_rods.reproductions.catalogue import REPRODUCTIONS, Row


def broken(quick):
    raise ArithmeticError("no such number")


def test_rows_compare_numbers_and_statements():
    assert Row("a", 2.0, 2.1).difference == "+5 %"
    assert Row("a", 0.0, -0.25).difference == "-0.25"
    assert Row("a", "", 2.0).difference == ""
    assert Row("a", "waves", "flaps", holds=False).difference == "does not hold"
    assert Row("a", "about ten", 12.0, holds=True).difference == "holds"


def test_every_file_is_written(tmp_path):
    console = Console(record=True, width=150)
    (outcome,) = reproduce.run(["stiffness"], quick=True, out=tmp_path, console=console)
    assert not outcome.error
    assert [path.name for path in outcome.files] == [
        "stiffness.png", "stiffness.svg", "stiffness.csv", "stiffness.table.csv"
    ]  # fmt: skip
    assert all(path.stat().st_size for path in outcome.files)
    with outcome.files[-1].open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert [row["quantity"] for row in table] == [row.quantity for row in outcome.rows]
    said = console.export_text()
    assert "published" in said and "3.6e-25" in said and "stiffness.png" in said


def test_an_unknown_name_lists_those_there_are():
    with pytest.raises(UnknownReproduction, match="did you mean stiffness") as error:
        reproduce.run(["stifness"])
    assert error.value.exit_code == 2
    assert all(name in str(error.value) for name in [*REPRODUCTIONS, "all"])


def test_a_fault_becomes_an_outcome(tmp_path, monkeypatch):
    monkeypatch.setitem(REPRODUCTIONS, "broken", REPRODUCTIONS["stiffness"]._replace(make=broken))
    outcome = reproduce.perform("broken", True, tmp_path)
    assert "ArithmeticError: no such number" in outcome.error and not outcome.files


def test_all_goes_on_after_a_failure_and_says_so(tmp_path, monkeypatch):
    def outcomes(names, quick, out, console):
        return [reproduce.Outcome("first", error="Traceback"), reproduce.Outcome("second")]

    monkeypatch.setattr(reproduce, "run", outcomes)
    done = CliRunner().invoke(cli.app, ["reproduce", "all", "--quick", "--out", str(tmp_path)])
    assert done.exit_code == 1
    assert "failed: first" in done.output and "second" not in done.output


def test_list_names_them_all():
    done = CliRunner().invoke(cli.app, ["reproduce", "list"])
    assert done.exit_code == 0
    assert all(name in done.output and row.what in done.output for name, row in REPRODUCTIONS.items())


def test_a_process_that_is_killed_is_an_outcome():
    process, done = reproduce._Process("stiffness"), Future()
    done.set_exception(BrokenProcessPool("killed"))
    outcome = process.end(done)
    assert outcome.name == "stiffness" and "killed" in outcome.error


def test_one_that_fails_leaves_the_others_to_go_on(tmp_path, monkeypatch):
    """A spawned process knows no patched table: a name that is not there fails in it."""
    monkeypatch.setitem(REPRODUCTIONS, "elsewhere", REPRODUCTIONS["stiffness"])
    first, second = reproduce.run(["elsewhere", "stiffness"], True, tmp_path, Console(quiet=True))
    assert first.name == "elsewhere" and "KeyError" in first.error
    assert second.name == "stiffness" and not second.error
    assert isinstance(second.rows[0], Row)

"""The runner of reproductions: names, files, failures."""

import csv
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool

import pytest
from rich.console import Console
from typer.testing import CliRunner

from warp_rods import cli
from warp_rods.errors import UnknownReproduction
from warp_rods.reproductions import reproduce
from warp_rods.reproductions.catalogue import REPRODUCTIONS, Comparison


def broken(quick):
    raise ArithmeticError("no such number")


def test_rows_compare_numbers_and_statements():
    assert Comparison("a", 2.0, 2.1).difference == "+5 %"
    assert Comparison("a", 0.0, -0.25).difference == "-0.25"
    assert Comparison("a", "", 2.0).difference == ""
    assert Comparison("a", "waves", "flaps", statement_holds=False).difference == "does not hold"
    assert Comparison("a", "about ten", 12.0, statement_holds=True).difference == "holds"


@pytest.mark.long
def test_every_file_is_written(tmp_path, monkeypatch):
    """And without a terminal lines tell what is running."""
    monkeypatch.setattr(reproduce, "LINE_EVERY", 0.1)
    console = Console(record=True, width=150, force_terminal=False)
    (outcome,) = reproduce.run(["stiffness"], quick=True, out=tmp_path, console=console)
    assert not outcome.error
    assert [path.name for path in outcome.files] == [
        "stiffness.png", "stiffness.svg", "stiffness.csv", "stiffness.table.csv"
    ]  # fmt: skip
    assert all(path.stat().st_size for path in outcome.files)
    with outcome.files[-1].open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert [row["quantity"] for row in table] == [row.quantity for row in outcome.rows]
    text = console.export_text()
    assert "0 of 1 done; running stiffness (" in text
    assert "published" in text and "3.6e-25" in text and "stiffness.png" in text


def test_an_unknown_name_is_refused_with_the_known_ones():
    with pytest.raises(UnknownReproduction, match="did you mean stiffness") as error:
        reproduce.run(["stifness"])
    assert error.value.exit_code == 2
    assert all(name in str(error.value) for name in [*REPRODUCTIONS, "all"])


def test_an_exception_becomes_an_outcome(tmp_path, monkeypatch):
    monkeypatch.setitem(REPRODUCTIONS, "broken", REPRODUCTIONS["stiffness"]._replace(make=broken))
    outcome = reproduce.perform("broken", True, tmp_path)
    assert "ArithmeticError: no such number" in outcome.error and not outcome.files


def test_all_continues_after_a_failure_and_reports_it(tmp_path, monkeypatch):
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


def test_a_killed_process_becomes_an_outcome():
    process, done = reproduce._Process("stiffness"), Future()
    done.set_exception(BrokenProcessPool("killed"))
    outcome = process.end(done)
    assert outcome.name == "stiffness" and "killed" in outcome.error


@pytest.mark.long
def test_the_others_continue_when_one_fails(tmp_path, monkeypatch):
    """A spawned process does not see the patched table, so that the new name fails there."""
    monkeypatch.setitem(REPRODUCTIONS, "elsewhere", REPRODUCTIONS["stiffness"])
    first, second = reproduce.run(["elsewhere", "stiffness"], True, tmp_path, Console(quiet=True))
    assert first.name == "elsewhere" and "KeyError" in first.error
    assert second.name == "stiffness" and not second.error
    assert isinstance(second.rows[0], Comparison)

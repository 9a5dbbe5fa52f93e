"""Every benchmark runs to its end; here in a quick form, whose figures mean nothing."""

import io
import subprocess
import sys
from importlib.util import find_spec

import pytest
import warp as wp
from rich.console import Console
from typer.testing import CliRunner

from warp_rods.bench import bench, results_file
from warp_rods.bench.catalogue import BENCHMARKS
from warp_rods.bench.peers import optional
from warp_rods.bench.result import Section, Settings, Table, shown
from warp_rods.bench.timing import Work, in_turns
from warp_rods.cli import app
from warp_rods.errors import SceneError

LONG = {"scenes", "scaling", "steps", "filament"}
"""Of these the test of the command runs one."""


@pytest.mark.parametrize("name", [n if n not in LONG else pytest.param(n, marks=pytest.mark.long) for n in BENCHMARKS])
def test_a_benchmark_finds_numbers(name):
    if name == "gpu" and not wp.is_cuda_available():
        pytest.skip("no CUDA device")
    section = BENCHMARKS[name].make()(Settings(quick=True))
    assert section.tables
    for table in section.tables:
        assert all(len(row) == len(table.columns) for row in table.rows), table
        assert sum(isinstance(cell, float) for row in table.rows for cell in row) >= 2, table
    if find_spec("numba") is None and name in ("kernels", "swimmer", "filament"):
        assert any(optional.INSTALL in note for note in section.notes)


@pytest.mark.skipif(wp.is_cuda_available(), reason="there is a CUDA device")
def test_without_a_gpu_its_benchmark_says_so():
    section = BENCHMARKS["gpu"].make()(Settings(quick=True))
    assert not section.tables and section.notes == ("No CUDA device here: not run.",)


def test_a_peer_that_is_missing_is_left_out_with_the_line_that_installs_it(monkeypatch):
    monkeypatch.setattr(optional, "find_spec", lambda name: None)
    assert optional.missing("numba", "elastica") == (
        "left out, as Numba and PyElastica is not installed: pip install 'warp-rods[bench]'"
    )
    assert optional.compiled(abs)(-1) == 1


def test_results_keep_the_sections_of_other_benchmarks(tmp_path):
    path, order = tmp_path / "new" / "RESULTS.md", ["one", "two", "three"]
    for name, value in (("three", 3.0), ("one", 1.0), ("three", 33.0)):
        section = Section([Table("times", ["", "s"], [["a", value], ["b", None]])], {}, ["a note"])
        results_file.write(path, name, results_file.text_of(name, "what", section, "a machine"), order)
    text = path.read_text(encoding="utf-8")
    assert text.startswith(results_file.HEAD) and text.count("\n## ") == 2
    assert text.index("## one") < text.index("| a | 1 |") < text.index("## three") < text.index("| a | 33 |")
    assert "| b | – |" in text and "- a note" in text and "| a | 3 |" not in text


def test_numbers_are_shown_with_three_digits():
    assert [shown(x) for x in (None, float("nan"), 0.012345, 123456.0, "text", 1)] == [
        "–", "–", "0.0123", "123,456", "text", "1",
    ]  # fmt: skip


def test_works_take_turns():
    order = []
    works = {name: Work(lambda name=name: order.append(name)) for name in "ab"}
    found = in_turns(works, repeats=2, long_enough=0.0)
    assert "".join(order) == "aabbabab"  # each twice to warm up and to learn how long it takes
    assert set(found) == {"a", "b"}


def test_an_unknown_name_is_refused_with_the_known_ones(tmp_path):
    with pytest.raises(SceneError, match=r"bench kernls: must be one of kernels, .*did you mean kernels"):
        bench.run(["kernls"], tmp_path / "RESULTS.md")
    with pytest.raises(SceneError, match="there is no warp_rods/ in it"):
        bench.run(["kernels"], tmp_path / "RESULTS.md", against=tmp_path)


def test_one_that_fails_is_told_and_the_others_continue(tmp_path, monkeypatch):
    def apart(name, quick, against, folder):
        if name == "kernels":
            raise ArithmeticError("no such number")
        return Section([Table("times", ["", "s"], [["a", 1.0]])])

    monkeypatch.setattr(bench, "_apart", apart)
    text = io.StringIO()
    console = Console(file=text)
    assert bench.run(["kernels", "steps"], tmp_path / "RESULTS.md", console=console) == ["kernels"]
    assert "no such number" in text.getvalue() and "## steps" in (tmp_path / "RESULTS.md").read_text(encoding="utf-8")


def test_the_command_lists_and_writes(tmp_path):
    listed = CliRunner().invoke(app, ["bench", "list"]).stdout
    assert all(name in listed for name in BENCHMARKS)
    out = tmp_path / "RESULTS.md"
    command = [sys.executable, "-m", "warp_rods", "bench", "filament", "--quick", "--out", out]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "sphere, until" in done.stdout and (tmp_path / "filament.png").is_file()
    assert "its figures mean nothing" in out.read_text(encoding="utf-8")

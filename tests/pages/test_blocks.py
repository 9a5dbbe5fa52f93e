"""Every code block of README.md and docs/ runs, in the order of its page, as a reader would run it in a clone."""

import re
import shlex
import tomllib
import warnings
from pathlib import Path

import numpy as np
import pytest
from typer.main import get_command
from typer.testing import CliRunner

import warp_rods as wr
from pages.blocks import (
    LANGUAGES,
    NOT_RUN,
    OTHER_FILES,
    PAGES,
    PYTHON_NOT_RUN,
    ROOT,
    RUNS_BEFORE,
    SHORTENED,
    Block,
    blocks_of,
    reason_not_to_run,
)
from warp_rods.cli import app

LONG = {
    *("analyse.md", "export.md", "fixed_shapes.md", "gpu.md", "loop.md", "own_force.md"),
    *("own_measure.md", "own_membrane.md", "paraview.md", "pictures.md", "start.md"),
}
"""Pages whose blocks take seconds each, and that need not be run every time."""
WHOLE = get_command(app)
COMMANDS = WHOLE.commands
SURFACE = {"kind": "sphere", "radius": 1.0}
CELLS = [{"name": "cells", "count": 1, "nodes": 17, "bend": 1e-2, "twist": 1e-2}]
SENSORS = [{"name": "sensors", "count": 2, "nodes": 9, "length": 0.3, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}]


@pytest.mark.parametrize(
    "page",
    [pytest.param(p, id=p.name, marks=[pytest.mark.long] if p.name in LONG else []) for p in PAGES if blocks_of(p)],
)
def test_the_blocks_of_a_page_run_in_their_order(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    _clone_into(tmp_path)
    for name in RUNS_BEFORE.get(page.name, ()):
        wr.run(f"scenes/{name}.toml", device="cpu")
    if page.name == "membranes.md":
        _write_stack(tmp_path / "nuclei.ome.tif")
    names: dict = {}
    for block in blocks_of(page):
        assert block.language in LANGUAGES, f"{page.name}, line {block.line}: ```{block.language}"
        if block.language == "python":
            _run_python(page, block, names)
        elif block.language == "toml":
            _start(block)
        elif block.language == "bash":
            for line in block.text.splitlines():
                _run_command(line)


def _clone_into(folder: Path) -> None:
    """The shipped scenes, some of which end earlier."""
    scenes = folder / "scenes"
    scenes.mkdir()
    for path in (ROOT / "scenes").iterdir():
        if path.stem in SHORTENED and path.suffix == ".toml":
            text = path.read_text(encoding="utf-8")
            end, save_every = SHORTENED[path.stem][0], SHORTENED[path.stem][0] / 4
            text, ends = re.subn(r"(?m)^end = .*", f"end = {end}", text)
            text, saves = re.subn(r"(?m)^save_every = .*", f"save_every = {save_every}", text)
            assert ends == saves == 1
            (scenes / path.name).write_text(text, encoding="utf-8")
        elif path.is_file():
            (scenes / path.name).symlink_to(path)


def _write_stack(path: Path) -> None:
    """A segmented stack, as somebody may have: a ball with the label 7."""
    import tifffile

    z, y, x = np.mgrid[-2.1:2.1:15j, -2.1:2.1:43j, -2.1:2.1:43j]
    tifffile.imwrite(path, np.uint8(7 * (x**2 + y**2 + z**2 < 1.5**2)), metadata={"axes": "ZYX"})


def _run_python(page: Path, block: Block, names: dict) -> None:
    """Lines of errors are those of the page. A picture that would be shown on a screen is not."""
    code = compile("\n" * (block.line - 1) + block.text, page, "exec")
    if any(mark in block.text for mark in PYTHON_NOT_RUN):
        return
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "FigureCanvasAgg is non-interactive")
        exec(code, names)


def _start(block: Block) -> None:
    """A block that names itself, ``# NAME.toml``, becomes that file. Every block is a scene, completed, that starts."""
    if name := re.match(r"# (\w+\.toml)\n", block.text):
        Path(name.group(1)).write_text(block.text, encoding="utf-8")
        if name.group(1) in OTHER_FILES:
            return
    tables = tomllib.loads(block.text)
    has_rods = any(kind in tables for kind in ("swimmers", "filaments", "cosserat"))
    if not has_rods and ("surface" in tables or "gauss" in str(tables.get("output"))):
        tables["filaments"] = SENSORS
    elif not has_rods:
        tables["swimmers"] = CELLS
    if "filaments" in tables:
        tables.setdefault("surface", SURFACE)
    tables.setdefault("time", {"end": 0.1})
    simulation = wr.Simulation(wr.Scene.parse(tables), "cpu")
    simulation.warm_up()
    assert not simulation.new_failures()


def _run_command(line: str) -> None:
    if reason_not_to_run(line):
        return
    assert line.startswith("warp-rods "), f"{line}: neither a command of ours nor in NOT_RUN"
    done = CliRunner().invoke(app, shlex.split(line, comments=True)[1:])
    assert done.exit_code == 0, f"{line}: {done.output} {done.exception!r}"


def _lines_of_shells() -> list[str]:
    return [line for page in PAGES for b in blocks_of(page) if b.language == "bash" for line in b.text.splitlines()]


def test_what_is_not_run_is_there():
    """No row of the tables outlives what it is about."""
    lines = _lines_of_shells()
    assert {row for row in NOT_RUN if any(re.fullmatch(row, line) for line in lines)} == set(NOT_RUN)
    python = [b.text for page in PAGES for b in blocks_of(page) if b.language == "python"]
    assert all(any(mark in text for text in python) for mark in PYTHON_NOT_RUN)
    assert all((ROOT / "scenes" / f"{name}.toml").is_file() for name in SHORTENED)
    assert {name for name in RUNS_BEFORE} <= {page.name for page in PAGES}
    assert {page.name for page in PAGES} >= LONG


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name)
def test_commands_in_the_text_exist(page):
    """`warp-rods COMMAND --option` in a sentence: the command and its options are known."""
    text = page.read_text(encoding="utf-8")
    for said in re.findall(r"`warp-rods ([^`]+)`", text) + re.findall(r"(?m)^(?:    )?warp-rods (.+)$", text):
        name, *rest = said.split()
        if name.startswith("--"):
            name, rest = None, [name, *rest]
        assert name is None or name in COMMANDS, f"warp-rods {said}"
        known = {option for parameter in (COMMANDS[name] if name else WHOLE).params for option in parameter.opts}
        options = {word.strip("[]….") for word in rest if re.match("--[a-z]", word)}
        assert options <= known, f"warp-rods {said}: {options - known}"


def test_the_readme_is_read_in_two_minutes():
    """At 250 words a minute, tables and code included."""
    words = re.findall(r"\w+", re.sub(r"\]\([^)]*\)", "]", (ROOT / "README.md").read_text(encoding="utf-8")))
    assert len(words) < 700

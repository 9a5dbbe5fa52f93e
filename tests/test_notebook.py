"""What notebooks show: tables of scenes, runs and ensembles, and bars that are updated in place."""

import sys
import types

import pytest
from rich.console import Console

import warp_rods as wr
from warp_rods import progress
from warp_rods.notebook import html_table

CELLS = {"name": "cells", "count": 3, "nodes": 17, "bend": 5e-3, "twist": 1e-3}


def test_tables_are_escaped():
    table = html_table([("a < b", 1)], ("x", "y"), "R & D")
    assert "<b>R &amp; D</b>" in table and "a &lt; b" in table and table.count("<tr>") == 2 and table.count("<th") == 2


def test_scenes_runs_and_ensembles_are_tables(tmp_path):
    scene = wr.Scene(title="Three", swimmers=[CELLS], time={"end": 0.02, "save_every": 0.01}, output={"usd": False})
    for part in ("<b>Three</b>", ">cells<", ">swimmers<", ">3<", ">17<", "until t = 0.02"):
        assert part in scene._repr_html_()
    run = wr.run(scene, tmp_path / "run", device="cpu")
    for part in (f"Run in {tmp_path / 'run'}", ">cells<", ">3<", ">17<", ">lost<", ">0<", " s<"):
        assert part in run._repr_html_()
    rods = wr.FreeRods(2, 17, bend=5e-3, twist=1e-3, device="cpu")
    assert ">FreeRods<" in rods._repr_html_() and "frozen" not in rods._repr_html_()
    state = rods.state()
    state["status"] = state["status"] * 0 + [0, int(wr.Status.TOO_BENT)]
    rods.restore(state)
    assert ">1: a rod that bent by more than half a turn" in rods._repr_html_()


@pytest.fixture
def cell(monkeypatch) -> list[str]:
    """The output of a cell: one entry for each thing that was displayed, as it is now; and all that it ever was."""
    shown: list[str] = []

    class Handle:
        def __init__(self, html):
            self.place = len(shown)
            shown.append(html)

        def update(self, html):
            shown[self.place] = html

    module = types.SimpleNamespace(HTML=str, display=lambda html, display_id: Handle(html))
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(display=module))
    monkeypatch.setitem(sys.modules, "IPython.display", module)
    return shown


def test_a_bar_in_a_notebook_is_updated_in_place_and_goes_away(cell, monkeypatch):
    monkeypatch.setattr(progress, "WAIT", -1.0)
    monkeypatch.setattr(progress, "REFRESH", 0.0)
    console = Console(force_jupyter=True)
    with progress.Bar("running", 200, console) as bar:
        bar.update(50, "3 rod-steps/s")
        assert len(cell) == 1 and "value='0.2500'" in cell[0] and "25 % done" in cell[0] and "3 rod-steps/s" in cell[0]
        bar.update(100)
        assert len(cell) == 1 and "value='0.5000'" in cell[0]
    assert cell == [""]
    with progress.waiting("compiling", console):
        assert len(cell) == 2 and "compiling …" in cell[1] and "value" not in cell[1]
    assert cell == ["", ""]

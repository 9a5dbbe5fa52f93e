"""The public interface: names, version, quiet imports, repr of objects, short help texts."""

import importlib.metadata
import io
import subprocess
import sys
from contextlib import redirect_stdout
from pathlib import Path

import pytest

import warp_rods as wr

ROOT = Path(__file__).parents[1]
LONGEST_HELP = 90
"""Lines of a help text: one screen, or two small ones."""


def python(code: str) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)


def test_every_public_name_can_be_imported():
    stub = (ROOT / "warp_rods" / "__init__.pyi").read_text(encoding="utf-8")
    assert len(wr.__all__) > 25
    for name in wr.__all__:
        assert getattr(wr, name) is not None
        assert f'"{name}"' in stub


def test_the_version_is_that_of_the_package():
    assert wr.__version__ == importlib.metadata.version("warp-rods")


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="runn"):
        _ = wr.runn


def test_importing_is_fast():
    """Neither Warp nor NumPy is imported before a name is used that needs them."""
    found = python("import sys, warp_rods; print({'warp', 'numpy', 'scipy', 'xarray', 'pydantic'} & set(sys.modules))")
    assert found.stdout.strip() == "set()"


def test_python_is_quiet():
    """No banner, no messages on modules or CUDA drivers."""
    found = python(
        "import warp_rods as wr\n"
        "rods = wr.FreeRods(1, 33, bend=1e-3, twist=1e-3, device='cpu')\n"
        "rods.step(1e-3, 2); rods.energy\n"
        "torus = wr.surfaces.make('torus', {'major': 1.0, 'minor': 0.4})\n"
        "wr.BoundRods(torus, [[1.4, 0, 0]], [[0, 1, 0.3]], device='cpu').step(1e-3)"
    )
    assert found.stdout == "" and found.stderr == ""


def test_repr_of_objects():
    torus = wr.surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    rods = wr.FreeRods(2, 33, bend=1e-3, twist=1e-3, device="cpu")
    cells = {"name": "cells", "count": 3, "nodes": 33, "bend": 1e-3, "twist": 1e-3}
    scene = wr.Scene(swimmers=[cells], time={"end": 1})
    simulation = wr.Simulation(scene, "cpu")
    assert repr(torus).startswith("<Surface torus (major = 1.0, minor = 0.4): closed")
    assert repr(rods) == "<FreeRods: 2 rods of 33 nodes on cpu, t = 0, all ok>"
    assert repr(scene) == "<Scene: cells (3 swimmers); until t = 1>"
    assert repr(simulation) == "<Simulation of cells (3 rods) on cpu: t = 0 of 1>"


ROOMS = ["analysis", "contact", "draw", "membranes", "reproductions", "rods", "scene", "simulation", "theory"]
OF_FUNCTIONS = ["diagnostics", "kymograph", "modes", "plots", "sensing", "stability", "surfaces", "swarm"]


@pytest.mark.parametrize("name", [*ROOMS, *OF_FUNCTIONS])
def test_help_is_about_a_screen(name):
    if name in ROOMS:
        __import__(f"warp_rods.{name}")
    what = sys.modules[f"warp_rods.{name}"] if name in ROOMS else getattr(wr, name)
    text = io.StringIO()
    with redirect_stdout(text):
        help(what)
    lines = text.getvalue().splitlines()
    assert len(lines) <= LONGEST_HELP, f"{len(lines)} lines"

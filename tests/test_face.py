"""The public interface: names, version, quiet imports, repr of objects, short help texts."""

import ast
import importlib
import importlib.metadata
import pydoc
import re
import subprocess
import sys
from pathlib import Path

import pytest

import warp_rods as wr

ROOT = Path(__file__).parents[1]
LONGEST_HELP = 75
"""Lines of a help text: about one screen."""
LONGER = {"steady": 106, "FreeRods": 215, "BoundRods": 175, "CosseratRods": 170, "Ensemble": 110}
"""Classes with many readings take a line and a name for each."""


STUB = ast.parse((ROOT / "warp_rods" / "__init__.pyi").read_text(encoding="utf-8"))
NAMES: list[str] = ast.literal_eval(STUB.body[-1].value)
"""What type checkers see: ``__all__`` of the stub."""


def python(code: str) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)


def test_every_public_name_can_be_imported():
    assert len(NAMES) > 25 and set(NAMES) <= set(dir(wr))
    for name in NAMES:
        assert getattr(wr, name) is not None


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


ROOMS = ["analysis", "contact", "draw", "frames", "membranes", "reproductions", "rods", "scene", "simulation", "theory"]
MODULES = ["", *ROOMS, "arguments", "device", "errors", "formula", "progress", "values", "workflow", "cli"]


@pytest.mark.parametrize("name", [f"warp_rods.{name}".rstrip(".") for name in MODULES] + NAMES)
def test_help_is_about_a_screen(name):
    what = importlib.import_module(name) if name.startswith("warp_rods") else getattr(wr, name)
    lines = pydoc.render_doc(what, renderer=pydoc.plaintext).splitlines()
    assert len(lines) <= LONGER.get(name, LONGEST_HELP), f"{len(lines)} lines"


def test_the_help_of_the_package_names_everything():
    """In its docstring, as the help of a name is one call away."""
    assert set(re.findall(r"\w+", wr.__doc__)) >= set(NAMES) - {"Ensemble", "errors"}

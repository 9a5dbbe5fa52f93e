"""Scenes as users see them: cost of importing, help, and repr."""

import pydoc
import subprocess
import sys

import pytest
from examples.scene import DESIGN, small

from warp_rods.membranes import surfaces
from warp_rods.scene.filaments import FilamentsTable
from warp_rods.scene.scene import Scene
from warp_rods.scene.swimmers import SwimmersTable

FORMULA = {"kind": "expression", "phi": "x**2 + y**2 + z**2 - R**2", "box": [[-2, 2]] * 3, "parameters": {"R": "1 + t"}}


def test_reading_a_scene_imports_nothing_for_building():
    code = (
        "import sys; from warp_rods.scene.scene import Scene; "
        f"Scene(**{small(surface=FORMULA, steric={'strength': 1.0, 'range': 0.1, 'core': 0.1})!r}); "
        "print(*sorted({name.split('.')[0] for name in sys.modules}))"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"warp", "sympy", "scipy", "trimesh", "xarray", "zarr"} & set(loaded)


@pytest.mark.parametrize("table", [Scene, FilamentsTable, SwimmersTable])
def test_help_is_one_screen_about_the_keys(table):
    text = pydoc.render_doc(table, renderer=pydoc.plaintext)
    assert len(text.splitlines()) < 60
    assert "model_dump" not in text and "Annotated" not in text
    for name, field in table.model_fields.items():
        assert f"{name}: {field.title}: {field.description}" in text


def test_repr_of_a_scene():
    scene = Scene.parse(DESIGN)
    assert repr(scene) == (
        '<Scene "100 curvature sensors on a dividing cell": sensors (100 filaments), cell (1 swimmer); '
        "surface cassini; steric; until t = 1>"
    )
    box = {"kind": "slab", "height": 1.0}
    cells = Scene(swimmers=[{"name": "c", "count": 2, "nodes": 17, "bend": 1, "twist": 1}], box=box, time={"end": 0.5})
    assert str(cells) == "<Scene: c (2 swimmers); box slab; until t = 0.5>"


def test_repr_of_a_surface():
    assert repr(surfaces.make("plane", {"size": 2})) == (
        "<Surface plane (size = 2.0): open, in the box [-1, 1] × [-1, 1] × [-0.2, 0.2]>"
    )
    assert repr(surfaces.make("sphere", {"radius": "1 + t"})).startswith(
        '<Surface sphere (radius = "1 + t"): closed, mov'
    )
    values = {key: value for key, value in FORMULA.items() if key != "kind"}
    assert repr(surfaces.make("expression", values | {"parameters": {"R": 1}})) == (
        '<Surface expression (phi = "x**2 + y**2 + z**2 - R**2", parameters = { R = 1.0 }): closed, '
        "in the box [-2, 2] × [-2, 2] × [-2, 2]>"
    )

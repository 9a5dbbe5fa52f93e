"""Parameters of ensembles: messages about impossible values, and parameters of activity laws."""

import numpy as np
import pytest

from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.free.rods import FreeRods
from warp_rods.scene import flagella
from warp_rods.scene.flagella import LAWS
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"bend": [1e-3, 0.0]}, "bend = 0: must be positive"),
        ({"bend": [1e-3, 1e-3, 1e-3]}, r"bend: values of shape \(3,\) do not fit 2 rods"),
        ({"bend": "soft"}, "bend: "),
        ({"nodes": 64}, "nodes = 64: must be an odd whole number"),
        ({"shape": {"kind": "spiral"}}, "shape.kind = 'spiral': must be one of mode, writhe, straight"),
        ({"shape": {"amplitud": 2.0}}, r"shape of kind mode: unknown key 'amplitud' \(did you mean amplitude\?\)"),
        ({"shape": {"mode": -1}}, "shape.mode = -1: must be a whole number"),
        ({"shape": np.zeros((2, 60, 3))}, r"shape: must be a table .* or strains \(2, 65, 3\)"),
        ({"shape": np.full((2, 65, 3), np.nan)}, "shape: strains must be finite"),
        ({"flagella": {"relaxatoin": 1e-2}}, r"flagella: unknown key 'relaxatoin' \(did you mean relaxation\?\)"),
        (
            {"flagella": {"law": "relaxed"}},
            f"law = 'relaxed': must be one of {', '.join(LAWS)} \\(did you mean",
        ),
        ({"flagella": {"profile": "step"}}, "flagella.profile = 'step': must be one of tanh"),
        ({"flagella": {"profile": [1.0, np.nan]}}, "flagella.profile: must be one of"),
        ({"flagella": {"profile": np.full(65, np.nan)}}, "flagella.profile: must be finite"),
        ({"flagella": {"relaxation": -1.0}}, "relaxation = -1: must be positive"),
        ({"flagella": 3}, "flagella = 3: must be a mapping"),
        ({"position": [1.0, 2.0]}, r"position: values of shape \(2,\)"),
        ({"rotation": 2 * np.eye(3)}, r"rotation\[0\] = .*: must be a rotation"),
        ({"rotation": np.diag([1.0, 1.0, -1.0])}, "must be a rotation"),
        ({"rotation": np.eye(2)}, r"rotation: must be a matrix \[3, 3\]"),
    ],
)
def test_mistakes_with_free_rods_name_the_parameter(given, said):
    with pytest.raises(SceneError, match=said):
        FreeRods(**({"count": 2, "nodes": 65, "bend": 1e-3, "twist": 1e-3} | given), device="cpu")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"stiffness": (1.0, 1.0)}, r"stiffness: values of shape \(2,\) do not fit 1 rods"),
        ({"stiffness": (1.0, 1.0, -1.0)}, "stiffness = -1: must be positive"),
        ({"drag": (1.0, 2.0, -0.1)}, "drag = -0.1: must be zero or more"),
        ({"length": np.nan}, "length = nan: must be positive"),
        ({"intrinsic": (0.0, np.inf, 0.0)}, "intrinsic = inf: must be any finite number"),
        ({"nodes": 5}, "nodes = 5: must be 9 or more"),
        ({"nodes": 33.5}, "nodes = 33.5: must be a whole number"),
        ({"position": [[1.4, 0]]}, r"position: must be finite numbers \[rod, 3\]; has shape \(1, 2\)"),
        ({"direction": [[0, 1, 0], [0, 1, 0]]}, r"direction: must be finite numbers \(1, 3\)"),
        ({"geodesic_curvature": [1.0, 2.0]}, "geodesic_curvature: must be a number, or numbers"),
        ({"geodesic_curvature": np.nan}, "geodesic_curvature: must be finite"),
        ({"ends": "free"}, "ends = 'free': must be a pair"),
        ({"ends": ("free", "pinned")}, "ends = 'pinned': must be one of free, clamped"),
        ({"at": "end"}, "at = 'end': must be one of start, middle"),
    ],
)
def test_mistakes_with_filaments_name_the_parameter(given, said):
    torus = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    with pytest.raises(SceneError, match=said):
        BoundRods(torus, **({"position": [[1.4, 0, 0]], "direction": [[0, 1, 0]]} | given), device="cpu")


BIASED = flagella.Law(
    "RELAXING", {"threshold": flagella.LawParameter(0.5, "positive"), "bias": flagella.LawParameter(-1.0)}
)


def test_a_law_may_have_parameters(monkeypatch):
    """A law with two parameters: from a mapping to the array that the kernels read."""
    monkeypatch.setitem(flagella.LAWS, "biased", BIASED)
    rods = FreeRods(2, bend=1e-3, twist=1e-3, flagella={"law": "biased", "threshold": [0.2, 0.3]}, device="cpu")
    np.testing.assert_array_equal(rods._arrays.rods.law_parameters.numpy(), [[0.2, -1, 0, 0], [0.3, -1, 0, 0]])
    with pytest.raises(SceneError, match=r"flagella\.threshold = -1: must be positive"):
        FreeRods(2, bend=1e-3, twist=1e-3, flagella={"law": "biased", "threshold": -1.0}, device="cpu")
    with pytest.raises(SceneError, match="unknown key 'threshold'"):
        FreeRods(2, bend=1e-3, twist=1e-3, flagella={"law": "relaxing", "threshold": 1.0}, device="cpu")


def test_a_law_with_parameters_is_used_from_a_scene(monkeypatch):
    """A table in TOML: defaults, one value for each rod, messages about faults, values in the array of the kernels."""
    monkeypatch.setitem(flagella.LAWS, "biased", BIASED)
    text = """
        time = {{ end = 0.1, step = 1e-3 }}
        [[swimmers]]
        name = "cells"
        count = 2
        nodes = 33
        bend = 1e-3
        twist = 1e-3
        flagella = {{ {} }}
    """
    scene = Scene.parse(text.format('law = "biased", threshold = [0.2, 0.3]'))
    assert Scene.parse(scene.to_toml()) == scene
    rods = Simulation(scene, "cpu").ensembles["cells"]
    np.testing.assert_array_equal(rods._arrays.rods.law_parameters.numpy(), [[0.2, -1, 0, 0], [0.3, -1, 0, 0]])
    for given, said in (
        ('law = "biased", threshold = 0', r"swimmers\[0\].flagella.threshold = 0: must be a positive number"),
        (
            'law = "biased", threshold = [1.0]',
            r"swimmers\[0\].flagella.threshold = .*: needs one entry for each of 2 rods",
        ),
        ('law = "biased", treshold = 1.0', r"flagella.treshold: unknown key \(did you mean threshold\?\)"),
        ("threshold = 1.0", r"flagella.threshold: unknown key; known here, with the law relaxing: relaxation"),
        ('law = "biasd"', r'flagella.law = "biasd": must be one of "relaxing", "held"'),
    ):
        with pytest.raises(SceneError, match=said):
            Scene.parse(text.format(given))

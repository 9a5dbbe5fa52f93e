"""Parameters of ensembles: messages about impossible values, and parameters of activity laws."""

import inspect
import pickle

import numpy as np
import pytest

from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.rods.bound.rods import BoundRods
from warp_rods.rods.free.flagella import Flagella
from warp_rods.rods.free.rods import FreeRods
from warp_rods.rods.tiles import Tiled
from warp_rods.scene import flagella
from warp_rods.scene.flagella import LAWS
from warp_rods.scene.scene import Scene
from warp_rods.simulation.loop import Simulation


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            {"twist": 1e-3, "shap": 1},
            r"shap: FreeRods has no such argument \(did you mean shape\?\); it has count",
        ),
        ({}, "twist: missing; FreeRods needs count, bend, twist"),
        ({"twist": 1e-3, "count": 2}, "FreeRods: multiple values for argument 'count'"),
    ],
)
def test_arguments_that_do_not_fit_are_named(given, said):
    """In Python as in a scene; the signature, which ``help`` shows, stays."""
    with pytest.raises(SceneError, match=said):
        FreeRods(2, bend=1e-3, **given)
    with pytest.raises(SceneError, match="surface, position, direction: missing; BoundRods needs"):
        BoundRods()
    assert list(inspect.signature(FreeRods).parameters)[:4] == ["count", "nodes", "bend", "twist"]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"bend": [1e-3, 0.0]}, "bend = 0: must be positive"),
        ({"bend": [1e-3, 1e-3, 1e-3]}, r"bend: must be a number, .*; has shape \(3,\), for 2 rods"),
        ({"bend": "soft"}, "bend = 'soft': column 1: soft is not known here; allowed are numbers, pi, s"),
        ({"nodes": 64}, "nodes = 64: must be an odd whole number"),
        ({"shape": {"kind": "spiral"}}, "shape.kind = 'spiral': must be one of mode, writhe, straight"),
        ({"shape": {"amplitud": 2.0}}, r"shape of kind mode: unknown key 'amplitud' \(did you mean amplitude\?\)"),
        ({"shape": {"mode": -1}}, "shape.mode = -1: must be a whole number"),
        ({"shape": np.zeros((2, 60, 3))}, r"shape: must be a table .* or strains \(2, 65, 3\)"),
        ({"shape": np.full((2, 65, 3), np.nan)}, "shape: must be finite at every node"),
        ({"flagella": {"relaxatoin": 1e-2}}, r"flagella: unknown key 'relaxatoin' \(did you mean relaxation\?\)"),
        (
            {"flagella": {"law": "relaxed"}},
            f"law = 'relaxed': must be one of {', '.join(LAWS)} \\(did you mean",
        ),
        ({"flagella": {"profile": "step"}}, "flagella.profile = 'step': must be one of tanh"),
        ({"flagella": {"profile": [1.0, np.nan]}}, "flagella.profile: must be one of"),
        ({"flagella": {"profile": np.full(65, np.nan)}}, "flagella.profile: must be finite"),
        ({"flagella": {"relaxation": -1.0}}, "^flagella.relaxation = -1: must be positive"),
        ({"flagella": {"diffusion": np.nan}}, "^flagella.diffusion = nan: must be zero or more and finite"),
        ({"flagella": {"sharpness": "x"}}, "flagella.sharpness = 'x': must be a number"),
        ({"flagella": {"sharpness": [1, 2]}}, r"flagella.sharpness = \[1, 2\]: must be one number"),
        ({"flagella": {"sharpness": -3}}, "flagella.sharpness = -3: must be positive"),
        ({"flagella": {"numbers": 5}}, "flagella.numbers = 5: must be a mapping"),
        ({"flagella": {"profile": lambda s: 1 / 0}}, "flagella.profile: must be .*; the function fails: division"),
        ({"flagella": {"profile": lambda: 1}}, "flagella.profile: must be .*; the function fails: "),
        ({"bend": "-1e-3"}, "bend = -0.001: must be positive"),
        ({"bend": True}, "bend = True: must be a number"),
        ({"bend": [True, 1.0]}, r"bend = \[True, 1.0\]: must be numbers"),
        ({"bend": None}, "bend = None: must be a number"),
        ({"bend": np.nan}, "bend = nan: must be positive and finite"),
        ({"bend": np.ma.array([1e-3, 2e-3], mask=[0, 1])}, "bend: has masked values"),
        ({"symmetric": "yes"}, "symmetric = 'yes': must be True or False"),
        ({"shape": 5}, "shape = 5: must be a table"),
        ({"shape": {"mode": True}}, "shape.mode = True: must be a whole number"),
        ({"shape": {"mode": 200}}, "shape.mode = 200: must be 62 or less for 65 nodes"),
        ({"shape": {"kind": "writhe", "balanced": "no"}}, "shape.balanced = 'no': must be True or False"),
        ({"external": 5}, "external = 5: must be a function"),
        ({"external": lambda t, x: x}, "external: must be a function .*: too many positional arguments"),
        ({"count": 2.0}, "count = 2.0: must be a whole number, 1 or more"),
        ({"nodes": np.float64(65)}, r"nodes = .*65.*: must be a whole number"),
        ({"flagella": 3}, "flagella = 3: must be a mapping"),
        ({"position": [1.0, 2.0]}, r"position: values of shape \(2,\)"),
        ({"rotation": 2 * np.eye(3)}, r"rotation\[0\] = .*: must be a rotation"),
        ({"rotation": np.diag([1.0, 1.0, -1.0])}, "must be a rotation"),
        ({"rotation": np.eye(2)}, r"rotation: must be a matrix \[3, 3\]"),
    ],
)
def test_mistakes_with_free_rods_name_the_parameter(given, said):
    with pytest.raises(SceneError, match=said):
        FreeRods(**({"count": 2, "nodes": 65, "bend": 1e-3, "twist": 1e-3, "device": "cpu"} | given))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"stiffness": (1.0, 1.0)}, r"stiffness: values of shape \(2,\) do not fit 1 rods"),
        ({"stiffness": (1.0, 1.0, -1.0)}, "stiffness = -1: must be positive"),
        ({"drag": (1.0, 2.0, -0.1)}, "drag = -0.1: must be zero or more"),
        ({"length": np.nan}, "length = nan: must be positive and finite"),
        ({"intrinsic": (0.0, np.inf, 0.0)}, "intrinsic = inf: must be finite"),
        ({"nodes": 5}, "nodes = 5: must be 9 or more"),
        ({"nodes": 33.5}, "nodes = 33.5: must be a whole number"),
        ({"surface": None}, "surface = None: must be a Surface, which surfaces.make"),
        ({"surface": "torus"}, "surface = 'torus': must be a Surface"),
        ({"surface": {"kind": "torus"}}, "surface = {'kind': 'torus'}: must be a Surface"),
        ({"ends": None}, "ends = None: must be a pair"),
        ({"ends": 5}, "ends = 5: must be a pair"),
        ({"position": "here"}, "position = 'here': must be a number"),
        ({"device": "gpu"}, "device = gpu: no such device; must be one of auto, cpu"),
        ({"growth": 5}, "growth = 5: must be a mapping"),
        ({"growth": {}}, "growth: must be { rate, until } or { time, length }"),
        ({"growth": {"rate": 1}}, "growth: must be { rate, until } or { time, length }"),
        ({"growth": {"time": [0, 1]}}, "growth: must be { rate, until } or { time, length }"),
        ({"growth": {"rate": "x", "until": 2}}, 'growth.rate = "x": must be a positive number'),
        ({"growth": {"rate": np.nan, "until": 2}}, "growth.rate = nan: must be .*; it must be finite"),
        (
            {"growth": {"rate": 1, "until": np.inf}},
            "growth.until = inf: must be .*; it must be finite",
        ),
        ({"growth": {"rate": [1, 2], "until": 2}}, r"growth.rate: values of shape \(2,\) do not fit 1 rods"),
        ({"growth": {"rate": 1, "until": 2, "start": np.nan}}, "growth.start = nan: must be 0 or a positive number"),
        ({"growth": {"rate": 1, "until": 2, "foo": 3}}, "growth.foo: unknown key; known here: rate, until"),
        ({"growth": {"rate": 1, "until": 2, "spacing": "x"}}, 'growth.spacing = "x": must be a positive number'),
        ({"growth": {"rate": 1, "until": 2, "spacing": [0.1]}}, r"growth.spacing = \[0.1\]: must be a positive number"),
        ({"growth": {"rate": 1, "until": 2, "spacing": 0}}, "growth.spacing = 0: must be a positive number"),
        ({"growth": {"time": [], "length": []}}, r"growth.time = \[\]: must be increasing times"),
        ({"growth": {"time": [0, np.nan], "length": [1, 2]}}, r"growth.time\[1\] = nan: must be a list"),
        (
            {"growth": {"time": [0, 1], "length": [2, 1]}},
            "growth.length = .* lengths that do not decrease",
        ),
        ({"growth": {"time": [0, 1], "length": [1, 2, 3]}}, "growth.length = .*: needs one length for each time"),
        (
            {"growth": {"time": [0, 1], "length": [[1, 2]] * 3}},
            "growth.length: needs one list, or one for each",
        ),
        ({"position": [[1.4, 0]]}, r"position: must be finite numbers \[rod, 3\]; has shape \(1, 2\)"),
        ({"direction": [[0, 1, 0], [0, 1, 0]]}, r"direction: must be finite numbers \(1, 3\)"),
        ({"geodesic_curvature": [1.0, 2.0]}, "geodesic_curvature: must be a number, a formula of s, or numbers"),
        ({"geodesic_curvature": np.nan}, "geodesic_curvature: must be finite"),
        ({"ends": "free"}, "ends = 'free': must be a pair"),
        ({"ends": ("free", "pinned")}, "ends = 'pinned': must be one of free, clamped"),
        ({"at": "end"}, "at = 'end': must be one of start, middle"),
    ],
)
def test_mistakes_with_filaments_name_the_parameter(given, said):
    torus = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    with pytest.raises(SceneError, match=said):
        defaults = {"surface": torus, "position": [[1.4, 0, 0]], "direction": [[0, 1, 0]], "device": "cpu"}
        BoundRods(**(defaults | given))


def test_growth_may_be_a_table_for_each_rod():
    """In Python and in a scene; a table for all rods is read as before."""
    torus = surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    growth = {"time": [0, 1], "length": np.array([[1, 2], [0.5, 1.5]], np.float32)}
    length = [1.0, 0.5]
    rods = BoundRods(torus, [[1.4, 0, 0]] * 2, [[0, 1, 0]] * 2, length=length, growth=growth, device="cpu")
    np.testing.assert_array_equal(rods.growth[1], [[1, 2], [0.5, 1.5]])
    table = {"name": "f", "count": 2, "nodes": 33, "length": length, "stiffness": (1, 1, 1), "drag": (1, 2, 0.1)}
    given = {"surface": {"kind": "torus", "major": 1.0, "minor": 0.4}, "time": {"end": 1.0, "step": 1e-3}}
    scene = Scene(filaments=[table | {"growth": growth}], **given)
    np.testing.assert_array_equal(Simulation(scene, "cpu").ensembles["f"].growth[1], rods.growth[1])
    with pytest.raises(SceneError, match=r"growth.length = .*: needs one entry for each of 2 rods, has 3"):
        Scene(filaments=[table | {"growth": {"time": [0, 1], "length": [[1, 2]] * 3}}], **given)
    with pytest.raises(SceneError, match=r"filaments\[0\].growth.time = \[0, 0\]: must be increasing times"):
        Scene(filaments=[table | {"growth": {"time": [0, 0], "length": [1, 2]}}], **given)


def test_flagella_can_be_compared_hashed_and_copied():
    """Also with arrays, and with parameters of a law; they cannot be changed."""
    one, same = (Flagella(profile=np.zeros(17), relaxation=np.array([1.0, 2.0])) for _ in range(2))
    assert one == same and hash(one) == hash(same) and one != Flagella()
    assert pickle.loads(pickle.dumps(one)) == one
    with pytest.raises(TypeError):
        Flagella().numbers["threshold"] = 1.0
    with pytest.raises(SceneError, match=r"flagella\.numbers = None: must be a mapping"):
        Flagella(numbers=None)


def test_flagella_may_be_an_object_in_a_scene():
    table = {"name": "c", "count": 2, "nodes": 17, "bend": 1e-3, "twist": 1e-3}
    flagella = {"relaxation": [1e-2, 2e-2], "sharpness": 5.0}
    as_object = Scene(swimmers=[table | {"flagella": Flagella(**flagella)}], time={"end": 1})
    assert as_object == Scene(swimmers=[table | {"flagella": flagella}], time={"end": 1})
    with pytest.raises(SceneError, match=r"swimmers\[0\].flagella.profile = .*: must be one of"):
        Scene(swimmers=[table | {"flagella": Flagella(profile=np.zeros(17))}], time={"end": 1})


BIASED = flagella.Law(
    "RELAXING",
    {"threshold": flagella.LawParameter("where f turns", 0.5, "positive"), "bias": flagella.LawParameter("of f", -1.0)},
)


def test_a_law_may_have_parameters(monkeypatch):
    """A law with two parameters: from a mapping to the array that the kernels read."""
    monkeypatch.setitem(flagella.LAWS, "biased", BIASED)
    rods = FreeRods(2, bend=1e-3, twist=1e-3, flagella={"law": "biased", "threshold": [0.2, 0.3]}, device="cpu")
    given = Tiled(rods._arrays.rods.law_parameters, 2).numpy()
    np.testing.assert_array_equal(given, [[0.2, -1, 0, 0], [0.3, -1, 0, 0]])
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
    given = Tiled(rods._arrays.rods.law_parameters, 2).numpy()
    np.testing.assert_array_equal(given, [[0.2, -1, 0, 0], [0.3, -1, 0, 0]])
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

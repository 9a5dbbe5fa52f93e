"""Types of values: NumPy scalars, arrays, tuples and paths are accepted; wrong ones are named."""

from datetime import date
from pathlib import Path

import numpy as np
import pytest
from examples.scene import FILAMENTS, PLACEMENT, SWIMMERS, small

from warp_rods.errors import SceneError
from warp_rods.membranes import surfaces
from warp_rods.scene.scene import Scene

F32 = np.float32


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    """An array with a ball of radius 12 voxels, as from an image."""
    path = tmp_path_factory.mktemp("image") / "a.npy"
    np.save(path, np.sqrt(((np.indices((40, 40, 40)) - 19.5) ** 2).sum(axis=0)) < 12)
    return path


VOXELS = {
    "numbers": {"spacing": [0.5, 0.5, 0.5], "origin": [0.0, 0.0, 0.0]},
    "a tuple of float32": {"spacing": (F32(0.5),) * 3, "origin": (F32(0),) * 3},
    "arrays": {"spacing": np.full(3, 0.5, F32), "origin": np.zeros(3, int)},
    "one float32": {"spacing": F32(0.5), "origin": np.zeros(3)},
    "an array without axes": {"spacing": np.array(0.5), "origin": [np.array(0.0)] * 3},
}


@pytest.mark.parametrize("voxels", VOXELS.values(), ids=list(VOXELS))
@pytest.mark.parametrize("as_path", [Path, str])
def test_values_of_image_readers_are_accepted_for_every_surface(voxels, as_path, file):
    values = {"file": as_path(file), **voxels}
    expected = {"file": str(file), "spacing": (0.5, 0.5, 0.5), "origin": (0.0, 0.0, 0.0)}
    assert surfaces.make("grid", values).values == expected
    tables = {"surface": {"kind": "grid", **values}, "filaments": [FILAMENTS], "time": {"end": 1.0}}
    for scene in (Scene(**tables), Scene.parse(tables)):
        assert scene.surface.parameters == expected
        assert Scene.parse(scene.to_toml()) == scene


@pytest.mark.parametrize(
    ("kind", "values", "expected"),
    [
        ("sphere", {"radius": np.array(2, np.int8)}, {"radius": 2.0}),
        (np.str_("sphere"), {"radius": F32(0.1)}, {"radius": float(F32(0.1))}),
        ("ellipsoid", {"radii": np.array([1, 2, 3])}, {"radii": (1.0, 2.0, 3.0)}),
        ("ellipsoid", {"radii": (1, F32(2), "3 + t")}, {"radii": (1.0, 2.0, "3 + t")}),
        (
            "expression",
            {"phi": np.str_("x**2 + y**2 + z**2 - R"), "box": np.array([[-2, 2]] * 3), "parameters": {"R": F32(1)}},
            {"phi": "x**2 + y**2 + z**2 - R", "box": ((-2.0, 2.0),) * 3, "parameters": {"R": 1.0}},
        ),
    ],
)
def test_numbers_of_every_kind_of_surface_are_accepted(kind, values, expected):
    surface = surfaces.make(kind, values)
    assert surface.values == expected and surface.kind == str(kind)
    scene = Scene(surface={"kind": kind, **values}, filaments=[FILAMENTS], time={"end": 1.0})
    assert scene.surface.parameters == expected


def test_numbers_of_every_table_are_accepted():
    plain = small(
        seed=3, filaments__placement={**PLACEMENT, "geodesic_curvature": [[0.5] * 9] * 2},
        filaments__length=[0.5, 0.25], swimmers__bend=[0.5, 0.25], swimmers__symmetric=False,
        time={"end": 2.0, "step": 0.125},
    )  # fmt: skip
    placement = {key: np.array(rows, F32) for key, rows in PLACEMENT.items()}
    arrays = small(
        seed=np.uint8(3), filaments__placement={**placement, "geodesic_curvature": np.full((2, 9), 0.5, F32)},
        filaments__length=np.array([0.5, 0.25], F32), swimmers__bend=(F32(0.5), np.float64(0.25)),
        swimmers__symmetric=np.bool_(False), time={"end": np.array(2), "step": F32(0.125)},
    )  # fmt: skip
    arrays["filaments"] = tuple(arrays["filaments"])
    arrays["filaments"][0]["count"] = np.int64(2)
    arrays["swimmers"] = np.array(arrays["swimmers"], dtype=object)
    assert Scene(**arrays) == Scene.parse(arrays) == Scene.parse(plain)


WRONG_SURFACES = [
    (3, {}, "surface.kind = 3: must be one of plane"),
    (None, {}, "surface.kind: missing; must be one of plane"),
    (["sphere"], {}, 'surface.kind = ["sphere"]: must be one of plane'),
    ("sphere", 3, "surface = 3: must be a table of values by name"),
    ("sphere", np.ones(2), "surface = [1.0, 1.0]: must be a table"),
    ("sphere", {1: 2.0, "radius": 1.0}, "surface.1: not a parameter of sphere"),
    ("sphere", {"radius": np.ones((2, 2))}, "surface.radius = [[1.0, 1.0], [1.0, 1.0]]: must be a positive number"),
    ("sphere", {"radius": np.bool_(True)}, "surface.radius = true: must be a positive number"),
    ("sphere", {"radius": 1 + 2j}, "surface.radius = (1+2j): must be a positive number"),
    ("sphere", {"radius": date(2020, 1, 1)}, "surface.radius = datetime.date(2020, 1, 1): must be a positive number"),
    ("sphere", {"radius": 10**400}, "must be a positive number; it must be finite"),
    ("ellipsoid", {"radii": {1.0, 2.0, 3.0}}, "surface.radii = {1.0, 2.0, 3.0}: must be 3 positive numbers"),
    ("ellipsoid", {"radii": np.ones((3, 1))}, "surface.radii[0] = [1.0]: must be 3 positive numbers"),
    ("ellipsoid", {"radii": np.ones(4)}, "surface.radii = [1.0, 1.0, 1.0, 1.0]: must be 3 positive numbers"),
    ("grid", {"file": 3}, "surface.file = 3: must be the path of a file"),
    ("grid", {"file": "a.npy", "spacing": np.ones(2)}, "surface.spacing = [1.0, 1.0]: must be a positive number"),
    ("grid", {"file": "a.npy", "spacing": {"x": 1}}, "surface.spacing = { x = 1 }: must be a positive number"),
    ("grid", {"file": "a.npy", "origin": "abc"}, 'surface.origin = "abc": must be three numbers'),
    ("grid", {"file": "a.npy", "origin": np.zeros((3, 3))}, "surface.origin = [[0.0, 0.0, 0.0],"),
    ("expression", {"phi": ["x"], "box": [[-1, 1]] * 3}, 'surface.phi = ["x"]: must be text in quotes'),
    ("expression", {"phi": "x", "box": np.ones((3, 3))}, "surface.box = [[1.0, 1.0, 1.0],"),
    ("expression", {"phi": "x", "box": {"x": [0, 1]}}, "surface.box = { x = [0, 1] }: must be [[x0, x1]"),
    ("expression", {"phi": "x + a", "box": [[-1, 1]] * 3, "parameters": {"a": np.ones(1)}}, "parameters.a = [1.0]: m"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "values", "message"), WRONG_SURFACES)
def test_a_wrong_value_of_a_surface_is_named(kind, values, message):
    with pytest.raises(SceneError) as caught:
        surfaces.make(kind, values)
    assert message in str(caught.value)


WRONG_SCENES = [
    ({"swimmers": np.ones(1)}, "swimmers[0] = 1.0: must be tables, each under [[swimmers]]"),
    ({"time": np.ones(2)}, "time = [1.0, 1.0]: must be a table"),
    ({"seed": F32(1)}, "seed = 1.0: must be a whole number"),
    ({"title": b"x"}, "title = b'x': must be text"),
    ({"swimmers__count": "2"}, 'swimmers[0].count = "2": must be a whole number, 1 or more, at most 10 million; leave'),
    ({"swimmers__bend": np.ones((2, 2))}, "swimmers[0].bend[0] = [1.0, 1.0]: must be a positive number"),
    ({"swimmers__bend": {1.0, 2.0}}, "swimmers[0].bend = {1.0, 2.0}: must be a positive number"),
    ({"swimmers__bend": iter([1.0, 2.0])}, "swimmers[0].bend = <list_iterator"),
    ({"swimmers__shape": 3}, "swimmers[0].shape = 3: must be a table"),
    ({"swimmers__placement": np.ones(3)}, "swimmers[0].placement = [1.0, 1.0, 1.0]: must be a table { position,"),
    ({"swimmers__placement": {"position": np.ones((2, 2))}}, "swimmers[0].placement.position[0] = [1.0, 1.0]: must be"),
    ({"filaments__ends": {"free", "clamped"}}, "must be a pair such as"),
    ({"filaments__stiffness": np.ones((2, 4))}, "filaments[0].stiffness[0] = [1.0, 1.0, 1.0, 1.0]: must be 3 positive"),
    ({"surface": "sphere"}, 'surface = "sphere": must be a table, [surface]'),
    ({"box": {"kind": "periodic", "size": iter([3, 3, 3])}, "surface": None, "filaments": None}, "box.size = <"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "message"), WRONG_SCENES)
def test_a_wrong_value_of_a_scene_is_named(changes, message):
    with pytest.raises(SceneError) as caught:
        Scene(**small(**changes))
    assert message in str(caught.value)


@pytest.mark.parametrize("scene", [3, None, [SWIMMERS], b"seed = 1"])
def test_objects_that_are_not_scenes_are_refused(scene):
    with pytest.raises(SceneError, match=r"scene = .*: must be TOML text or a mapping"):
        Scene.parse(scene)
    with pytest.raises(SceneError, match=r"path = .*: must be the path of a scene file"):
        Scene.load(scene)


def test_a_folder_may_be_a_string(file):
    text = '[surface]\nkind = "grid"\nfile = "a.npy"\nspacing = 0.5\n[time]\nend = 1.0\n'
    text += '[[filaments]]\nname = "f"\ncount = 1\nnodes = 9\nlength = 0.5\nstiffness = [1, 1, 1]\ndrag = [1, 2, 0]\n'
    assert Scene.parse(text, str(file.parent)).surface.parameters["file"] == str(file)

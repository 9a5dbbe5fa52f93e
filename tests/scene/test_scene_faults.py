"""Scenes that are refused: the message of each fault, and all faults in one message."""

import numpy as np
import pytest
from examples.scene import DESIGN, PLACEMENT, small

from warp_rods.errors import SceneError
from warp_rods.scene.scene import Scene


def faults(scene) -> list[str]:
    """The lines of the one message, without its heading."""
    with pytest.raises(SceneError) as caught:
        Scene.parse(scene)
    heading, *lines = str(caught.value).splitlines()
    assert heading == f"{len(lines)} fault{'s' * (len(lines) > 1)} in the scene"
    return [line.strip() for line in lines]


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"seed": -1}, "seed = -1: must be a whole number from 0"),
        ({"seed": 1.5}, "seed = 1.5: must be a whole number"),
        ({"title": 3}, "title = 3: must be text in quotes"),
        ({"surface": None}, "surface: missing; filaments need one: add [surface] with a kind, one of plane,"),
        ({"surface": 3}, "surface = 3: must be a table, [surface]"),
        ({"surface__kind": "spere"}, 'surface.kind = "spere": must be one of plane, sphere,'),
        ({"surface__kind": "spere"}, "(did you mean sphere?)"),
        ({"surface__radius": -1}, "surface.radius = -1: must be a positive number"),
        ({"surface__radius": None}, "surface.radius: missing; must be a positive number"),
        (
            {"surface__radios": 1},
            "surface.radios: not a parameter of sphere (did you mean radius?); it has radius",
        ),
        (
            {"surface": {"kind": "ellipsoid", "radii": [1, 2]}},
            "surface.radii = [1, 2]: must be 3 positive numbers",
        ),
        (
            {"surface": {"kind": "ellipsoid", "radii": [1, 2, 0]}},
            "surface.radii[2] = 0: must be 3 positive numbers",
        ),
        ({"surface": {"kind": "torus", "major": 1, "minor": 2}}, "surface: minor = 2.0 must be smaller"),
        (
            {"filaments": {"name": "f"}},
            'filaments = { name = "f" }: must be tables, each under [[filaments]]',
        ),
        ({"filaments": [3]}, "filaments[0] = 3: must be tables"),
        ({"filaments__name": "9 a"}, 'filaments[0].name = "9 a": must be a name'),
        ({"filaments__count": 0}, "filaments[0].count = 0: must be a whole number, 1 or more"),
        ({"filaments__count": True}, "filaments[0].count = true: must be a whole number, 1 or more"),
        ({"filaments__nodes": 8}, "filaments[0].nodes = 8: must be a whole number, 9 or more"),
        ({"filaments__length": None}, "filaments[0].length: missing; must be a positive number"),
        ({"filaments__length": -1.0}, "filaments[0].length = -1.0: must be a positive number"),
        ({"filaments__length": "1.0"}, "or a list with one for each rod; leave out the quotes"),
        ({"filaments__length": [1, 0]}, "filaments[0].length[1] = 0: must be a positive number"),
        (
            {"filaments__length": [1]},
            "filaments[0].length = [1]: needs one entry for each of 2 rods, has 1",
        ),
        (
            {"filaments__lenght": 1},
            "filaments[0].lenght: unknown key (did you mean length?); known here: name, count",
        ),
        ({"filaments__stiffness": 1}, "filaments[0].stiffness = 1: must be 3 positive numbers"),
        (
            {"filaments__stiffness": [[1, 1, 1]]},
            "filaments[0].stiffness = [[1, 1, 1]]: needs one entry for each of 2 rods, has 1",
        ),
        ({"filaments__stiffness": [[1, 1, 1], [1, 1]]}, "filaments[0].stiffness[1] = [1, 1]: must be 3"),
        (
            {"filaments__intrinsic": [0, float("nan"), 0]},
            "filaments[0].intrinsic[1] = nan: must be 3 numbers",
        ),
        ({"filaments__stiffness": [1, 2e10, 1]}, "filaments[0].stiffness = [1, 20000000000.0, 1]: one is 2e+10 times"),
        ({"filaments__drag": [1, 2, -0.1]}, "filaments[0].drag[2] = -0.1: must be 3 numbers"),
        ({"filaments__drag": [0, 2, 0]}, "filaments[0].drag[0] = 0: must be 3 numbers"),
        ({"filaments__ends": ["free", "loose"]}, 'filaments[0].ends[1] = "loose": must be a pair such as'),
        ({"filaments__ends": ["clamped"]}, "filaments[0].ends"),
        ({"filaments__growth": {"rate": 0.05}}, "filaments[0].growth: must be { rate, until } or { time, length }"),
        ({"filaments__growth": {"rate": 1, "until": -1}}, "filaments[0].growth.until = -1: must be a positive number"),
        (
            {"filaments__placement": "randon"},
            'filaments[0].placement = "randon": must be "random" or a table',
        ),
        ({"filaments__placement": {**PLACEMENT, "at": "end"}}, 'filaments[0].placement.at = "end": must be'),
        (
            {"filaments__placement": {"position": PLACEMENT["position"]}},
            "filaments[0].placement.direction: missing",
        ),
        (
            {"filaments__placement": {**PLACEMENT, "position": [[1, 0, 0]]}},
            "position = [[1, 0, 0]]: needs one entry for each of 2 rods, has 1",
        ),
        ({"filaments__placement": {**PLACEMENT, "direction": [[0, 0, 1], [0, 0, 0]]}}, "it has no direction"),
        (
            {"filaments__placement": {**PLACEMENT, "geodesic_curvature": [0.1, [0.1, 0.2]]}},
            "placement.geodesic_curvature[1] = [0.1, 0.2]: needs one value for each of 9 nodes, has 2",
        ),
        ({"swimmers__nodes": 16}, "swimmers[0].nodes = 16: must be an odd whole number, 17 or more"),
        ({"swimmers__nodes": 18}, "swimmers[0].nodes = 18: must be an odd whole number, 17 or more"),
        ({"swimmers__bend": float("inf")}, "swimmers[0].bend = inf: must be a positive number"),
        ({"swimmers__bend": 10**400}, "it must be finite"),
        ({"swimmers__moment": [1, 2, 3]}, "swimmers[0].moment = [1, 2, 3]: needs one entry for each of 2 rods, has 3"),
        ({"swimmers__flagella": {"profile": "tan"}}, 'swimmers[0].flagella.profile = "tan": must be one of "tanh"'),
        (
            {"swimmers__flagella": {"relaxation": [1]}},
            "swimmers[0].flagella.relaxation = [1]: needs one entry for each of 2 rods, has 1",
        ),
        (
            {"swimmers__shape": {"kind": "mode", "mode": -1}},
            "swimmers[0].shape.mode = -1: must be a whole number",
        ),
        ({"swimmers__shape": {"kind": "straight", "mode": 1}}, "a shape of kind straight has no mode; leave it out"),
        ({"swimmers__shape": {"balanced": False}}, "swimmers[0].shape.balanced: a shape of kind mode has no balanced"),
        (
            {"swimmers__shape": {"kind": "wave"}},
            'swimmers[0].shape.kind = "wave": must be one of "mode", "writhe", "straight",',
        ),
        ({"swimmers__shape": {"kind": [1]}}, "swimmers[0].shape.kind = [1]: must be"),
        (
            {"swimmers__shape": {"amplitude": [1]}},
            "swimmers[0].shape.amplitude = [1]: needs one entry for each of 2 rods, has 1",
        ),
        ({"swimmers__symmetric": 1}, "swimmers[0].symmetric = 1: must be true or false"),
        ({"swimmers__name": "F"}, 'swimmers[0].name = "F": is already the name of filaments[0]; each'),
        ({"steric": {"strength": 1, "range": 0, "core": 1}}, "steric.range = 0: must be a positive number"),
        ({"steric": {"strength": 1, "range": 1}}, "steric.core: missing; must be a positive number"),
        ({"time": None}, "time: missing; must be a table"),
        ({"time": {"end": 1, "step": 2}}, "time.step = 2: must be at most end = 1"),
        ({"time": {"end": 1, "save_every": 2}}, "time.save_every = 2: must be at most end = 1"),
        (
            {"time": {"end": 1, "step": 0.1, "save_every": 0.01}},
            "time.step = 0.1: must be at most save_every = 0.01",
        ),
        (
            {"units": {"length": "1 furlongs per m"}},
            'units.length = "1 furlongs per m": must be a positive number and a unit',
        ),
        ({"self": 1}, "self: unknown key"),
        ({"a\nb": 1}, r'"a\nb": unknown key'),
        ({"titel": "x"}, "titel: unknown key (did you mean title?); known here: title, seed,"),
    ],
)
def test_each_fault_has_a_line(change, line):
    lines = faults(small(**change))
    assert len(lines) == 1
    assert line in lines[0]


def test_every_fault_is_in_one_message():
    lines = faults(
        small(
            surface__radius=0,
            filaments__length=[1, 2, 3],
            filaments__stiffness=[1, 2],
            filaments__placement={**PLACEMENT, "at": "end", "position": [[0, 0, 1]]},
            swimmers__flagella={"relaxation": [1], "sharpness": -1},
            swimmers__twist=None,
            time={"end": "1"},
            sterik={},
        )
    )
    keys = sorted(line.split(" ")[0].rstrip(":") for line in lines)
    assert keys == [
        "filaments[0].length",
        "filaments[0].placement.at",
        "filaments[0].placement.position",
        "filaments[0].stiffness",
        "sterik",
        "surface.radius",
        "swimmers[0].flagella.relaxation",
        "swimmers[0].flagella.sharpness",
        "swimmers[0].twist",
        "time.end",
    ]


def test_only_the_first_wrong_values_of_a_long_list_are_named():
    lines = faults(small(swimmers__count=1000, swimmers__bend=np.full(1000, np.nan)))
    assert len(lines) == 6
    assert "995 more of its values are wrong" in lines[-1]
    assert max(map(len, lines)) < 200


def test_a_scene_needs_an_ensemble():
    assert faults({"time": {"end": 1}}) == [
        "filaments: missing; a scene has at least one [[filaments]], [[swimmers]] or [[cosserat]]"
    ]


def test_faulty_toml_is_named_by_line_and_column(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text("title = 'a'\nseed = = 3\n")
    with pytest.raises(SceneError, match=r"scene\.toml: this is not TOML: .*line 2, column 8"):
        Scene.load(file)
    with pytest.raises(SceneError, match="not TOML"):
        Scene.parse("a = " + "[" * 5000)


def test_files_that_cannot_be_read_are_named(tmp_path):
    with pytest.raises(SceneError, match=r"none\.toml: there is no such file"):
        Scene.load(tmp_path / "none.toml")
    with pytest.raises(SceneError, match="cannot be read"):
        Scene.load(tmp_path)
    (tmp_path / "latin.toml").write_bytes(b'title = "\xb5m"')
    with pytest.raises(SceneError, match="cannot be read as text"):
        Scene.load(tmp_path / "latin.toml")


def test_messages_start_with_the_name_of_the_file(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(DESIGN.replace("count = 100", "count = 0"))
    with pytest.raises(SceneError, match=r"scene\.toml: 1 fault in the scene\n  filaments\[0\]\.count = 0"):
        Scene.load(file)
    file.write_text(DESIGN, encoding="utf-8-sig")
    assert Scene.load(file) == Scene.parse(DESIGN)


@pytest.mark.parametrize(
    "text", ["um", "1", "0 m", "-1 m", "1 parsecond", "1 s", "1 um^2", "1.2.3 m", 3, "1 e m", "9e999 m"]
)
def test_wrong_units_are_refused(text):
    assert faults(small(units={"length": text}))[0].startswith("units.length = ")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"swimmers__bend": 1e-41}, "swimmers[0].bend = 1e-41: must be a positive number"),
        ({"swimmers__bend": 1e-41}, "positive numbers are at least 1e-40: use other units"),
        ({"swimmers__moment": -1.1e30}, "numbers are at most 1e+30 in size: use other units"),
        ({"surface__radius": 1e31}, "surface.radius = 1e+31: must be a positive number; numbers are at most 1e+30"),
        (
            {"swimmers__shape": {"mode": 50_001}},
            "swimmers[0].shape.mode = 50001: must be a whole number, 0 or more, at most",
        ),
    ],
)
def test_numbers_have_a_range(change, words):
    (line,) = faults(small(**change))
    assert words in line
    Scene.parse(small(swimmers__bend=1e-40, swimmers__moment=-1e30, surface__radius=1e30, time={"end": 1e-40}))


def test_a_file_without_an_end_is_refused():
    with pytest.raises(SceneError, match="/dev/zero: must have at most 100 MB"):
        Scene.load("/dev/zero")


def test_tables_in_tables_in_tables_are_refused(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text("a" + ".a" * 1500 + " = 1")
    with pytest.raises(SceneError, match=r"scene\.toml: tables or lists are nested too deeply"):
        Scene.load(path)


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
@pytest.mark.parametrize("end_of_line", [b"\n", b"\r\n"])
def test_a_scene_may_be_written_on_any_system(mark, end_of_line, tmp_path):
    text = Scene.parse(small()).to_toml().encode()
    (tmp_path / "scene.toml").write_bytes(mark + text.replace(b"\n", end_of_line))
    assert Scene.load(tmp_path / "scene.toml") == Scene.parse(small())

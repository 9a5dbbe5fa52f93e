"""The table [box] of a scene: messages of all faults, defaults, periods."""

import math

import numpy as np
import pytest

from warp_rods.errors import SceneError
from warp_rods.scene.box import Box
from warp_rods.scene.scene import Scene

CELLS = {"name": "cells", "count": 60, "nodes": 17, "bend": 1e-2, "twist": 1e-3}
STERIC = {"strength": 100.0, "range": 0.02, "core": 0.08}
TIME = {"end": 1.0}
SPHERE = {"kind": "sphere", "radius": 3.0}
FILAMENTS = {"name": "f", "count": 2, "nodes": 9, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0]}


def tables(box, **changes) -> dict:
    """A scene of swimmers in this box, with tables changed; None removes one."""
    every = {"swimmers": [CELLS], "steric": STERIC, "time": TIME, "box": box} | changes
    return {key: value for key, value in every.items() if value is not None}


def scene(box, **changes) -> Scene:
    return Scene.parse(tables(box, **changes))


def faults(box, **changes) -> list[str]:
    """The lines of the one message, without its heading."""
    with pytest.raises(SceneError) as caught:
        scene(box, **changes)
    heading, *lines = str(caught.value).splitlines()
    assert heading == f"{len(lines)} fault{'s' * (len(lines) > 1)} in the scene"
    return [line.strip() for line in lines]


@pytest.mark.parametrize(
    ("box", "line"),
    [
        (3, "box = 3: must be a table, [box]"),
        ({"size": [3, 3, 3]}, 'box.kind: missing; must be "periodic", "slab", "container", "pore" or "duct"'),
        ({"kind": "ball"}, 'box.kind = "ball": must be "periodic", "slab", "container", "pore" or "duct"'),
        ({"kind": ["slab"]}, 'box.kind = ["slab"]: must be'),
        ({"kind": "periodic"}, "box: size or fraction: missing; give one of them"),
        ({"kind": "periodic", "size": [3, 3]}, "box.size = [3, 3]: must be 3 positive numbers for a periodic box"),
        ({"kind": "periodic", "size": [3, 3, 0]}, "box.size[2] = 0: must be positive numbers: the periods"),
        ({"kind": "periodic", "size": [3, math.inf, 3]}, "box.size[1] = inf: must be positive numbers"),
        ({"kind": "periodic", "size": [3, math.nan, 3]}, "box.size[1] = nan: must be positive numbers"),
        (
            {"kind": "periodic", "size": [3, 3, 3, 3]},
            "box.size = [3, 3, 3, 3]: must be 3 positive numbers for a periodic box",
        ),
        ({"kind": "periodic", "size": 3}, "box.size = 3: must be positive numbers"),
        ({"kind": "periodic", "size": [0.3, 3, 3]}, "box.size = [0.3, 3, 3]: must be above 0.32, twice the reach"),
        ({"kind": "periodic", "size": [0.32, 3, 3]}, "box.size = [0.32, 3, 3]: must be above 0.32, twice the reach"),
        (
            {"kind": "periodic", "size": [3, 3, 3], "fraction": 0.2},
            "box: size and fraction: one follows from the other; give one of them",
        ),
        ({"kind": "periodic", "fraction": -0.2}, "box.fraction = -0.2: must be a positive number below 1"),
        ({"kind": "periodic", "fraction": 0}, "box.fraction = 0: must be a positive number below 1"),
        ({"kind": "periodic", "fraction": 1}, "box.fraction = 1: must be below 1"),
        (
            {"kind": "periodic", "size": [3, 3, 3], "height": 1},
            "box.height: a box of kind periodic has no height; it has fraction, size",
        ),
        ({"kind": "periodic", "size": [3, 3, 3], "wall": {}}, "box.wall: a box of kind periodic has no wall"),
        ({"kind": "slab"}, "box.height: missing; must be a positive number: the distance of a slab's walls"),
        ({"kind": "slab", "height": 0}, "box.height = 0: must be a positive number"),
        ({"kind": "slab", "height": 0.09}, "box.height = 0.09: must be at least 0.1, twice the range of the walls"),
        ({"kind": "slab", "height": 1, "wall": {"range": 0.6}}, "box.height = 1: must be at least 1.2, twice"),
        ({"kind": "slab", "height": 1, "size": [3, 3, 3]}, "must be 2 positive numbers for a slab box"),
        ({"kind": "slab", "height": 1, "side": "inside"}, "box.side: a box of kind slab has no side; it has fraction,"),
        ({"kind": "slab", "height": 1, "surface": SPHERE}, "box.surface: a box of kind slab has no surface"),
        ({"kind": "slab", "height": 1, "hight": 1}, "box.hight: unknown key (did you mean height?); known here: kind,"),
        ({"kind": "slab", "height": 1, "wall": 3}, "box.wall = 3: must be a table { strength, range }"),
        ({"kind": "slab", "height": 1, "wall": {"strength": 0}}, "box.wall.strength = 0: must be a positive number"),
        ({"kind": "slab", "height": 1, "wall": {"range": -1}}, "box.wall.range = -1: must be a positive number"),
        ({"kind": "slab", "height": 1, "wall": {"stiff": 1}}, "box.wall.stiff: unknown key"),
        ({"kind": "container"}, "box.surface: missing; must be a table as [surface], such as"),
        ({"kind": "container", "surface": {"kind": "sphere"}}, "box.surface.radius: missing; must be a positive"),
        ({"kind": "container", "surface": {"kind": "spere"}}, "(did you mean sphere?)"),
        (
            {"kind": "container", "surface": {**SPHERE, "radius": "3 + t"}},
            "box.surface: a container cannot move: give numbers, not formulas in t",
        ),
        ({"kind": "container", "surface": SPHERE, "side": "in"}, 'box.side = "in": must be "inside" or "outside"'),
        ({"kind": "container", "surface": SPHERE, "fraction": 0.2}, "box.fraction: a box of kind container has no"),
        ({"kind": "pore"}, "box.radius: missing; must be a positive number: of a pore"),
        ({"kind": "pore", "radius": 0.04}, "box.radius = 0.04: must be at least 0.05, the range of the walls"),
        (
            {"kind": "pore", "radius": 1, "sides": [1, 1]},
            "box.sides: a box of kind pore has no sides; it has axis, ends",
        ),
        ({"kind": "pore", "radius": 1, "length": 0.3}, "box.length = 0.3: must be above 0.32, twice the reach"),
        ({"kind": "pore", "radius": 1, "ends": "closed"}, 'box.ends = "closed": needs the length between the ends'),
        (
            {"kind": "pore", "radius": 1, "length": 2, "ends": "open"},
            'box.ends = "open": must be "periodic" or "closed"',
        ),
        ({"kind": "pore", "radius": 1, "length": 2, "axis": "w"}, 'box.axis = "w": must be "x", "y" or "z"'),
        ({"kind": "duct"}, "box.sides: missing; must be two positive numbers: the sides of the section of a duct"),
        ({"kind": "duct", "sides": [1, 0.09]}, "box.sides = [1, 0.09]: must be at least 0.1, twice the range"),
        ({"kind": "duct", "sides": 1.0}, "box.sides = 1.0: must be two positive numbers"),
        (
            {"kind": "duct", "sides": [1, 1], "length": 0.09, "ends": "closed"},
            "box.length = 0.09: must be at least 0.1, twice the range of the walls",
        ),
        ({"kind": "slab", "height": 1, "axis": "x"}, "box.axis: a box of kind slab has no axis; it has fraction"),
    ],
)
def test_each_fault_has_a_line(box, line):
    lines = faults(box)
    assert len(lines) == 1
    assert line in lines[0]


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"steric": None}, "box.fraction = 0.3: refers to cells as wide as the steric core: add [steric]"),
        (
            {"swimmers": [{**CELLS, "count": 10}], "steric": {**STERIC, "range": 0.2}},
            "box.fraction = 0.3: makes a box 1.633 wide; it must be above 3.2, twice the reach of the steric force",
        ),
        (
            {"swimmers": None, "filaments": [FILAMENTS], "surface": SPHERE},
            "box: there are no [[swimmers]] in it",
        ),
        (
            {"swimmers": [{**CELLS, "placement": "rows"}]},
            'swimmers[0].placement = "rows": must be a table { position, direction }, or in a box one of "random",',
        ),
    ],
)
def test_conflicts_with_a_box_are_named(changes, line):
    lines = faults({"kind": "slab", "height": 1.0, "fraction": 0.3}, **changes)
    assert len(lines) == 1 and line in lines[0]


def test_a_named_placement_needs_a_box():
    words = [{**CELLS, "name": f"c{i}", "placement": word} for i, word in enumerate(["random", "polar lanes"])]
    lines = faults(None, swimmers=words)
    assert lines == [
        'swimmers[0].placement = "random": needs a [box] to fill',
        'swimmers[1].placement = "polar lanes": needs a [box] to fill',
    ]


def test_every_fault_of_a_box_is_in_one_message():
    box = {
        "kind": "slab", "height": -1, "fraction": 1.5, "size": [3, 3, 3], "side": "inside", "surface": SPHERE,
        "wall": {"strength": "2000", "range": 0}, "colour": 1,
    }  # fmt: skip
    keys = [line.split(" ")[0].rstrip(":") for line in faults(box)]
    assert sorted(keys) == [
        "box", "box.colour", "box.fraction", "box.height", "box.side", "box.size", "box.surface",
        "box.wall.range", "box.wall.strength",
    ]  # fmt: skip


@pytest.mark.parametrize(
    "box",
    [
        {"kind": "periodic", "size": [3, 4.0, 5]},
        {"kind": "periodic", "fraction": 0.1},
        {"kind": "slab", "height": 0.12, "fraction": 0.3},
        {"kind": "slab", "height": 1, "size": [3, 4], "wall": {"strength": 10, "range": 0.1}},
        {"kind": "slab", "height": 1},
        {"kind": "container", "surface": SPHERE},
        {"kind": "pore", "radius": 1.0, "length": 4.0},
        {"kind": "duct", "sides": [1.0, 2], "axis": "z", "ends": "closed", "length": 3},
        {"kind": "container", "surface": {"kind": "cassini", "a": 3.0, "b": 3.3}, "side": "outside"},
    ],
)
def test_conversion_to_toml_and_back_gives_an_equal_scene(box):
    one = scene(box)
    again = Scene.parse(one.to_toml())
    assert again == one and again.hash() == one.hash() and again.period == one.period
    assert again.to_toml() == one.to_toml()


def test_defaults_are_filled_in():
    slab = scene({"kind": "slab", "height": 1.0})
    assert slab.box == Box(kind="slab", height=1.0, wall={"strength": 2000.0, "range": 0.05})
    assert slab.swimmers[0].placement == "random"
    assert "strength = 2000.0" in slab.to_toml() and 'placement = "random"' in slab.to_toml()
    container = scene({"kind": "container", "surface": SPHERE}).box
    assert container.side == "inside" and container.wall == slab.box.wall
    periodic = scene({"kind": "periodic", "size": [3, 3, 3]}).box
    assert periodic.wall is periodic.side is periodic.height is None
    assert scene(None).swimmers[0].placement is None


def test_the_hash_depends_on_the_content_only():
    box = {"kind": "slab", "height": 1.0, "size": [3.0, 4.0]}
    same = {"wall": {"range": 0.05, "strength": 2000}, "size": (3, 4), "height": 1, "kind": "slab"}
    assert scene(box).hash() == scene(same).hash()
    others = [{"height": 1.5}, {"size": [3, 5]}, {"wall": {"range": 0.06}}]
    hashes = [scene(box | other).hash() for other in others] + [scene(None).hash(), scene(box).hash()]
    assert len(set(hashes)) == len(hashes)


def test_tables_may_be_objects_of_their_classes():
    slab = scene({"kind": "slab", "height": 1.0, "size": [3, 4]})
    again = Scene(swimmers=slab.swimmers, box=slab.box, steric=slab.steric, time=slab.time)
    assert again == slab
    placed = Scene(swimmers=[slab.swimmers[0].model_copy(update={"placement": None})], box=slab.box, time=TIME)
    assert placed.swimmers[0].placement == "random"


def test_periods_follow_from_size_or_fraction():
    """Cells of length 1 and the width of the core fill this fraction of a slab (area) or box (cylinders, volume)."""
    assert scene({"kind": "periodic", "size": [3, 4, 5]}).period == (3, 4, 5)
    assert scene({"kind": "slab", "height": 1, "size": [3, 4]}).period == (3, 4, 0)
    for free in ({"kind": "slab", "height": 1}, {"kind": "container", "surface": SPHERE}, None):
        assert scene(free).period == (0, 0, 0)
    assert scene({"kind": "pore", "radius": 1, "length": 4, "axis": "y"}).period == (0, 4, 0)
    duct = {"kind": "duct", "sides": [1, 2]}
    assert scene({**duct, "length": 4}).period == (4, 0, 0) and scene(duct).period == (0, 0, 0)
    assert scene({**duct, "length": 4, "ends": "closed"}).period == (0, 0, 0)
    two = [CELLS, {**CELLS, "name": "others", "count": 40, "nodes": 33}]
    x, y, z = scene({"kind": "slab", "height": 1, "fraction": 0.3}, swimmers=two).period
    assert x == y and z == 0 and 100 * 0.08 / (x * y) == pytest.approx(0.3, rel=1e-14)
    box = scene({"kind": "periodic", "fraction": 0.1}, swimmers=two).period
    assert 100 * np.pi / 4 * 0.08**2 / np.prod(box) == pytest.approx(0.1, rel=1e-14)
    assert len(set(box)) == 1


def test_sterics_of_zero_strength_define_the_width_of_cells():
    assert scene({"kind": "slab", "height": 1, "fraction": 0.3}, steric={**STERIC, "strength": 0}).period[0] == 4.0

"""The table [sweep] of a scene: what it may have, and what is said of what it may not."""

import math
import re

import numpy as np
import pytest
from examples.study import CELL, TIME, cells, sensors

from warp_rods.errors import SceneError
from warp_rods.scene.scene import Scene
from warp_rods.scene.sweep import _fault_of
from warp_rods.studies.axes import axes_of
from warp_rods.studies.plan import Plan


def scene(sweep: dict, **tables) -> Scene:
    return Scene.parse({"swimmers": [CELL], "time": TIME, "sweep": {"measure": ["speed"], **sweep}, **tables})


RANGE = {"from": 1e-4, "to": 1e-2, "num": 3}
FAULTS = [
    ({}, "sweep: nothing is swept: add a key such as"),
    ({"swimmers.cell.bend": []}, r'sweep."swimmers.cell.bend" = []: must be a list of values, or { from'),
    ({"swimmers.cell.bend": [1e-3, 1e-3]}, "each value must be there once"),
    ({"swimmers.cell.bend": [1, 2, 1.0]}, "each value must be there once, and 1.0 is there again"),
    ({"swimmers.cell.name": ["cell", "other"]}, "the name of an ensemble cannot be swept; it changes"),
    ({"swimmers.cell.bend": [1e-3], "measure": ["speed", "period", "speed"]},
     'sweep.measure[2] = "speed": is there twice: name each measure once'),
    ({"swimmers.cell.bend": 1e-3}, "= 0.001: must be a list of values"),
    ({"swimmers.cell.bend": RANGE | {"num": 1}}, "num a whole number from 2"),
    ({"swimmers.cell.bend": RANGE | {"from": 0, "scale": "log"}}, "from and to two different positive numbers"),
    ({"swimmers.cell.bend": RANGE | {"step": 1}}, "must be a list of values, or { from"),
    ({"swimmers.cells.bend": RANGE}, "no ensemble 'cells' in swimmers (did you mean cell?): there are cell"),
    ({"filaments.cell.length": RANGE}, "no ensemble 'cell' in filaments: the scene has no [[filaments]]"),
    ({"surface.a": RANGE}, "there is no surface in the scene"),
    ({"swimmers.cell.bend.0": RANGE}, "has no parts: the key ends there"),
    ({"swimmers.cell": RANGE}, "is the name of an ensemble: add a key of it"),
    ({"seed.x": RANGE}, "seed cannot be swept; give seeds"),
    ({"bend": RANGE}, "sweep.bend: unknown key; known here: seeds, measure, keep, refine, and keys of the scene"),
    ({"swimmers.cell.bend": [1e-3], "refine": 2}, "refine = 2: only ranges are refined"),
    ({"swimmers.cell.bend": RANGE | {"num": 9999}, "seeds": 9999}, "a grid with 1e+08 places, refined ones included"),
    ({"swimmers.cell.bend": [1e-3], "seeds": 0}, "sweep.seeds = 0: must be a whole number of seeds"),
    ({"swimmers.cell.bend": [1e-3], "seeds": [1, 1]}, "each seed must be there once"),
    ({"swimmers.cell.bend": [1e-3], "measure": []}, "sweep.measure = []: must be a list of names"),
    ({"swimmers.cell.bend": [1e-3], "keep": "all"}, 'sweep.keep = "all": must be "summary" or "trajectory"'),
]  # fmt: skip


@pytest.mark.parametrize(("sweep", "said"), FAULTS)
def test_faults_name_key_value_and_what_is_allowed(sweep, said):
    with pytest.raises(SceneError, match=re.escape(said)):
        scene(sweep)


def test_impossible_values_and_measures_are_found_before_anything_starts():
    with pytest.raises(SceneError, match=r'(?s)sweep."swimmers.cell.bnd" = 1.0: .*unknown key \(did you mean bend'):
        Plan(scene({"swimmers.cell.bnd": [1.0]})).check()
    with pytest.raises(SceneError, match=r'(?s)sweep."swimmers.cell.bend" = -1.0: .*must be a positive number'):
        Plan(scene({"swimmers.cell.bend": [1e-3, -1.0], "swimmers.cell.moment": [0.0]})).check()
    with pytest.raises(SceneError, match=r'sweep.measure\[0\] = "sped": no measure called sped \(did you mean speed'):
        Plan(scene({"swimmers.cell.bend": [1e-3], "measure": ["sped"]})).check()
    with pytest.raises(SceneError, match=r'sweep.measure\[0\] = "gauss": is a measure of filaments, and the scene has'):
        Plan(scene({"swimmers.cell.bend": [1e-3], "measure": ["gauss"]})).check()
    with pytest.raises(SceneError, match=r"sweep: missing; a study needs a table"):
        _ = Plan(Scene.parse({"swimmers": [CELL], "time": TIME})).sweep


def test_ranges_keep_their_values_to_the_bit_when_refined():
    plain, refined = (axes_of(cells({"refine": n}))[0] for n in (0, 3))
    assert refined.values[:: refined.stride] == plain.values and len(refined) == 3 * 8 + 1
    np.testing.assert_allclose(plain.values, np.geomspace(1e-3, 1e-2, 4), rtol=1e-14)
    assert math.isclose(refined.values[4] ** 2, plain.values[0] * plain.values[1])
    line = axes_of(scene({"swimmers.cell.moment": {"from": 0.0, "to": 0.3, "num": 4}}))[0]
    np.testing.assert_allclose(line.values, [0.0, 0.1, 0.2, 0.3])


def test_a_scene_with_a_sweep_is_read_again_from_its_file():
    first = cells({"refine": 1})
    again = Scene.parse(first.to_toml())
    assert again.hash() == first.hash() and dict(again.sweep.axes) == dict(first.sweep.axes)


def test_the_scene_of_a_point_has_its_values():
    point = Plan(cells()).scene_at((1, 2, 1))
    assert point.sweep is None and point.seed == 1
    assert point.swimmers[0].bend == pytest.approx(1e-3 * 10 ** (1 / 3)) and point.swimmers[0].moment == 1e-2
    strain = Plan(sensors()).scene_at((1, 0))
    assert strain.filaments[0].intrinsic == (0.0, 1.0, 0.0) and strain.seed == 3
    nested = scene({"swimmers.cell.flagella.diffusion": [1e-3, 2e-3], "time.tolerance": [0.01, 0.02]})
    found = Plan(nested).scene_at((1, 1, 0))
    assert found.swimmers[0].flagella.diffusion == 2e-3 and found.time.tolerance == 0.02


def test_long_lists_that_differ_at_their_ends_are_values_of_their_own():
    """Their text is cut in messages, not where values are compared, nor in the labels of the store."""
    rows = [[1e-3] * 39 + [last] for last in (1e-3, 2e-3)]
    table = {"swimmers": [CELL | {"count": 40}], "time": TIME}
    axis, _ = axes_of(Scene.parse({**table, "sweep": {"swimmers.cell.bend": rows, "measure": ["speed"]}}))
    assert len(set(axis.labels)) == 2 and axis.labels[1].endswith("0.001, 0.002]")
    assert _fault_of("a.b", ((True, {"c": 1}), (1, {"c": 1}), (1, {"c": 2}))) == ""
    assert "there again" in _fault_of("a.b", ((1, {"c": 1}), (1.0, {"c": 1.0})))


def test_a_range_of_whole_numbers_stays_one():
    nodes = {"swimmers.cell.nodes": {"from": 17, "to": 33, "num": 3}}
    plan = Plan(scene(nodes))
    plan.check()
    assert plan.axes[0].values == (17, 25, 33) and plan.scene_at((1, 0)).swimmers[0].nodes == 25
    halves = axes_of(scene({"swimmers.cell.moment": {"from": 0, "to": 1, "num": 3}}))[0]
    assert halves.values == (0.0, 0.5, 1.0) and all(isinstance(value, float) for value in halves.values)
    for wrong in ({"num": 5, "to": 35}, {"scale": "log"}):
        swept = {"swimmers.cell.nodes": nodes["swimmers.cell.nodes"] | wrong}
        with pytest.raises(SceneError, match=r"list the values, such as \[17, 25, 33\], or give a linear range"):
            Plan(scene(swept)).check()

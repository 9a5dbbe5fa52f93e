"""Named numbers in the formulas of scenes."""

import numpy as np
import pytest

import warp_rods as wr
from warp_rods.errors import SceneError
from warp_rods.formula import with_numbers
from warp_rods.rods.along import Along
from warp_rods.rods.free.motion import Motion
from warp_rods.rods.free.shapes import initial_strain
from warp_rods.rods.outside import Outside
from warp_rods.rods.per_rod import along

SWIMMER = {"name": "worm", "count": 2, "nodes": 17, "bend": 1e-2, "twist": 1e-2}
S = np.linspace(-0.5, 0.5, 17)


def scene(**keys):
    return wr.Scene(swimmers=[SWIMMER | keys], time={"end": 1})


def test_parameters_are_one_number_or_one_for_each_rod():
    made = scene(natural_bend="a*sin(k*s - t)", parameters={"a": 2, "k": [3.0, 4.0]}, bend="1e-2*(1 + a*s**2)")
    assert made.swimmers[0].parameters == {"a": 2.0, "k": (3.0, 4.0)}
    assert wr.Scene.parse(made.to_toml()) == made
    rods = wr.Simulation(made, "cpu").ensembles["worm"]
    expected = [2 * np.sin(k * S) for k in (3, 4)]
    np.testing.assert_allclose(rods.natural_bend[..., 1], expected, rtol=0, atol=1e-15)
    np.testing.assert_allclose(rods.bend, [1e-2 * (1 + 2 * S**2)] * 2, rtol=1e-15)


@pytest.mark.parametrize(("keys", "line"), [
    ({"natural_bend": "a*s"}, 'swimmers[0].natural_bend = "a*s": must be'),
    ({"natural_bend": "a*s"}, "a is not known here; allowed are numbers, pi, s, t,"),
    ({"natural_bend": "b*s", "parameters": {"a": 1.0}}, "b is not known here; allowed are numbers, pi, s, t, a,"),
    ({"natural_bend": "s", "parameters": {"a": 1.0}}, "parameters.a: occurs in none of the formulas here"),
    ({"natural_bend": "s", "parameters": {"sin": 1.0}}, "parameters = { sin = 1.0 }: must be a table of numbers"),
    ({"natural_bend": "s", "parameters": {"t": 1.0}}, '"t" cannot be a name here'),
    ({"natural_bend": "a*s", "parameters": {"a": [1.0] * 3}}, "parameters.a = [1.0, 1.0, 1.0]: needs one entry"),
    ({"ends": ["free", {"kind": "clamped", "motion": ["a*t", 0, 0]}]}, "a is not known here"),
    ({"shape": {"bend": "a*s"}}, "a is not known here; allowed are numbers, pi, s,"),
])  # fmt: skip
def test_faults_name_what_is_allowed(keys, line):
    with pytest.raises(SceneError) as caught:
        scene(**keys)
    assert line in str(caught.value)


def test_parameters_are_known_in_tables_within():
    motion = ["a*t", 0, 0]
    scene(shape={"bend": "a*s"}, parameters={"a": 1.0}, ends=["free", {"kind": "clamped", "motion": motion}])
    with pytest.raises(SceneError, match="not known"):  # those of another table are not
        wr.Scene(
            swimmers=[
                SWIMMER | {"parameters": {"a": 1.0}, "natural_bend": "a*s"},
                SWIMMER | {"name": "b", "bend": "a*s"},
            ],
            time={"end": 1},
        )


def test_each_formula_of_a_rod_has_its_own_numbers():
    named = {"k": np.array([3.0, 4.0])}
    one = Along("x", "sin(k*s) + t", 2, 17, "any finite number", in_time=True, named=named)
    two = Along("x", ["sin(k*s) + t", "k"], 2, 17, "any finite number", in_time=True, named=named)
    np.testing.assert_array_equal(one.at(2.0), [np.sin(3 * S) + 2, np.sin(4 * S) + 2])
    np.testing.assert_array_equal(two.at(2.0), [np.sin(3 * S) + 2, np.full(17, 4.0)])
    assert one.varies


def test_shapes_motions_flows_and_forces_have_them():
    named = {"k": np.array([3.0, -4.0])}
    np.testing.assert_allclose(along("x", "k*s**2", S, named), [3 * S**2, -4 * S**2], rtol=1e-15)
    strain = initial_strain({"bend": "k*cos(pi*s)"}, 17, {"bend": np.ones(2), "moment": np.zeros(2)}, named=named)
    np.testing.assert_allclose(strain[:, 8, 2], [3.0, -4.0], rtol=1e-15)
    motion = Motion("m", ["k*t", "t", 0.0], named, True)
    np.testing.assert_allclose(motion(2.0), [[6, 2, 0], [-8, 2, 0]], rtol=1e-15)
    flow = {"kind": "formula", "velocity": ["U*y", 0.0, 0.0], "parameters": {"U": -2.0}}
    found = Outside(flow, None, [{"force": ["g*x**2", 0, 0], "parameters": {"g": -2.0}}], 1)
    assert found._profile == ("-2.0 * y", "0.0", "0.0")
    assert found._tables[0].texts[0] == "-2.0 * x ** 2"
    with pytest.raises(SceneError, match="not known here; allowed are numbers, pi, x, y, z, t, U"):
        Outside(flow | {"velocity": ["V*y", "U*y", 0.0]}, None, None, 1)


def test_numbers_in_place_of_names_keep_their_powers():
    assert with_numbers("2*k**2 - k", {"k": -3.0}) == "2 * (-3.0) ** 2 - -3.0"


def test_filaments_have_them():
    surface = wr.surfaces.make("sphere", {"radius": 1.0})
    place = {"position": [[1.0, 0, 0]] * 2, "direction": [[0.0, 1, 0]] * 2, "nodes": 17, "device": "cpu"}
    rods = wr.BoundRods(
        surface, **place, intrinsic=(0, "k*(1 + s)", "a"), parameters={"k": [1.0, 2.0], "a": 0.5},
        geodesic_curvature="k*s*(1/4 - s**2)",
    )  # fmt: skip
    np.testing.assert_allclose(rods.intrinsic[..., 1], [1 + S, 2 * (1 + S)], rtol=1e-15)
    np.testing.assert_allclose(rods.intrinsic[..., 2], 0.5, rtol=1e-15)
    filament = {"name": "f", "count": 2, "nodes": 17, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 1, 1]}
    filament |= {"intrinsic": ["k*s", 0, 0], "parameters": {"k": 2.0}}
    made = wr.Scene(surface={"kind": "sphere", "radius": 1}, filaments=[filament], time={"end": 1})
    assert wr.Scene.parse(made.to_toml()) == made


def test_a_number_of_a_flow_or_force_may_be_an_exponent():
    flow = {"kind": "formula", "velocity": ["y**a", 0, 0], "parameters": {"a": 2.0}}
    assert Outside(flow, None, None, 1).flow.formulas[0] == "y ** 2.0"
    with pytest.raises(SceneError, match="b is not known here"):
        Outside(flow | {"velocity": ["y**b", 0, 0]}, None, None, 1)
    with pytest.raises(SceneError, match="parameters"):
        Outside(flow | {"velocity": ["y**2", 0, 0]}, None, None, 1)

"""Quantities with a unit in scenes, and swimmers with a body in SI."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

import warp_rods as wr
from warp_rods.errors import SceneError
from warp_rods.membranes.built_in import SURFACES
from warp_rods.quantities import Dimension, QuantityError, is_quantity, parse, with_prefixes
from warp_rods.scene import box, cosserat, ends, filaments, flagella, outside, shapes, swimmers, tables
from warp_rods.scene.behaviour import BEHAVIOURS
from warp_rods.scene.body import drag_of_rod
from warp_rods.scene.dimensions import DIMENSIONS, in_scene_units
from warp_rods.scene.units import Scale
from warp_rods.theory import stability

SCENES = Path(__file__).parents[2] / "scenes"
UNITS = {"length": "1 um", "time": "10 ms", "force": "2 pN"}
FILAMENTS = {
    "name": "f",
    "count": 2,
    "nodes": 17,
    "length": ["0.5 um", "400 nm"],
    "stiffness": ["4e-24 N m^2", 2.0, "2 pN um^2"],
    "drag": ["2 mPa s", 2, "1e-20 N s"],
    "intrinsic": [0, "3 um^-1", "sin(s)"],
    "growth": {"rate": "1 um/s", "until": 1},
}


def test_quantities_are_numbers_in_the_units_of_the_scene():
    scene = wr.Scene(
        units=UNITS,
        surface={"kind": "torus", "major": "1000 nm", "minor": 0.4},
        filaments=[FILAMENTS],
        steric={"strength": "1 pN", "range": "20 nm", "core": 0.08},
        time={"end": "2 s", "save_every": "0.5 s"},
        gravity={"force": ["0.5 pN/um", 0, 0]},
        flow={"kind": "shear", "rate": "5 Hz", "centre": ["1 um", 0, 0]},
    )
    filament = scene.filaments[0]
    assert filament.length == (0.5, 0.4) and filament.growth.rate == 0.01
    assert filament.stiffness == (2.0, 2.0, 1.0) and filament.intrinsic == (0, 3.0, "sin(s)")
    assert filament.drag == pytest.approx((0.1, 2, 5e-7), rel=1e-15)
    assert scene.surface.parameters == {"major": 1.0, "minor": 0.4}
    assert (scene.steric.strength, scene.steric.range, scene.time.end, scene.time.save_every) == (0.5, 0.02, 200, 50)
    assert scene.gravity.force == (0.25, 0, 0) and scene.flow.values["rate"] == 0.05
    again = wr.Scene.parse(scene.to_toml())
    assert again == scene and again.hash() == scene.hash()


BASE = {"swimmers": [{"name": "c", "count": 1, "nodes": 17, "bend": 1e-2, "twist": 1e-2}], "time": {"end": 1}}
BODY = {"length": "20 um", "diameter": "0.8 um", "viscosity": "1 mPa s", "speed": "25 um/s", "drag": "cylinder"}


def cell(**keys):
    return {"swimmers": [BASE["swimmers"][0] | keys], "units": UNITS}


@pytest.mark.parametrize(("change", "line"), [
    ({"time": {"end": "5 um"}, "units": UNITS}, 'time.end = "5 um": is a length, in m; must be a time, in s'),
    ({"time": {"end": "5 s"}}, 'time.end = "5 s": needs the unit of time of the scene: add time = "1 s" to [units]'),
    ({"time": {"end": "5 s"}, "units": {"length": "1 m"}}, 'time.end = "5 s": needs the unit of time'),
    ({"time": {"end": "5 blurbs"}, "units": UNITS}, "time.end = \"5 blurbs\": 'blurbs' is not defined"),
    ({"time": {"end": "5 K"}, "units": UNITS}, "K is no unit of length, time and force"),
    ({"time": {"end": "1e-50 s"}, "units": UNITS}, "time.end = 1e-48: must be a positive number"),
    ({"seed": "5 um", "units": UNITS}, 'seed = "5 um": must be a whole number'),
    ({"units": {"length": "1 s"}}, "units.length = \"1 s\": must be a positive number and a unit of length"),
    ({"units": UNITS | {"force": "1 J"}}, "it is a couple, in N m"),
    (cell(ends=[{"kind": "clamped", "turning": "10 Hz"}, "free"]), 'turning = "10 Hz": a rate of rotation must be in'),
    (
        {"swimmers": cell(body=BODY | {"diameter": "15 um"}, ends=["free", {"thrust": "1 pN"}])["swimmers"]},
        "swimmers[0].body.diameter",
    ),
    ({"time": {"end": "5 m^0"}, "units": UNITS}, "time.end = "),
])  # fmt: skip
def test_mistakes_in_quantities_are_named_once(change, line):
    with pytest.raises(SceneError) as caught:
        wr.Scene(**BASE | change)
    lines = str(caught.value).splitlines()
    assert len(lines) == 2 and line in lines[1]


def with_body(body=None, **keys):
    table = BASE["swimmers"][0] | {"body": BODY | (body or {})}
    return wr.Scene(**BASE | {"swimmers": [table | keys.pop("swimmer", {})]} | keys)


@pytest.mark.parametrize(("body", "keys", "line"), [
    ({"speed": None}, {}, "body: speed or thrust: one follows from the other; give one of them"),
    ({"thrust": "1 pN"}, {}, "body: speed or thrust: one follows"),
    ({"diameter": "15 um"}, {}, 'body.diameter = "15 um": the length must be at least 2 diameters'),
    ({"viscosity": "1 s"}, {}, "must be a viscosity in quotes, such as \"1 mPa s\"; it is a time, in s"),
    ({}, {"units": {"length": "1 um"}}, "swimmers have the length 1, and units.length is 1e-06 m: leave [units] out"),
    ({}, {"units": {"length": "20 um", "time": "1 s"}}, 'units.time = "1 s": ζ∥L/f* of the swimmers is 0.8 s'),
])  # fmt: skip
def test_mistakes_in_bodies_are_named(body, keys, line):
    with pytest.raises(SceneError) as caught:
        with_body(body, **keys)
    assert line in str(caught.value)


@pytest.mark.parametrize(("ratio", "eta"), [(10, 1.39), (20, 1.48), (100, 1.62)])
def test_drag_of_cylinders(ratio, eta, verified):
    drag = drag_of_rod(1.0, 1 / ratio)
    verified(
        "published",
        f"ζ⊥/ζ∥ of a cylinder, L/d = {ratio}",
        measured=drag.across / drag.along,
        expected=eta,
        within=5e-3,
        reference="Tirado and García de la Torre 1979",
    )
    large = drag_of_rod(2e-5, 2e-5 / ratio, 3e-3)
    np.testing.assert_allclose(large, [3e-3 * drag.along, 3e-3 * drag.across, 3e-3 * 4e-10 * drag.about], rtol=1e-14)


def test_drag_of_very_thin_rods():
    """Both laws meet; the drag about the axis is that of Tirado and García de la Torre, 3.841/4 of the infinite one."""
    thin, slender = drag_of_rod(1.0, 1e-100), drag_of_rod(1.0, 1e-100, law="slender")
    np.testing.assert_allclose(thin[:2], slender[:2], rtol=4e-3)
    assert slender.across == 2 * slender.along
    assert drag_of_rod(1, 1e-6).about / (math.pi * 1e-12) == pytest.approx(3.841 / 4, rel=1e-5)
    critical = stability.physical_critical_stiffness(2e-5, 1e-6, 1e-3, 13e-6)
    drag = drag_of_rod(2e-5, 1e-6, 1e-3, "slender").along
    assert critical == pytest.approx(stability.CRITICAL_STIFFNESS * drag * 13e-6 * 8e-15, rel=1e-14)
    with pytest.raises(SceneError, match="at least 2 diameters"):
        drag_of_rod(1.0, 0.6)
    with pytest.raises(SceneError, match="must be one of slender, cylinder"):
        drag_of_rod(1.0, 0.1, law="sphere")


def test_groups_of_a_bacterium_by_hand():
    """p = 25: ζ∥ = 2πμ/(ln 25 − 0.207 + 0.980/25 − 0.133/25²) = 2.059478e-3 N s/m²; f*L = ζ∥ · 25e-6 · 20e-6."""
    scene = wr.Scene.load(SCENES / "bacterium.toml")
    cell = scene.swimmers[0]
    drag = 2 * math.pi * 1e-3 / (3.2188758 - 0.207 + 0.0392 - 0.0002128)
    across = 4 * math.pi * 1e-3 / (3.2188758 + 0.839 + 0.0074 + 0.0003728)
    about = 3.841 * math.pi * 1e-3 * 0.16e-12 * (1 + 0.02708 - 0.0002928)
    force = drag * 25e-6 * 20e-6
    assert cell.bend == pytest.approx(2e-24 / (force * 4e-10), rel=1e-7)
    assert cell.twist == pytest.approx(1e-24 / (force * 4e-10), rel=1e-7)
    assert cell.drag_ratio == pytest.approx(across / drag, rel=1e-7)
    assert cell.rotational_drag == pytest.approx(about / (drag * 4e-10), rel=1e-7)
    assert scene.time.end == pytest.approx(8.0, rel=1e-15) and scene.time.save_every == pytest.approx(0.05, rel=1e-15)
    assert scene.units.length == "20 um" and float(parse(scene.units.time).value) == pytest.approx(20 / 25, rel=1e-15)
    again = wr.Scene.parse(scene.to_toml())
    assert again == scene and again.hash() == scene.hash()


def test_thrust_is_as_good_as_speed_and_other_cells_have_drags_of_their_own():
    force = with_body().swimmers[0].body.force
    thrust = {"speed": None, "thrust": f"{force!r} N"}
    assert with_body(thrust).swimmers[0].rotational_drag == with_body().swimmers[0].rotational_drag
    assert with_body(swimmer={"drag_ratio": 2.0}).swimmers[0].drag_ratio == 2.0
    cells = [BASE["swimmers"][0] | {"name": name, "body": BODY | thrust | own}
             for name, own in (("a", {}), ("b", {"viscosity": "3 mPa s"}))]  # fmt: skip
    a, b = wr.Scene(**BASE | {"swimmers": cells}).swimmers
    assert a.drag_along is None and b.drag_along == pytest.approx(3.0, rel=1e-14)
    assert b.rotational_drag == pytest.approx(3 * a.rotational_drag, rel=1e-14) and b.drag_ratio == pytest.approx(
        1.5008001459875808, rel=1e-14
    )
    cells[1]["body"] |= {"length": "30 um"}
    with pytest.raises(SceneError, match=r'swimmers\[1\]\.body\.length = "30 um": swimmers have the length 1'):
        wr.Scene(**BASE | {"swimmers": cells})


def test_units_of_variables_are_those_of_si():
    scale = Scale.of(UNITS)
    assert scale.in_si("force*length^2/time") == "2e-22 N m^2/s"
    assert scale.in_si("1/length^2") == "1000000000000.0 1/m^2"
    assert scale.in_si("1") == "1" and Scale.of({"length": "1 um"}).in_si("length/time") == "length/time"
    assert Scale.read("length 1 um, time 10 ms, force 2 pN") == scale and Scale.read("dimensionless").units == {}


@pytest.mark.parametrize("text", ["3*s", "1e5", "2*sin(3*t)", "um", "4 m^9999", "1e9999 m", "5 m)", "7"])
def test_formulas_and_numbers_are_no_quantities(text):
    assert not is_quantity(text)
    with pytest.raises(QuantityError):
        parse(text)


def test_angles_and_rates_of_rotation():
    tumble = {"tumble": {"rate": 1, "duration": 0.1, "turn": "68 deg"}}
    ends = [{"kind": "clamped", "turning": "60 rpm"}, {"kind": "free"}]
    made = wr.Scene(**BASE | cell(flagella={"law": "driven"}, behaviour=tumble, ends=ends)).swimmers[0]
    assert made.behaviour.behaviours["tumble"]["turn"] == pytest.approx(np.radians(68), rel=1e-15)
    assert made.ends[0].turning == pytest.approx(2 * np.pi * 0.01, rel=1e-15)
    made = wr.Scene(**BASE | cell(ends=[{"kind": "clamped", "turning": "3 rad/s"}, "free"])).swimmers[0]
    assert made.ends[0].turning == pytest.approx(0.03, rel=1e-15)


@pytest.mark.parametrize("product", ["1/length^0.5", "length^1e400", "1^2", "length^99", "bananas/time"])
def test_products_that_are_no_units_stay_as_they_are(product):
    assert Scale.of(UNITS).in_si(product) == product


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("a", 1), r"length = 'a': must be a number"),
        ((2, None), r"diameter = None: must be a number"),
        ((1, 1), r"length = 1: must be at least 2 diameters"),
        ((9, 1, -1), r"viscosity = -1: must be positive"),
        ((9, 1, 1, "thick"), r"law = 'thick': must be one of slender, cylinder"),
    ],
)
def test_impossible_rods_have_no_drag(given, said):
    with pytest.raises(SceneError, match=said):
        drag_of_rod(*given)


def test_powers_and_products_of_units():
    assert parse("1 mPa s") == parse("1e-3 N*s/m**2") and parse("2e-23 N m^2").dimension == Dimension(2, 0, 1)
    assert parse("1 µm") == parse("1 μm") == parse("1 um")


WITHOUT = {
    "body",
    "bodies",
    "at",
    "direction",
    "kind",
    "ends",
    "placement",
    "shape",
    "growth",
    "flagella",
    "symmetric",
    "name",
    "count",
    "nodes",
    "drag_ratio",
    "profile",
    "law",
    "mode",
    "amplitude",
    "stretch",
    "perturbation",
    "balanced",
    "points",
    "run",
    "frame",
    "time",
    "worm",
    "branch",
    "ensemble",
    "rod",
    "smoothing",
    "reverse",
    "tolerance",
    "usd",
    "poster",
    "film",
    "variables",
    "frames_per_file",
    "fraction",
    "surface",
    "side",
    "axis",
    "behaviour",
    "wall",
    "on",
    "file",
    "periodic",
    "coupling",
}
"""Keys that are no quantities, or whose table has them."""


@pytest.mark.parametrize(
    ("prefix", "table"),
    [
        ("time", tables.Time),
        ("steric", tables.Steric),
        ("box", box.Box),
        ("box.wall", box.Wall),
        ("output", tables.Output),
        ("gravity", outside.Gravity),
        ("forces", outside.ForceTable),
        ("filaments", filaments.FilamentsTable),
        ("filaments.placement", filaments.Placement),
        ("filaments.growth", filaments.GrowthTable),
        ("filaments.shape", shapes.FilamentShape),
        ("swimmers", swimmers.SwimmersTable),
        ("swimmers.ends", ends.EndTable),
        ("swimmers.ends.motion", ends.MotionTable),
        ("swimmers.placement", swimmers.FreePlacement),
        ("swimmers.shape", shapes.ShapeTable),
        ("swimmers.flagella", flagella.FlagellaTable),
        ("swimmers.natural_bend", swimmers.NaturalBend),
        ("cosserat", cosserat.CosseratTable),
        ("cosserat.placement", cosserat.CosseratPlacement),
        ("cosserat.shape", cosserat.CosseratShape),
    ],
)
def test_every_key_has_a_dimension_or_none(prefix, table):
    unknown = [key for key in table.model_fields if f"{prefix}.{key}" not in DIMENSIONS and key not in WITHOUT]
    assert not unknown, "add them to DIMENSIONS, or to WITHOUT here"


def test_every_parameter_of_a_surface_has_a_dimension():
    names = {key for row in SURFACES.values() for key in row.parameters}
    assert "wavenumber" in names
    assert not [key for key in names for where in ("", "box.") if f"{where}surface.{key}" not in DIMENSIONS]


def test_every_parameter_of_a_behaviour_has_a_dimension():
    keys = [(name, key) for name, row in BEHAVIOURS.items() for key in row.parameters]
    assert keys
    assert not [f"{name}.{key}" for name, key in keys if f"swimmers.behaviour.{name}.{key}" not in DIMENSIONS]


def test_shipped_scenes_have_no_quantity_that_is_left():
    made = tomllib.loads(wr.Scene.load(SCENES / "bacterium.toml").to_toml())
    made.pop("units")
    made["swimmers"][0].pop("body")
    assert not [value for value in str(made).split("'") if is_quantity(value) and value != made["title"]]


@pytest.mark.parametrize("text", ["0.5 1/um", "0.5/um", "0.5 /um", "0.5 um^-1"])
def test_inverse_units_are_read_however_they_are_written(text):
    assert parse(text) == parse("5e5 m^-1")


def test_a_formula_over_the_arc_length_is_no_quantity():
    units = {"length": "1 um", "time": "1 s"}
    cell = {"natural_bend": "0.5/s", "natural_twist": "0.5/um", "behaviour": {"tumble": {"rate": "30 /min"}}}
    tables, faults = in_scene_units({"units": units, "swimmers": (cell,)})
    assert not faults and tables["swimmers"][0]["natural_bend"] == "0.5/s"
    assert tables["swimmers"][0]["natural_twist"] == 0.5
    assert tables["swimmers"][0]["behaviour"]["tumble"]["rate"] == 0.5


def test_the_amplitude_of_an_undulated_membrane_is_an_area():
    given = {"units": {"length": "1 um"}, "surface": {"kind": "undulated", "amplitude": "0.2 um^2"}}
    assert in_scene_units(given)[0]["surface"]["amplitude"] == pytest.approx(0.2)
    given["surface"]["amplitude"] = "200 nm"
    assert "is a length, in m; must be in m^2" in in_scene_units(given)[1][0][1]


def test_keys_that_take_no_unit_say_so():
    given = {"units": {"length": "1 um"}, "swimmers": ({"shape": {"amplitude": "2 um"}},)}
    assert "is a length, in m; must be a number" in in_scene_units(given)[1][0][1]


@pytest.mark.parametrize(
    ("number", "unit", "expected"),
    [
        (1e-6, "m", (1, "µm")),
        (1e12, "1/m^2", (1, "1/µm^2")),
        (1e-18, "m^3", (1, "µm^3")),
        (1e-12, "N", (1, "pN")),
        (1e-18, "N m", (1, "pN µm")),
        (2e-6, "m/s", (2, "µm/s")),
        (2e-22, "N m^2/s", (200, "pN µm^2/s")),
        (1.0, "s", (1, "s")),
        (1e30, "m", (1e30, "m")),
    ],
)
def test_units_have_the_prefixes_that_make_numbers_small(number, unit, expected):
    assert with_prefixes(number, unit) == expected

"""The table of measures: its entries are correct, and one function with one signature computes all of them."""

import re

import numpy as np
import pytest
import xarray as xr

import warp_rods as wr
from warp_rods.analysis.described import described
from warp_rods.analysis.listing import MEMBRANE, Measure
from warp_rods.analysis.registry import MEASURES
from warp_rods.errors import RunFolderError
from warp_rods.rods import modes
from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner

PLACES = {"position": [[0, 0, 0], [0.1, 0.2, 0.1], [1, 1, 1]]}
SWIMMER = {"count": 3, "nodes": 17, "twist": 1e-3, "moment": 2e-3, "placement": PLACES}
GROWTH = {"rate": 0.5, "until": 1.0}
FILAMENT = {
    "count": 3, "nodes": 9, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1], "growth": GROWTH
}  # fmt: skip
SCENE = {
    "surface": {"kind": "torus", "major": 1.0, "minor": 0.4},
    "swimmers": [{"name": "soft", "bend": 1e-3, **SWIMMER}, {"name": "stiff", "bend": 1e-2, **SWIMMER}],
    "filaments": [{"name": "sensors", **FILAMENT}],
    "time": {"end": 0.12, "step": 1e-3, "save_every": 0.01},
}


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> xr.DataTree:
    return runner.simulate(Scene.parse(SCENE), tmp_path_factory.mktemp("run") / "mixed", device="cpu").data.load()


@pytest.fixture(params=["soft", "sensors"])
def group(run, request) -> xr.Dataset:
    return run[request.param].to_dataset()


def test_every_measure_applies_to_some_ensemble(run):
    assert {name for group in ("soft", "sensors") for name in wr.measures(run[group])} == set(MEASURES)
    assert {row.of for row in wr.measures(run["soft"]).values()} == {"rods", "swimmers", "swarm"}
    assert {row.of for row in wr.measures(run["sensors"]).values()} == {"rods", "filaments", "swarm"}


def test_units_and_descriptions_agree_with_the_table(group):
    for name, row in wr.measures(group).items():
        found = wr.measure(group, name)
        first = next(iter(found.values()))
        allowed = ("1/length^2", "1/length^3") if row.units == "1/length^d" else (row.units,)
        assert first.attrs["units"] in allowed, name
        for variable in found.values():
            assert variable.attrs.keys() >= {"units", "long_name", "source"}, name
            assert variable.attrs["measure"] == name
        assert 8 < len(row.description) < 60 and not row.description.endswith((".", ")")), name


def test_needs_are_necessary_and_sufficient(group):
    """A measure can be computed from them alone; without any of them the message names the missing one."""
    for name, row in wr.measures(group).items():
        needs = [need for need in row.needs if need != MEMBRANE]
        assert wr.measure(group[needs], name)
        for need in needs:
            with pytest.raises(ValueError, match=rf"{name}: the group has no {need}; it has "):
                wr.measure(group.drop_vars(need), name)
            assert name not in wr.measures(group.drop_vars(need))


def test_measures_do_not_depend_on_each_other(group):
    names = list(wr.measures(group))
    together = wr.measure(group, *names)
    for name in names:
        for variable, alone in wr.measure(group, name).items():
            both = together[variable].dropna("r", how="all") if "r" in alone.dims else together[variable]
            assert both.attrs == alone.attrs
            np.testing.assert_array_equal(both, alone.dropna("r", how="all") if "r" in alone.dims else alone)


def test_options_go_to_the_measures_that_accept_them(run):
    soft = run["soft"]
    found = wr.measure(soft, "speed", "writhe", "mode_coefficients", since=0.05, count=2)
    assert found.sizes["mode"] == 2
    late = wr.measure(soft.to_dataset().isel(frame=slice(5, None)), "speed")
    np.testing.assert_array_equal(found.speed, late.speed)
    with pytest.raises(
        ValueError, match=r"sinc: not an option of speed, writhe.*speed takes since, until; writhe takes none"
    ):
        wr.measure(soft, "speed", "writhe", sinc=0.05)
    with pytest.raises(ValueError, match="surface: not an option of settling_time"):
        wr.measure(run["sensors"], "settling_time", surface=None)


def test_a_run_is_a_swarm_of_all_its_swimmers(run):
    whole = wr.measure(run, "polar_order", "crossings")
    xr.testing.assert_identical(whole, wr.measure(wr.swarm.together(run), "polar_order", "crossings"))
    assert whole.polar_order.attrs["isotropic"] == pytest.approx(1 / np.sqrt(6))
    assert {row.of for row in wr.measures(run).values()} == {"swarm"}
    one = xr.DataTree.from_dict({"stiff": run["stiff"].to_dataset()})
    xr.testing.assert_identical(wr.measure(one, "speed"), wr.measure(run["stiff"], "speed"))
    with pytest.raises(
        ValueError, match=r"speed: a measure of one ensemble: give run\['sensors'\] or another of soft, stiff"
    ):
        wr.measure(run, "polar_order", "speed")


def test_a_run_of_filaments_alone_is_a_swarm_of_all_of_them(run):
    """As one ensemble of filaments is; not of ensembles with different numbers of nodes."""
    sensors = run["sensors"].to_dataset()
    one, two = (xr.DataTree.from_dict(dict.fromkeys(names, sensors)) for names in ("a", "ab"))
    expected = wr.measure(one, "polar_order").polar_order
    np.testing.assert_allclose(wr.measure(two, "polar_order").polar_order, expected)
    assert "polar_order" in wr.measures(two) and "shape_shares" not in wr.measures(two)
    other = xr.DataTree.from_dict({"a": sensors, "b": sensors.isel(node=slice(None, None, 2))})
    assert "polar_order" not in wr.measures(other)
    with pytest.raises(ValueError, match="polar_order: a, b have different numbers of nodes"):
        wr.measure(other, "polar_order")


def test_the_membrane_comes_from_the_scene(run):
    sensors = run["sensors"].to_dataset()
    found = wr.measure(sensors, "enrichment", "settling_time")
    torus = wr.surfaces.make("torus", {"major": 1.0, "minor": 0.4})
    xr.testing.assert_identical(found, wr.measure(sensors, "enrichment", "settling_time", surface=torus))
    xr.testing.assert_identical(found, wr.sensing.measure(sensors, torus, "enrichment", "settling_time"))
    assert wr.sensing.membrane_of(sensors).values == torus.values == wr.sensing.membrane_of(run).values
    thin = wr.measure(sensors, "enrichment", surface=wr.surfaces.make("torus", {"major": 1.0, "minor": 0.1}))
    assert not np.allclose(thin.area_share, found.area_share)
    moving = sensors.assign_attrs(scene=sensors.attrs["scene"].replace("minor = 0.4", 'minor = "0.4 + t"'))
    with pytest.raises(ValueError, match=r"this membrane moves: give surface\.at\(t\)"):
        wr.measure(moving, "enrichment")
    still = wr.measure(moving, "enrichment", surface=wr.sensing.membrane_of(moving).at(0.0))
    np.testing.assert_allclose(still.area_share, found.area_share)


def test_without_a_membrane(run):
    sensors = run["sensors"].to_dataset().drop_attrs()
    assert "enrichment" not in wr.measures(sensors) and "settling_time" in wr.measures(sensors)
    with pytest.raises(ValueError, match=r"enrichment: needs the membrane, .* give surface="):
        wr.measure(sensors, "enrichment")
    with pytest.raises(ValueError, match="open the run with open_run"):
        wr.sensing.membrane_of(sensors)
    bare = sensors.assign_attrs(
        scene=Scene.parse({k: v for k, v in SCENE.items() if k in ("swimmers", "time")}).to_toml()
    )
    assert "enrichment" not in wr.measures(bare)
    with pytest.raises(RunFolderError, match=r"no \[surface\]"):
        wr.sensing.membrane_of(bare)


def test_mistakes_are_named(run):
    with pytest.raises(
        ValueError, match=r"no measure called wirthe \(did you mean writhe\?\): there are mode_coefficients, "
    ):
        wr.measure(run["soft"], "wirthe")
    with pytest.raises(ValueError, match=r"measures\(data\) lists"):
        wr.measure(run["soft"])
    with pytest.raises(ValueError, match="data: str; give one ensemble or a run"):
        wr.measure("runs/proteins", "speed")
    with pytest.raises(ValueError, match="settling_time: a measure of filaments, and these are swimmers"):
        wr.measure(run["soft"], "settling_time")

    for wrong in (["speed"], 5, None):
        with pytest.raises(ValueError, match="no measure called"):
            wr.measure(run["soft"], wrong)
        with pytest.raises(ValueError, match="no measure called"):
            wr.plot(run["soft"], wrong)
    with pytest.raises(ValueError, match="surface = 'torus': must be a Surface"):
        wr.measure(run["sensors"], "enrichment", surface="torus")
    with pytest.raises(ValueError, match="data: int; give one ensemble or a run"):
        wr.measures(5)


def test_variables_and_names_of_studies_are_told_from_measures():
    """Whoever asks for a variable hears where it is, and for a name of studies the other one."""
    one = xr.Dataset({"gauss": (("frame", "rod"), np.zeros((2, 1)))})
    with pytest.raises(ValueError, match=r'no measure called gauss: it is a variable: data\["gauss"\]'):
        wr.measure(one, "gauss")
    with pytest.raises(ValueError, match=r'no measure called gauss: it is a variable: data\["a"\]\["gauss"\]'):
        wr.measure(xr.DataTree.from_dict({"a": one}), "gauss")
    with pytest.raises(ValueError, match="no measure called class, its name in a study: shape_class"):
        wr.measure(one, "class")


def assert_listed_measures_can_be_computed(data) -> set[str]:
    """And those that are not listed, although they have all they need, are refused or have no value."""
    listed = set(wr.measures(data))
    for name, row in wr.measures().items():
        try:
            found = wr.measure(data, name)
        except ValueError:
            assert name not in listed, name
            continue
        empty = all(np.isnan(values).all() for values in found.values() if values.dtype.kind == "f")
        assert name in listed or (row.conditions and empty), name
    return listed


@pytest.mark.parametrize("frames", [1, 2, 3, 5, 13])
@pytest.mark.parametrize("name", ["soft", "sensors", ""])
def test_measures_lists_what_can_be_computed(run, name, frames):
    data = run[name].to_dataset() if name else run
    listed = assert_listed_measures_can_be_computed(data.isel(frame=slice(frames)))
    assert ("mean_speed" in listed) == (frames >= 2)
    assert ("mean_square_displacement" in listed) == (frames >= 3)


def test_measures_know_distances_boxes_growth_and_moving_membranes(run):
    soft, sensors = run["soft"].to_dataset(), run["sensors"].to_dataset()
    heap = soft.assign(position=soft.position - soft.position.isel(node=8))
    assert "pair_correlation" not in assert_listed_measures_can_be_computed(heap)
    narrow = soft.assign(period=soft.period.copy(data=[1.5, 1.5, 1.5]))
    assert "local_polar_order" not in assert_listed_measures_can_be_computed(narrow)
    constant = sensors.assign(length=sensors.length * 0 + 0.5)
    assert "energy_per_length" not in assert_listed_measures_can_be_computed(constant)
    assert "energy_per_length" in assert_listed_measures_can_be_computed(sensors)
    moving = sensors.assign_attrs(scene=sensors.attrs["scene"].replace("minor = 0.4", 'minor = "0.4 + t"'))
    assert "enrichment" not in assert_listed_measures_can_be_computed(moving)
    assert set(wr.measures(sensors.isel(frame=slice(0)))) == set()


def test_the_table_is_printed(monkeypatch):
    for columns in (60, 80, 100, 120, 200):
        monkeypatch.setenv("COLUMNS", str(columns))
        lines = repr(wr.measures()).splitlines()
        assert max(map(len, lines)) <= max(columns, 80)
        assert [line for line in lines if not line.startswith(" ")][1:] == [
            "rods of any kind", "swimmers", "filaments", "all rods together"
        ]  # fmt: skip
        text = " ".join(" ".join(lines).split())
        assert all(name in text and row.units in text for name, row in MEASURES.items())
    assert any(
        re.fullmatch(r"  speed +length/time +Swimming speed from start to end +position, 2 frames", line)
        for line in lines
    )
    markup = wr.measures()._repr_html_()
    assert markup.count("<tr>") == len(MEASURES) + 1 and "force*length" in markup


def test_a_user_defined_measure(run, monkeypatch):
    def reach(dataset: xr.Dataset, node: int = -1) -> xr.DataArray:
        """Largest coordinate of a node (frame, rod)."""
        values = abs(dataset["position"].isel(node=node)).max("axis")
        return described(dataset, ("frame", "rod"), values.to_numpy(), "length", "reach", "max |r_i|")

    monkeypatch.setitem(MEASURES, "reach", Measure(reach, "rods", "length", ("position",)))
    monkeypatch.setenv("COLUMNS", "120")
    assert "Largest coordinate of a node" in repr(wr.measures())
    found = wr.measure(run["soft"], "reach", node=0)
    np.testing.assert_array_equal(found.reach, abs(run["soft"].position[:, :, 0]).max("axis"))


@pytest.mark.parametrize("name", ["soft", "sensors"])
def test_failed_rods_are_left_out_of_every_measure_in_the_same_way(run, name, caplog):
    """As if they were not there, whatever their values; NaN or "failed" in measures of single rods, and said."""
    group = run[name].to_dataset()
    status = group.status.copy(deep=True)
    status[4:, 1] = 1
    broken = {key: values.copy(deep=True) for key, values in group.data_vars.items() if "rod" in values.dims}
    for values in broken.values():
        if values.dtype.kind == "f" and "frame" in values.dims:
            values.loc[{"rod": 1, "frame": slice(6, None)}] = np.nan
    failed, others = group.assign(broken | {"status": status}), group.isel(rod=[0, 2])
    for measure in wr.measures(group):
        caplog.clear()
        found, expected = wr.measure(failed, measure), wr.measure(others, measure)
        assert caplog.messages == [f"{measure}: failed rods 1 are left out"]
        for variable, values in found.data_vars.items():
            assert values.attrs["left_out"] == "failed rods 1"
            kept = values
            if "rod" in values.dims:
                assert found.rod.values.tolist() == [0, 1, 2]
                one = values.sel(rod=1)
                assert (one == "failed").all() if values.dtype.kind in "UO" else one.isnull().all()
                kept = values.sel(rod=[0, 2])
            np.testing.assert_array_equal(kept.values, expected[variable].values, err_msg=measure)
        assert "left_out" not in next(iter(expected.values())).attrs
    early = wr.measure(failed.isel(frame=slice(4)), "writhe")
    np.testing.assert_array_equal(early.writhe, wr.measure(group, "writhe").writhe[:4])
    with pytest.raises(ValueError, match=r"all rods failed: nothing is left .* select earlier frames"):
        wr.measure(group.assign(status=status * 0 + 1), "writhe")


@pytest.mark.parametrize("frames", [2, 3, 4])
def test_lengths_of_growing_filaments_belong_to_frame_and_rod(frames):
    """Three rods of different lengths that grow; with as many frames as rods nothing is broadcast to the wrong axis."""
    s, turn = np.linspace(-0.5, 0.5, 33), 2.0
    length = np.array([0.5, 0.9, 1.4]) * (1 + 0.3 * np.arange(frames)[:, None])
    strain = np.tile([turn, 1.5, 0.0], (frames, 3, 33, 1))
    data = xr.Dataset(
        {"strain": (("frame", "rod", "node", "strain_component"), strain), "length": (("frame", "rod"), length)},
        {"time": ("frame", np.arange(float(frames))), "s": ("node", s)},
    )
    assert wr.measure(data, "total_twist").total_twist.values == pytest.approx(turn * length / (2 * np.pi))
    for given in (data, data.transpose("rod", ...)):
        found = wr.measure(given, "mode_coefficients", twist_free=True).mode_coefficients
        angle = turn * length[..., None] * s
        for part, k in enumerate((1.5 * np.cos(angle), 1.5 * np.sin(angle))):
            np.testing.assert_allclose(found[:, :, part], modes.coefficients(k, s, 6), rtol=0, atol=1e-3)


def test_tables_of_single_rooms_are_views_of_the_table(run):
    tables = (wr.diagnostics.MEASURES, wr.sensing.MEASURES, wr.swarm.MEASURES)
    kymographs = {"energy_terms", "energy_per_length", "dissipation_peaks"}
    loads = {"force_on_membrane", "torque_on_membrane"}
    assert set().union(*tables) | kymographs | loads == set(MEASURES)
    soft, sensors = run["soft"].to_dataset(), run["sensors"].to_dataset()
    for name, function in {**wr.diagnostics.MEASURES, **wr.swarm.MEASURES}.items():
        assert function is MEASURES[name].function
    np.testing.assert_array_equal(
        wr.diagnostics.measure(soft, "writhe").writhe, wr.diagnostics.MEASURES["writhe"](soft)
    )
    torus = wr.sensing.membrane_of(run)
    for name, function in wr.sensing.MEASURES.items():
        xr.testing.assert_identical(function(sensors, torus), wr.measure(sensors, name))
    for name in kymographs:
        found = getattr(wr.kymograph, name)(sensors)
        assert set(found.data_vars) == set(wr.measure(sensors, name).data_vars)

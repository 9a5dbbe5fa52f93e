"""Plots: one for every measure, and the contents of those that several measures use."""

import re

import numpy as np
import pytest
import xarray as xr

import warp_rods as wr
from warp_rods.analysis.listing import Measure
from warp_rods.analysis.registry import MEASURES
from warp_rods.draw import distributions, over_time, plots
from warp_rods.draw.measured import PLOTS
from warp_rods.draw.views import views
from warp_rods.scene.scene import Scene
from warp_rods.simulation import runner

SCENE = {
    "surface": {"kind": "torus", "major": 1.0, "minor": 0.4},
    "swimmers": [
        {"name": "cells", "count": 3, "nodes": 17, "bend": 1e-3, "twist": 1e-3, "moment": 2e-3,
         "placement": {"position": [[0, 0, 0], [0.1, 0.2, 0.1], [1, 1, 1]]}}
    ],
    "filaments": [
        {"name": "sensors", "count": 3, "nodes": 9, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1],
         "growth": {"rate": 0.1, "until": 1.0}}
    ],
    "time": {"end": 0.12, "step": 1e-3, "save_every": 0.01},
}  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> xr.DataTree:
    return runner.simulate(Scene.parse(SCENE), tmp_path_factory.mktemp("run") / "mixed", device="cpu").data.load()


def test_every_measure_has_a_plot():
    assert set(PLOTS) == set(MEASURES)


@pytest.mark.parametrize("count", [3, 1])
@pytest.mark.parametrize("name", MEASURES)
def test_every_plot_is_drawn(run, name, count):
    """For several rods and for one, from data and from measured values; Matplotlib's settings do not change."""
    import matplotlib
    from matplotlib.figure import Figure

    group = run["sensors" if MEASURES[name].of == "filaments" else "cells"].to_dataset().isel(rod=slice(count))
    before = dict(matplotlib.rcParams)
    if count == 1 and name in ("pair_correlation", "velocity_correlation"):
        with pytest.raises(ValueError, match="two or more"):
            wr.plot(group, name)
        return
    figure = wr.plot(group, name)
    assert isinstance(figure, Figure)
    assert all(axes.get_ylabel() for axes in figure.axes if not axes.get_label().startswith("<colorbar"))
    assert any(axes.get_xlabel() for axes in figure.axes)
    again = wr.plot(wr.measure(group, *{name, "orthonormality"}), name)
    assert again._repr_png_() == figure._repr_png_()
    assert dict(matplotlib.rcParams) == before


UNITS = {"length": "1 um", "time": "1 ms", "force": "1 pN"}


@pytest.fixture(scope="module")
def in_units(tmp_path_factory) -> xr.DataTree:
    folder = tmp_path_factory.mktemp("run") / "si"
    return runner.simulate(Scene.parse(SCENE | {"units": UNITS}), folder, device="cpu").data


@pytest.mark.parametrize("ensemble", ["cells", "sensors"])
def test_every_plot_names_the_units_of_its_scene(in_units, ensemble):
    """No axis and no bar has "length", "time" or "force" as a unit where the scene says what these are."""
    group, drawn = in_units[ensemble].to_dataset().load(), 0
    for name in [*MEASURES, *views(group)]:
        try:
            figure = wr.plot(group, name)
        except ValueError:  # not of this kind of rods, or nothing to draw
            continue
        labels = [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel())]
        units = [unit for text in labels for unit in re.findall(r"\(([^)]*)\)", text.replace("\n", " "))]
        assert not [unit for unit in units if re.search("length|time|force", unit)], (name, labels)
        assert not [text for text in labels if text in ("time", "force", "length")], (name, labels)
        drawn += 1
    assert drawn > 20


@pytest.mark.parametrize("name", MEASURES)
def test_every_plot_is_drawn_without_failed_rods(run, name):
    group = run["sensors" if MEASURES[name].of == "filaments" else "cells"].to_dataset()
    status = group.status.copy(deep=True)
    status[4:, 1] = 1
    failed = group.assign(status=status)
    if name == "velocity_correlation":  # the two rods that are left are too far apart
        with pytest.raises(ValueError, match="no value at any distance"):
            wr.plot(failed, name)
        return
    assert wr.plot(failed, name).axes


def test_a_figure_is_shown_and_saved_in_the_house_style(run, tmp_path):
    """Notebooks can show it, and files have the same bytes whatever the settings of Matplotlib."""
    import matplotlib

    figure = wr.plot(run["cells"], "writhe", tmp_path / "writhe")
    assert figure._repr_png_().startswith(b"\x89PNG\r\n\x1a\n")
    assert figure.axes[0].xaxis.label.get_fontsize() == plots.STYLE["axes.labelsize"]
    assert figure.axes[0].lines[0].get_linewidth() == plots.STYLE["lines.linewidth"]
    with matplotlib.rc_context({"svg.hashsalt": "another", "font.family": "serif"}):
        wr.plot(run["cells"], "writhe", tmp_path / "elsewhere")
    for suffix in (".png", ".svg"):
        assert (tmp_path / f"writhe{suffix}").read_bytes() == (tmp_path / f"elsewhere{suffix}").read_bytes()


def test_options_go_to_the_plot_or_to_the_measure(run):
    title = wr.plot(run["sensors"], "energy_terms", rod=2).axes[0].get_title()
    assert title == "energy per length of twist, rod 2"
    with pytest.raises(ValueError, match="rod = 3: there are 3, counted from 0"):
        wr.plot(run["sensors"], "energy_terms", rod=3)
    for count in (2, 11):  # eleven are more than there are colours
        drawn = wr.plot(run["cells"], "mode_coefficients", count=count)
        assert [len(axes.lines) for axes in drawn.axes] == [count, count]
    with pytest.raises(ValueError, match="cuont: not an option of mode_coefficients"):
        wr.plot(run["cells"], "mode_coefficients", cuont=2)
    with pytest.raises(ValueError, match=r"count: not an option of this plot; .* has been measured already"):
        wr.plot(wr.measure(run["cells"], "mode_coefficients"), "mode_coefficients", count=2)
    with pytest.raises(ValueError, match="no measure called beauty"):
        wr.plot(run["cells"], "beauty")


def test_the_period_of_the_box_is_not_confused_with_the_measure(run):
    """Groups have a variable ``period`` of the box; ``arc_length`` of filaments is the measure itself."""
    cells = run["cells"].to_dataset()
    assert "period" in cells and wr.plot(cells, "period").axes[0].get_title() == "none for 3 of 3 rods"
    terms = wr.measure(run["sensors"], "energy_terms")
    with pytest.raises(ValueError, match="twist_energy: the group has no activity"):
        wr.plot(terms, "twist_energy")


def test_a_measure_without_a_plot_is_refused(run, monkeypatch):
    monkeypatch.setitem(MEASURES, "mine", Measure(MEASURES["writhe"].function, "rods", "1", ("position",)))
    with pytest.raises(ValueError, match="mine has no plot: give it a row of"):
        wr.plot(run["cells"], "mine")
    monkeypatch.setitem(PLOTS, "mine", over_time.curve)
    assert wr.plot(run["cells"], "mine").axes[0].get_ylabel() == "writhe"


def values(array, *dims) -> xr.DataArray:
    array = np.asarray(array, float)
    time = {"time": ("frame", np.arange(len(array)))} if "frame" in dims else {}
    return xr.DataArray(array, dims=dims, coords=time, name="value", attrs={"long_name": "value", "units": "length^2"})


def axes():
    return plots.figure().add_subplot()


def test_a_curve_is_the_median_with_the_interquartile_range():
    several = np.random.default_rng(0).normal(size=(6, 9))
    several[0] = np.nan
    drawn = axes()
    over_time.curve(drawn, values(several, "frame", "rod"))
    np.testing.assert_array_equal(drawn.lines[0].get_xydata()[:, 0], [1, 2, 3, 4, 5])
    np.testing.assert_allclose(drawn.lines[0].get_ydata(), np.median(several[1:], axis=1))
    band = drawn.collections[0].get_paths()[0].vertices
    for frame in range(1, 6):
        at = band[band[:, 0] == frame, 1]
        np.testing.assert_allclose([at.min(), at.max()], np.quantile(several[frame], [0.25, 0.75]))
    assert drawn.get_ylabel() == "value (length²)"
    with pytest.raises(ValueError, match="value has no value in any frame"):
        over_time.curve(axes(), values(np.full((3, 2), np.nan), "frame", "rod"))


def test_errors_are_drawn_by_magnitude():
    drawn = axes()
    over_time.error(drawn, values([[-1e-3, 0.0, 1e-5], [np.nan, np.nan, np.nan], [1e-2, 1e-4, -1e-6]], "frame", "rod"))
    median, worst = (line.get_ydata() for line in drawn.lines)
    np.testing.assert_allclose(median, [1e-5, 1e-4])
    np.testing.assert_allclose(worst, [1e-3, 1e-2])
    assert drawn.get_yscale() == "log"


def test_modes_of_several_rods_are_root_mean_squares():
    array = xr.DataArray([[[3.0, 0.0], [-4.0, 0.0]]], dims=("frame", "rod", "harmonic"), coords={"harmonic": [0, 1]})
    array = array.assign_coords(time=("frame", [0.0])).assign_attrs(long_name="twist", units="1/length")
    drawn = axes()
    over_time.modes(drawn, array)
    assert [line.get_ydata()[0] for line in drawn.lines] == [pytest.approx(np.sqrt(12.5)), 0]
    single = axes()
    over_time.modes(single, array.isel(rod=[1]))
    assert [line.get_ydata()[0] for line in single.lines] == [-4, 0]


def test_few_rods_are_drawn_one_by_one_and_many_as_a_histogram():
    few, many = (values([*range(count), np.nan], "rod").assign_coords(rod=np.arange(count + 1)) for count in (4, 40))
    drawn = axes()
    distributions.histogram(drawn, few)
    assert [bar.get_height() for bar in drawn.patches] == [0, 1, 2, 3]
    assert drawn.get_title() == "none for 1 of 5 rods"
    drawn = axes()
    distributions.histogram(drawn, many)
    assert sum(bar.get_height() for bar in drawn.patches) == 40 and drawn.get_ylabel() == "rods"


def test_the_settled_fraction_counts_rods_that_never_settle():
    """Two of the three rods that did not fail have settled."""
    drawn = axes()
    distributions.settled(drawn, values([2.0, np.inf, 1.0, np.nan], "rod"))
    np.testing.assert_allclose(drawn.lines[0].get_xydata(), [[0, 0], [1, 1 / 3], [2, 2 / 3]])


def test_correlations_measured_together_are_drawn_without_gaps(run):
    """Their bins differ, so that a common dataset has missing values for both."""
    together = wr.measure(run["cells"], "pair_correlation", "velocity_correlation")
    assert together.pair_correlation.isnull().any()
    for name in ("pair_correlation", "velocity_correlation"):
        drawn, alone = (wr.plot(data, name).axes[0].lines[0].get_xydata() for data in (together, run["cells"]))
        np.testing.assert_array_equal(drawn, alone)

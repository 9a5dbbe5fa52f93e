"""Plots of what a trajectory holds: energies, kymographs, phase portraits; and what can be drawn of a run."""

import numpy as np
import pytest
import xarray as xr

import warp_rods as wr
from warp_rods.analysis.registry import MEASURES
from warp_rods.draw import of_run, plots, views
from warp_rods.draw.measured import PLOTS

FRAMES, RODS, NODES = 5, 2, 9


def ensemble(**variables) -> xr.Dataset:
    """Two rods whose first strain is s t and −2 s t, and whose energies are 1 + t and 2 + 2t."""
    time, s = np.linspace(0, 1, FRAMES), np.linspace(-0.5, 0.5, NODES)
    strain = np.zeros((FRAMES, RODS, NODES, 3))
    strain[..., 0] = time[:, None, None] * s * np.array([1.0, -2.0])[:, None]
    strain[..., 2] = np.cos(np.pi * s) * time[:, None, None]
    along = ("frame", "rod", "node")
    energy = (1 + time[:, None]) * [1.0, 2.0]
    data = xr.Dataset(
        {
            "strain": ((*along, "strain_component"), strain, {"long_name": "strain in the material frame"}),
            "energy": (along[:2], energy),
            "steric_energy": (along[:2], 0 * energy),
            "dissipation": (along[:2], 3 * energy),
            "status": (along[:2], np.zeros((FRAMES, RODS), int)),
            **variables,
        },
        coords={"time": ("frame", time), "s": ("node", s), "strain_component": ["twist", "bend1", "bend2"]},
    )
    return data.assign_coords(rod=np.arange(RODS))


def drawn(name, data=None, **options):
    data = ensemble() if data is None else data
    return wr.plot(data, name, **options)


def test_energies_are_sums_over_the_rods_that_did_not_fail():
    upper, lower = drawn("energies").axes
    curve = upper.lines[0].get_ydata()
    np.testing.assert_allclose(curve, 3 * (1 + np.linspace(0, 1, FRAMES)))
    np.testing.assert_allclose(lower.lines[0].get_ydata(), 3 * curve)
    assert [text.get_text() for text in upper.get_legend().get_texts()] == ["elastic"]  # the steric energy is 0
    status = np.zeros((FRAMES, RODS), int)
    status[-1, 1] = 1
    upper, _ = drawn("energies", ensemble(status=(("frame", "rod"), status))).axes
    np.testing.assert_allclose(upper.lines[0].get_ydata(), curve / 3)


def test_a_peak_does_not_hide_the_rest():
    dissipation = np.full((FRAMES, RODS), 1.0)
    dissipation[0] = 1e4
    _, lower = drawn("energies", ensemble(dissipation=(("frame", "rod"), dissipation))).axes
    assert lower.get_yscale() == "log"


def test_a_kymograph_is_of_one_rod_and_white_at_zero():
    for rod, factor in ((0, 1.0), (1, -2.0)):
        mesh = drawn("kymograph_twist", rod=rod).axes[0].collections[0]
        values = factor * np.linspace(0, 1, FRAMES)[:, None] * np.linspace(-0.5, 0.5, NODES)
        np.testing.assert_allclose(np.asarray(mesh.get_array()).reshape(values.shape), values)
        assert mesh.norm.vmin == -mesh.norm.vmax and mesh.cmap.name == views.SIGNED_MAP
    assert drawn("kymograph_twist").axes[1].get_ylabel() == "twist"  # beside the colours
    grown = ensemble(length=(("frame", "rod"), np.outer(np.arange(1, 6), [1.0, 1.0])))
    assert drawn("kymograph_twist", grown).axes[0].get_ylabel() == "arc length (length)"
    with pytest.raises(ValueError, match="rod = 2: there are 2, counted from 0"):
        drawn("kymograph_twist", rod=2)
    with pytest.raises(ValueError, match="bend1 of rod 0 is 0 throughout"):
        drawn("kymograph_bend1")
    with pytest.raises(ValueError, match="colour: not an option of kymograph_twist, which takes rod"):
        drawn("kymograph_twist", colour="red")


def test_a_kymograph_of_values_far_from_zero_has_contrast():
    """A normal curvature from 1.1 to 1.7 is drawn between these; what comes near 0 begins there."""
    along = ("frame", "rod", "node", "strain_component")
    for low, end in ((1.1, 1.1), (0.2, 0.0)):
        values = np.linspace(low, 1.7, FRAMES * RODS * NODES * 3).reshape(FRAMES, RODS, NODES, 3)
        data = ensemble(strain=(along, values)).assign_coords(strain_component=["twist", "normal", "geodesic"])
        figure = drawn("kymograph_normal", data)
        assert figure.axes[0].collections[0].norm.vmin == pytest.approx(end, abs=0.02)
        assert figure.axes[1].get_ylabel() == "normal curvature"
        assert "normal curvature" in views.views(data)["kymograph_normal"].what


def test_speeds_are_offered_of_what_swims(tmp_path):
    table = {"name": "sensors", "count": 2, "nodes": 17, "length": 0.4, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
    surface, time = {"kind": "sphere", "radius": 1.0}, {"end": 0.01, "save_every": 0.001}
    scene = wr.Scene(filaments=[table], surface=surface, time=time, output={"usd": False, "poster": False})
    run = wr.open_run(wr.run(scene, tmp_path / "run", device="cpu").folder)
    offered = {one.name for one in of_run.drawables(run) if one.ensemble}
    assert not offered & {"speed", "instantaneous_speed", "phase_portrait"} and "energies" in offered
    assert "speed" in wr.measures(run["sensors"].to_dataset())


def test_a_phase_portrait_shows_the_two_largest_modes():
    """cos πs is even: its modes are those of component 2."""
    axes = drawn("phase_portrait").axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (
        "bending mode 0, component 2 (1/length)",
        "bending mode 2, component 2 (1/length)",
    )
    found = wr.measure(ensemble(), "mode_coefficients").mode_coefficients.sel(component=2)
    for rod in range(RODS):
        expected = found.isel(rod=rod).sel(mode=[0, 2]).to_numpy()
        np.testing.assert_allclose(axes.lines[rod].get_xydata(), expected)


def test_views_depend_on_what_is_saved():
    assert set(views.views(ensemble())) == {
        "energies", "phase_portrait", "kymograph_twist", "kymograph_bend1", "kymograph_bend2",
    }  # fmt: skip
    assert not views.views(ensemble()[["energy"]])
    assert not set(views.VIEWS) & set(MEASURES)


def test_everything_of_a_run_is_listed_and_drawn(tmp_path):
    table = {"name": "cells", "count": 3, "nodes": 17, "bend": 1e-4, "twist": 1e-3, "moment": 1e-3}
    scene = wr.Scene(swimmers=[table], time={"end": 0.1, "save_every": 0.02}, output={"usd": False})
    folder = wr.run(scene, tmp_path / "run", device="cpu").folder
    found = of_run.drawables(wr.open_run(folder))
    alone = {one.name for one in found if one.ensemble == "cells"}
    assert alone >= {"energies", "kymograph_activity", "mode_coefficients", "speed"}
    assert {one.name for one in found if not one.ensemble} >= {"polar_order", "density_map"}
    assert {one.name for one in found} <= {*PLOTS, *views.views(wr.open_run(folder)["cells"].to_dataset())}
    text = "\n".join(of_run.listed(folder))
    assert all(one.name in text and one.what in text for one in found) and "all rods together" in text


def test_what_cannot_be_drawn_is_left_out_of_all_and_said(tmp_path, monkeypatch):
    """A scene in the plane has no twist: its kymograph alone is refused, and of all it is left out."""
    table = {"name": "cell", "count": 1, "nodes": 17, "bend": 5e-3, "twist": 1e-3}
    scene = wr.Scene(swimmers=[table], time={"end": 0.02, "save_every": 0.01}, output={"usd": False})
    folder = wr.run(scene, tmp_path / "run", device="cpu").folder
    with pytest.raises(wr.RunFolderError, match="cell-kymograph_twist: twist of rod 0 is 0 throughout"):
        list(of_run.drawn(folder, ["kymograph_twist"]))
    some = [one for one in of_run.drawables(wr.open_run(folder)) if one.name in ("kymograph_twist", "energies")]
    monkeypatch.setattr(of_run, "drawables", lambda run: some)
    energies, twist = of_run.drawn(folder, ["all"], out=tmp_path / "figures")
    assert energies == tmp_path / "figures" / "cell-energies.png" and energies.is_file()
    assert str(twist).startswith("left out cell-kymograph_twist")


def test_a_legend_above_the_axes_is_over_no_line():
    from warp_rods.draw.labels import above

    figure = plots.figure()
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], label="a")
    above(axes)
    figure.draw_without_rendering()
    assert axes.get_legend().get_window_extent().y0 >= axes.get_window_extent().y1

"""What is said and drawn of a study, from stores that are written by hand."""

import os
import time

import numpy as np
import pytest
import xarray as xr
from examples.study import SPEED, cells, put, store_of

from warp_rods.draw.colours import MAPS
from warp_rods.draw.diagrams import Marks
from warp_rods.errors import SceneError
from warp_rods.studies.columns import Column
from warp_rods.studies.plan import Plan
from warp_rods.studies.plot import figure_of, opened, plot_study, plotted
from warp_rods.studies.refine import levels
from warp_rods.studies.status import status
from warp_rods.studies.store import Store
from warp_rods.studies.summaries import of_all

RANGE = {"from": 1e-3, "to": 1e-2, "num": 9, "scale": "log"}


# --- settling --------------------------------------------------------------------------------------------------------


def test_whether_all_ensembles_have_settled():
    """0 where one has not, else −1 where one cannot be told, else 1."""
    one, other = np.array([1, 1, 1, 0, 0, -1]), np.array([1, 0, -1, 0, -1, -1])
    assert of_all([one, other]).tolist() == [1, 0, -1, 0, 0, -1]


def test_points_of_which_settling_is_not_known_are_counted_and_marked(tmp_path):
    plan = Plan(cells({"swimmers.cell.bend": [1e-3, 2e-3, 3e-3, 4e-3], "swimmers.cell.moment": [0.0], "seeds": 2}))
    store = store_of(plan, tmp_path)
    settled = np.array([[1, 1], [1, 0], [-1, 1], [-1, 0]])[:, None]
    put(store, plan.first(), settled=settled)
    assert "8 of 8 points done (100 %): 2 not settled, 2 unknown if settled" in status(tmp_path)
    data = xr.open_zarr(store.path).isel({"swimmers.cell.moment": 0}).load()
    marks = Marks(data, assumes=True)
    assert [marks.sound.tolist(), marks.open.tolist(), marks.untold.tolist()] == [
        [True, False, False, False],
        [False, True, False, True],
        [False, False, True, False],
    ]
    assert Marks(data, assumes=False).sound.all()


# --- pace ------------------------------------------------------------------------------------------------------------


def stamped(store: Store, ago: dict) -> None:
    """Let chunks have been written so many seconds ago."""
    for chunk, seconds in ago.items():
        at = time.time() - seconds
        os.utime(store.path / "state" / ".".join(["c", *map(str, chunk)]), (at, at))


def test_the_pace_of_a_refinement_is_that_of_its_own_points(tmp_path):
    """Two of its points in 90 s, in chunks that have many others."""
    plan = Plan(cells({"swimmers.cell.bend": RANGE, "swimmers.cell.moment": [0.0], "seeds": 1, "refine": 1,
                       "measure": ["speed"]}))  # fmt: skip
    store = store_of(plan, tmp_path, (4, 1, 1), [SPEED])
    put(store, plan.first(), speed=(np.arange(17) % 4 / 2.0)[:, None, None])  # all neighbours differ
    *_, (level, mask) = levels(plan, store)
    assert level == 1 and mask.all()
    new = np.zeros_like(mask)
    new[[1, 5, 9]] = True
    put(store, new, speed=0.0)
    stamped(store, {(0, 0, 0): 90.0, (1, 0, 0): 45.0, (2, 0, 0): 0.0, (3, 0, 0): 250.0, (4, 0, 0): 250.0})
    assert "0.0222 points/s of late, about 3.8 min left" in status(tmp_path)


def test_damaged_files_have_no_pace(tmp_path):
    plan = Plan(cells({"swimmers.cell.bend": RANGE, "seeds": 1}))
    store = store_of(plan, tmp_path, (3, 3, 1))
    put(store, plan.first())
    stamped(store, {(0, 0, 0): 60.0, (1, 0, 0): 30.0, (2, 0, 0): 0.0})
    for chunk in store.chunks():
        file = store.path / "state" / ".".join(["c", *map(str, chunk)])
        stamp = file.stat().st_mtime
        file.write_bytes(file.read_bytes()[:-1] + b"x")
        os.utime(file, (stamp, stamp))
    assert "0 of 27 points done" in status(tmp_path) and "points/s" not in status(tmp_path)


# --- diagrams --------------------------------------------------------------------------------------------------------


def panels_of(store: Store, name: str) -> list:
    """The panels of a figure of a measure, without the axes of the colour bar."""
    return [axes for axes in figure_of(opened(store.path.parent), name).axes if axes.get_label() != "<colorbar>"]


def test_lists_that_are_not_in_order_are_drawn_in_order(tmp_path):
    plan = Plan(cells({"swimmers.cell.bend": [3e-3, 1e-3, 2e-3], "swimmers.cell.moment": [2.0, 0.0, 1.0], "seeds": 1}))
    store = store_of(plan, tmp_path)
    i, j = np.indices((3, 3))
    bend, moment = np.array([3, 1, 2])[i], np.array([2, 0, 1])[j]
    put(store, plan.first(), speed=(bend + 10 * moment)[..., None])
    (axes,) = panels_of(store, "speed")
    (mesh,) = axes.collections
    x, y = mesh.get_coordinates()[..., 0], mesh.get_coordinates()[..., 1]
    np.testing.assert_allclose(x[0], [0.5e-3, 1.5e-3, 2.5e-3, 3.5e-3])
    np.testing.assert_allclose(y[:, 0], [-0.5, 0.5, 1.5, 2.5])
    np.testing.assert_allclose(mesh.get_array().reshape(3, 3), [[1, 2, 3], [11, 12, 13], [21, 22, 23]])


def cubes(folder, sizes: tuple[int, int, int] = (4, 4, 3), refine: int = 0, **sweep) -> tuple[Plan, Store]:
    """A study of three keys, the third with few values."""
    keys = ("swimmers.cell.bend", "swimmers.cell.moment", "swimmers.cell.twist")
    ranges = {key: {"from": 1e-3, "to": 1e-2, "num": n} for key, n in zip(keys, sizes, strict=True)}
    plan = Plan(cells(ranges | {"seeds": 1, "refine": refine} | sweep))
    return plan, store_of(plan, folder)


def test_a_panel_without_values_does_not_change_the_colours_of_the_others(tmp_path):
    plan, store = cubes(tmp_path)
    speed = np.broadcast_to(np.array([np.nan, 2.0, 5.0])[:, None], (4, 4, 3, 1))
    put(store, plan.first(), speed=speed, **{"class": np.where(np.isnan(speed), "", "U").astype(object)})
    assert [axes.collections[0].get_clim() for axes in panels_of(store, "speed")] == [(2.0, 5.0)] * 3
    assert len(panels_of(store, "class")) == 3


def test_panels_are_of_first_points_and_those_left_out_are_told(tmp_path):
    """Of 12 values 9 are drawn; values between them that a refinement added are none of these."""
    plan, store = cubes(tmp_path, (13, 13, 12), refine=1)
    put(store, plan.first() | (np.indices(plan.shape)[:3].sum(axis=0) == 1), speed=1.0, **{"class": "U"})
    titles = [axes.get_title() for axes in panels_of(store, "speed")]
    first = {f"twist = {value:.4g}" for value in plan.axes[2].values[::2]}
    assert len(titles) == 9 and set(titles) <= first
    said = []
    plot_study(tmp_path, ["speed"], tmp_path / "out", tell=said.append)
    assert said == ["panels for 9 of 12 values of swimmers.cell.twist; 3 are left out"]


def test_what_is_not_drawn_is_told(tmp_path):
    plan = Plan(cells({"seeds": 1}))
    modes = Column("modes", ("component", "mode"), (2, 6), {}, attributes={"units": "1", "long_name": "modes"})
    put(store_of(plan, tmp_path, columns=[modes]), plan.first())
    why = "modes: is not drawn, as it has values over component, mode at each point: read them from study.zarr"
    assert [line.partition(" with")[0] for line in plotted(tmp_path, [])] == [why]
    with pytest.raises(SceneError, match=why):
        plotted(tmp_path, ["modes"])


def filled(axes) -> np.ndarray:
    """Whether each place of a map has a colour [x, y]."""
    return ~np.ma.getmaskarray(np.ma.masked_invalid(axes.collections[0].get_array())).T


def test_places_about_points_that_are_not_computed_have_no_colour(tmp_path):
    """Of 4 × 4 first points the left half is done: nothing is known of places from half-way on."""
    ranges = {
        f"swimmers.cell.{key}": {"from": 1e-3, "to": 1e-2, "num": 4} for key in ("bend", "moment")
    }  # fmt: skip
    plan = Plan(cells(ranges | {"seeds": 2, "refine": 2}))
    store = store_of(plan, tmp_path)
    done = plan.first()
    done[8:] = False
    put(store, done, speed=1.0, **{"class": "U"})
    for name in ("speed", "class"):
        (axes,) = panels_of(store, name)
        expected = np.zeros((13, 13), dtype=bool)
        expected[:6] = True
        np.testing.assert_array_equal(filled(axes), expected)
    said = []
    plot_study(tmp_path, ["speed"], tmp_path / "out", tell=said.append)
    assert said == ["16 of 32 points computed"] and said[0] in (tmp_path / "out" / "speed.svg").read_text()


def test_computed_points_of_a_refinement_have_their_own_colour(tmp_path):
    """Also where a first point beside them has failed."""
    ranges = {f"swimmers.cell.{key}": {"from": 1e-3, "to": 1e-2, "num": 2} for key in ("bend", "moment")}
    plan = Plan(cells(ranges | {"seeds": 1, "refine": 1}))
    store = store_of(plan, tmp_path)
    states = np.ones(plan.shape)
    states[2, 2] = 3
    put(store, np.ones(plan.shape, dtype=bool), state=states, speed=np.where(states == 1, 1.0, np.nan))
    assert filled(panels_of(store, "speed")[0]).sum() == 8


def test_what_is_drawn_of_several_seeds_is_said(tmp_path):
    one = {"swimmers.cell.bend": RANGE, "swimmers.cell.moment": [0.0]}
    for number, swept in enumerate(({}, one)):
        (folder := tmp_path / str(number)).mkdir()
        plan = Plan(cells(swept | {"seeds": 2}))
        store = store_of(plan, folder)
        put(store, plan.first(), speed=np.indices(plan.shape).sum(axis=0), **{"class": "U"})
        figures = {name: figure_of(opened(folder), name) for name in ("speed", "class")}
        if swept:
            assert figures["speed"].axes[0].get_ylabel() == "speed (length/time)\nmean of 2 seeds"
            assert figures["class"].axes[0].get_ylabel() == "commonest of 2 seeds"
        else:
            assert figures["speed"].axes[-1].get_ylabel().endswith(", mean of 2 seeds")
            assert figures["class"].legends[0].get_title().get_text() == "commonest of 2 seeds"


def test_values_of_both_signs_have_colours_centred_on_zero(tmp_path):
    plan = Plan(cells({"seeds": 1}))
    store = store_of(plan, tmp_path, columns=[SPEED])
    put(store, plan.first(), speed=np.indices(plan.shape).sum(axis=0) - 1.0)
    mesh = panels_of(store, "speed")[0].collections[0]
    assert mesh.get_clim() == (-4.0, 4.0) and mesh.get_cmap().name == MAPS["signed"]

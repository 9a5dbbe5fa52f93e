"""Whole studies without a cluster: parts, restarts, failing points, runs that are kept, status, diagrams."""

import re

import numpy as np
import pytest
import xarray as xr
from examples.study import CELL, SENSOR, TIME, cells, sensors

import warp_rods as wr
from warp_rods.errors import RunFolderError, SceneError
from warp_rods.simulation.storage import StorageError
from warp_rods.simulation.under_way import lock_folder
from warp_rods.studies import begin, points, tasks
from warp_rods.studies.columns import Column, columns_of
from warp_rods.studies.plot import plot_study
from warp_rods.studies.status import status
from warp_rods.studies.store import Store
from warp_rods.studies.tasks import tasks_of


def equal(one: xr.Dataset, other: xr.Dataset) -> bool:
    return all(np.array_equal(one[n], other[n], equal_nan=one[n].dtype.kind == "f") for n in one.variables)


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> wr.Study:
    return wr.sweep(cells(), tmp_path_factory.mktemp("whole") / "study", device="cpu", part=(1, 1))


def test_a_study_is_measured_at_every_point(whole):
    data = whole.data
    assert data["speed"].shape == (4, 3, 2) and (data["state"] == 1).all() and whole.left == 0
    assert data["modes"].dims[3:] == ("component", "mode") and data["speed"].attrs["ancillary_variables"] == "settled"
    assert set(np.unique(data["settled"])) <= {0, 1} and np.isfinite(data["speed"]).all()
    assert "24 computed" in whole.summary and "24 of 24 points done (100 %)" in status(whole.folder)
    assert any("rods of batches" in line for line in whole.messages)


def test_parts_in_any_order_and_twice_are_the_whole(whole, tmp_path, monkeypatch):
    monkeypatch.setattr(begin, "FEWEST", 1)
    folder = tmp_path / "study"
    first = wr.sweep(cells(), folder, device="cpu", part=(2, 3))
    assert 0 < first.left < 24 and "left: run the same command again" in first.summary
    done = xr.open_zarr(folder / "study.zarr")["state"].to_numpy() == 1
    stamps = {file: file.stat().st_mtime_ns for file in (folder / "study.zarr").rglob("c.*")}
    again = wr.sweep(cells(), folder, device="cpu", part=(2, 3))
    assert again.left == first.left and stamps == {f: f.stat().st_mtime_ns for f in stamps}  # nothing is done twice
    wr.sweep(cells(), folder, device="cpu", part=(1, 3))
    last = wr.sweep(cells(), folder, device="cpu", part=(3, 3))
    assert last.left == 0 and done.any() and equal(last.data, whole.data)


def test_a_study_of_another_scene_is_not_continued(whole):
    with pytest.raises(RunFolderError, match=r"study of another scene \(\[sweep\] differs\)"):
        wr.sweep(cells({"seeds": 3}), whole.folder, device="cpu", part=(1, 1))
    with pytest.raises(SceneError, match=r"part = 0/3: must be i/n"):
        wr.sweep(cells(), whole.folder, part=(0, 3))
    with pytest.raises(SceneError, match=r"sweep: this scene is a study"):
        wr.run(cells(), whole.folder.with_name("run"), device="cpu")


def test_a_study_is_replaced_only_when_all_is_ready_and_with_what_is_its_own(whole, tmp_path, monkeypatch):
    folder = tmp_path / "study"
    first = wr.sweep(cells({"seeds": 1}), folder, device="cpu", part=(1, 1))
    assert plot_study(folder)[0].parent == folder / "plots" and (folder / "scene.toml").is_file()
    (folder / "notes.txt").write_text("mine")
    with monkeypatch.context() as patched:
        patched.setattr(begin, "probe", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            wr.sweep(cells(), folder, device="cpu", workers=1, overwrite=True)
    assert (first.data["state"] == 1).all()
    wr.sweep(cells(), folder, device="cpu", workers=1, overwrite=True)
    data = xr.open_zarr(folder / "study.zarr").load()
    assert equal(data, whole.data) and (folder / "notes.txt").read_text() == "mine"
    (tmp_path / "other" / "trajectories").mkdir(parents=True)
    (tmp_path / "other" / "trajectories" / "mine.txt").touch()
    with pytest.raises(RunFolderError, match="holds something that is not a study"):
        wr.sweep(cells(), tmp_path / "other", device="cpu", workers=1, overwrite=True)
    assert (tmp_path / "other" / "trajectories" / "mine.txt").exists()


def test_of_two_scenes_that_begin_at_once_in_a_folder_one_is_refused(whole, tmp_path, monkeypatch):
    """The second finds no study when it looks, and one of another scene when it has compiled its kernels."""
    folder = tmp_path / "study"
    real = begin.create

    def late(path, *given):
        if not path.exists():
            with monkeypatch.context() as patched:
                patched.setattr(begin, "create", real)
                wr.sweep(cells(), folder, device="cpu", part=(1, 1))
        return real(path, *given)

    monkeypatch.setattr(begin, "create", late)
    with pytest.raises(RunFolderError, match=r"holds a study of another scene \(\[sweep\] differs\)"):
        wr.sweep(cells({"seeds": [5, 6]}), folder, device="cpu", part=(1, 1))
    assert equal(xr.open_zarr(folder / "study.zarr").load(), whole.data)


def test_a_study_goes_on_with_the_version_and_the_files_with_which_it_began(tmp_path):
    points = tmp_path / "line.csv"
    points.write_text("".join(f"{x / 16},{0.1 * (x / 16) ** 2},0\n" for x in range(17)))
    bent = {key: value for key, value in CELL.items() if key != "shape"}
    scene = cells({"seeds": 1}, swimmers=[bent | {"shape": {"points": str(points)}}])
    folder = tmp_path / "study"
    wr.sweep(scene, folder, device="cpu", part=(1, 2))
    points.write_text(points.read_text().replace("0.1", "0.2"))
    with pytest.raises(RunFolderError, match=r"line.csv changed since this study was begun: put back"):
        wr.sweep(scene, folder, device="cpu", part=(2, 2))
    document = folder / "study.zarr" / "zarr.json"
    document.write_text(document.read_text().replace(f'"{wr.__version__}"', '"0.0.1"'))
    with pytest.raises(RunFolderError, match=r"was begun with warp-rods 0.0.1, whose numbers may not be those of"):
        wr.sweep(scene, folder, device="cpu", part=(2, 2))


def test_points_that_somebody_else_has_finished_are_not_computed_again(whole):
    store = Store(whole.folder / "study.zarr")
    (task, *_) = tasks_of(store, 0, np.ones(store.shape, dtype=bool), np.zeros(store.shape, dtype=np.int8))
    assert tasks.do(str(whole.folder), task, "no device").done == len(task.points)


def test_an_impossible_corner_fails_by_itself(tmp_path):
    """Length and end of growth are each possible, not together: neither begins the study nor stops it."""
    grows = SENSOR | {"growth": {"rate": 1.0, "until": 0.7}}
    table = {"filaments.sensors.length": [0.5, 0.8], "filaments.sensors.growth.until": [0.7, 0.9], "measure": ["gauss"]}
    surface = {"kind": "sphere", "radius": 1.0}
    scene = wr.Scene.parse({"surface": surface, "filaments": [grows], "time": TIME, "sweep": table})
    study = wr.sweep(scene, tmp_path / "study", device="cpu", part="1/1")
    assert study.points["computed"] == 3 and study.points["failed"] == 1
    assert "growth.until" in study.data["message"].to_numpy()[1, 0, 0]


def test_what_failed_is_tried_once_in_a_sweep_of_several_levels(tmp_path, monkeypatch):
    tried = []

    def failing(plan, point, device, folder):
        tried.append(point)
        raise MemoryError("too large")

    monkeypatch.setattr(points, "_alone", failing)
    monkeypatch.setattr(begin, "why_not", lambda *_: "of a test")
    table = {"swimmers.cell.bend": {"from": 1e-3, "to": 1e-2, "num": 2}, "seeds": 1, "refine": 2}
    study = wr.sweep(cells(table), tmp_path / "study", device="cpu", part=(1, 1))
    assert study.points["failed"] == len(set(tried)) and max(map(tried.count, tried)) == 2
    assert "MemoryError: too large" in study.data["message"].to_numpy().flat


@pytest.mark.parametrize("part", ["3/2", "a", (1,), (0, 3), 3, "1/2/3"])
def test_parts_are_numbers_of_so_many(part):
    with pytest.raises(SceneError, match=r"part = .*: must be i/n with 1 ≤ i ≤ n, such as 3/64"):
        wr.sweep(cells(), part=part)


def test_a_point_that_cannot_be_simulated_is_recorded_and_tried_again_later(whole, tmp_path, monkeypatch):
    real, tried = points.Simulation, []

    def failing(scene, device, *, seeds=()):
        bends = np.atleast_1d(scene.swimmers[0].bend)
        if len(seeds) > 8 or (bends > 5e-3).any():
            tried.append(len(bends))
            raise ValueError("no such luck")
        return real(scene, device, seeds=seeds)

    with monkeypatch.context() as patched:
        patched.setattr(points, "Simulation", failing)
        study = wr.sweep(cells(), tmp_path / "study", device="cpu", part=(1, 1))
    assert study.points == {
        "computed": 18,
        "failed": 6,
        **({"not settled": n} if (n := study.points.get("not settled")) else {}),
    }
    assert 1 in tried and max(tried) > 1
    data = study.data
    assert (data["state"].to_numpy()[3] == 3).all() and (data["state"].to_numpy()[:3] == 1).all()
    assert (
        data["message"].to_numpy()[3, 0, 0] == "ValueError: no such luck"
        and np.isnan(data["speed"].to_numpy()[3]).all()
    )
    assert len(plot_study(study.folder)) == 2
    again = wr.sweep(cells(), study.folder, device="cpu", part=(1, 1))
    assert not again.points.get("failed") and equal(again.data, whole.data)


def test_a_full_disk_is_told_and_nothing_finished_is_lost(whole, tmp_path, monkeypatch):
    """Every write fails from the nth on, in the midst of the files of a task."""
    monkeypatch.setattr(begin, "FEWEST", 1)
    real, writes = Store._encoded, []

    def full(self, name, values):
        writes.append(name)
        if len(writes) > 12:
            raise OSError(28, "No space left on device", "study.zarr")
        return real(self, name, values)

    with monkeypatch.context() as patched:
        patched.setattr(Store, "_encoded", full)
        with pytest.raises(StorageError, match=r"No space left on the disk of .* then run the same command again"):
            wr.sweep(cells(), tmp_path / "study", device="cpu", part=(1, 1))
    data = xr.open_zarr(tmp_path / "study" / "study.zarr").load()
    done = data["state"].to_numpy() == 1
    assert done.any() and not done.all()
    np.testing.assert_array_equal(data["speed"].to_numpy()[done], whole.data["speed"].to_numpy()[done])
    assert equal(wr.sweep(cells(), tmp_path / "study", device="cpu", part=(1, 1)).data, whole.data)


def test_trajectories_are_runs_of_their_own(tmp_path):
    scene = sensors(keep="trajectory")
    study = wr.sweep(scene, tmp_path / "study", device="cpu", part=(1, 1))
    data, plain = study.data, wr.sweep(sensors(), tmp_path / "plain", device="cpu", part=(1, 1)).data
    np.testing.assert_array_equal(data["gauss"], plain["gauss"])
    run = study.folder / str(data["trajectory"].to_numpy()[1, 0])
    assert run.name == "1-0" and (run / "checkpoint.npz").exists()
    gauss = wr.open_run(run)["sensors"]["gauss"][-1].mean().item()
    assert gauss == data["gauss"].to_numpy()[1, 0]


def test_a_point_whose_folder_another_process_writes_to_is_left_to_it(tmp_path):
    study = wr.sweep(sensors(keep="trajectory", seeds=[3]), tmp_path / "study", device="cpu", part=(1, 2))
    taken = study.folder / "trajectories" / "1-0"
    taken.mkdir()
    held = lock_folder(taken)
    assert wr.sweep(sensors(keep="trajectory", seeds=[3]), study.folder, device="cpu", part=(2, 2)).left == 1
    held.release()
    last = wr.sweep(sensors(keep="trajectory", seeds=[3]), study.folder, device="cpu", part=(2, 2))
    assert last.left == 0 and last.points == {"computed": 2}


def test_a_refined_study_is_finer_where_its_class_changes(tmp_path):
    sweep = {"swimmers.cell.bend": {"from": 1e-3, "to": 1e-2, "num": 3, "scale": "log"},
             "swimmers.cell.moment": [0.0], "refine": 1, "seeds": 1, "measure": ["speed", "class"]}  # fmt: skip
    study = wr.sweep(cells(sweep), tmp_path / "study", device="cpu", part=(1, 1))
    states = study.data["state"].to_numpy().ravel()
    assert states.size == 5 and states[::2].all() and states[1::2].any() and study.left == 0
    assert tasks.SCENE in {file.name for file in study.folder.iterdir()} and "refined once" in status(study.folder)
    assert {path.name for path in plot_study(study.folder)} == {"speed.png", "class.png"}


DEPENDENT = {
    "speed_distribution": ({}, "where rods move it has other values of v"),
    "density_map": ({}, "where rods move it has other values of x, y"),
    "mean_square_displacement": ({"time.end": [0.06, 0.1]}, "at the last point it has 10 lag in place of 6 lag"),
    "local_polar_order": ({"swimmers.cell.count": [2, 3]}, "at the last point it has 3 rod in place of 2 rod"),
}


@pytest.mark.parametrize("measure", DEPENDENT)
def test_a_measure_whose_dimensions_depend_on_the_point_is_refused_before_the_study_begins(measure, tmp_path):
    swept, said = DEPENDENT[measure]
    scene = cells({**swept, "measure": ["speed", measure]})
    why = f'sweep.measure[1] = "{measure}": {said}, and all points of a study have the same: leave it out'
    with pytest.raises(SceneError, match=re.escape(why)):
        wr.sweep(scene, tmp_path / "study", device="cpu", part=(1, 1))
    assert not (tmp_path / "study").exists()


def test_edges_of_bins_that_depend_on_the_point_are_kept_at_each(tmp_path):
    """The histogram of curvatures of spheres of two radii."""
    study = wr.sweep(sensors(**{"surface.radius": [1.0, 2.0], "seeds": 1, "measure": ["curvature_histogram"]}),
                     tmp_path / "study", device="cpu", part=(1, 1))  # fmt: skip
    data = study.data.isel(seed=0)
    low, high = (
        data[name].isel({"filaments.sensors.intrinsic.1": 0}).to_numpy() for name in ("gauss_low", "gauss_high")
    )
    middle = (low + high)[:, 10] / 2
    np.testing.assert_allclose(middle, [1.0, 0.25], rtol=1e-4)
    np.testing.assert_allclose(data["gauss_share"].sum("bin"), 1.0)


def test_measures_with_other_labels_of_one_dimension_are_not_in_one_study():
    one = Column("a", ("r",), (2,), {"r": [0.0, 1.0]})
    found = {"a": xr.DataArray(np.zeros((1, 2)), dims=("point", "r"), coords={"r": [0.0, 1.0]}),
             "b": xr.DataArray(np.zeros((1, 2)), dims=("point", "r"), coords={"r": [0.0, 2.0]})}  # fmt: skip
    assert columns_of({"a": found["a"]}, {"a": False})[0].misfit(found["a"]) == one.misfit(found["a"]) == ""
    with pytest.raises(SceneError, match=r"sweep.measure: a and b have other values of r: measure them in two studies"):
        columns_of(found, dict.fromkeys(found, False))

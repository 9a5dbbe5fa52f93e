"""The store of a study: labels, regions, whole files, what is left of a kill, and which points a refinement adds."""

import os
import signal
import threading
import time

import numpy as np
import pytest
import xarray as xr
from examples.study import cells

from warp_rods.errors import RunFolderError
from warp_rods.studies import marks
from warp_rods.studies.columns import Column
from warp_rods.studies.new_store import create
from warp_rods.studies.plan import Plan
from warp_rods.studies.refine import added, levels
from warp_rods.studies.store import OWN, STORE, Store
from warp_rods.studies.tasks import tasks_of

COLUMNS = [Column("class", text=True), Column("speed", attributes={"units": "length/time"}),
           Column("modes", ("component", "mode"), (2, 3), {"component": [1, 2], "mode": [0, 1, 2]})]  # fmt: skip
OF_ALL = [name for name in OWN if name != "trajectory"]


def store_of(plan: Plan, folder, chunk) -> Store:
    return create(folder / STORE, plan.axes, COLUMNS, chunk, OF_ALL, {"title": "t"}, {})


def test_results_are_labelled_and_read_by_xarray(tmp_path):
    plan = Plan(cells())
    store = store_of(plan, tmp_path, (3, 3, 2))
    assert store.dims == ("swimmers.cell.bend", "swimmers.cell.moment", "seed") and store.shape == (4, 3, 2)
    assert sorted(store.columns, key=lambda one: one.name) == sorted(COLUMNS, key=lambda one: one.name)
    assert len(list(store.chunks())) == 2
    points = [(3, 0, 1), (3, 2, 0)]
    values = {"state": [1, 2], "class": ["U", "flapping"], "speed": [0.5, np.nan], "modes": np.ones((2, 2, 3))}
    store.put((1, 0, 0), points, {k: np.array(v, dtype=object if k == "class" else None) for k, v in values.items()})
    data = xr.open_zarr(store.path, chunks=None)
    assert data.attrs["title"] == "t" and data["speed"].attrs["units"] == "length/time"
    here = data.sel({"swimmers.cell.bend": plan.axes[0].values[3], "swimmers.cell.moment": 0.0, "seed": 1})
    assert here["class"].item() == "U" and here["speed"].item() == 0.5 and here["state"].item() == 1
    assert here["modes"].sel(component=2, mode=1).item() == 1.0
    assert data["class"].sel(seed=0).to_numpy()[3, 2] == "flapping"
    assert (data["state"].to_numpy() > 0).sum() == 2 and np.isnan(data["speed"]).sum() == 23
    np.testing.assert_array_equal(store.states(), data["state"])
    store.put((1, 0, 0), [(3, 1, 1)], {"state": np.array([1]), "speed": np.array([2.0])})
    assert xr.open_zarr(store.path)["speed"].to_numpy()[3].tolist()[0][1] == 0.5  # others keep their values
    assert store.whole("class")[3, 0, 1] == "U" and store.whole("speed")[3, 1, 1] == 2.0
    files = [file for file in store.path.rglob("*") if file.is_file() and file.name != "zarr.json"]
    assert len(files) == 5 + len(values)  # labels, and one for each variable with values


def test_the_first_of_two_processes_makes_the_store(tmp_path):
    plan = Plan(cells())
    first, second = store_of(plan, tmp_path, (3, 3, 2)), store_of(plan, tmp_path, (1, 1, 1))
    assert first.chunk == second.chunk == (3, 3, 2) and os.listdir(tmp_path) == [STORE]
    with pytest.raises(RunFolderError, match="There is no study in"):
        _ = Store(tmp_path / "other" / STORE).attributes


def test_a_chunk_without_its_state_or_damaged_is_computed_again(tmp_path):
    plan = Plan(cells())
    store = store_of(plan, tmp_path, (3, 3, 2))
    for chunk in store.chunks():
        points = [tuple(p) for p in np.argwhere(np.ones(store.shape)) if (p[0] == 3) == (chunk[0] == 1)]
        store.put(chunk, [tuple(map(int, p)) for p in points], {"state": np.ones(len(points), dtype=np.int8)})
    assert not list(tasks_of(store, 0, plan.first(), store.states()))
    state = store.path / "state" / "c.1.0.0"
    state.write_bytes(state.read_bytes()[:-1] + b"x")
    (task,) = tasks_of(store, 0, plan.first(), store.states())
    assert task.chunk == (1, 0, 0) and len(task.points) == 6
    state.unlink()
    assert [task.chunk for task in tasks_of(store, 0, plan.first(), store.states())] == [(1, 0, 0)]
    old, new = (tmp_path / f".{STORE}.{name}.partial" for name in ("host-1", "host-2"))
    for file in (old, new):
        file.write_bytes(b"half")
    os.utime(old, (time.time() - 3600,) * 2)
    store.clear_leftovers()
    assert new.exists() and not old.exists()


def test_processes_that_do_the_same_task_point_by_point_lose_nothing(tmp_path, monkeypatch):
    """Each adds points in its order, and a mark that was left by a kill is passed over."""
    monkeypatch.setattr(marks, "STALE", 0.3)
    plan = Plan(cells())
    store = store_of(plan, tmp_path, plan.shape)
    places = [tuple(map(int, p)) for p in np.argwhere(plan.first())]
    mark = tmp_path / f".{STORE}.0.0.0.writing"
    mark.touch()

    def work(points) -> None:
        for point in points:
            store.put((0, 0, 0), [point], one(float(sum(point))))

    threads = [threading.Thread(target=work, args=(order,)) for order in (places[:14], places[::-1][:14])]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert (store.states() == 1).all() and not mark.exists()
    np.testing.assert_array_equal(store.whole("speed"), np.indices(plan.shape).sum(axis=0))


@pytest.mark.parametrize("missing", [False, True])
def test_points_in_a_damaged_file_are_computed_again(tmp_path, missing):
    """Whichever variable it is of: what was finished would be NaN otherwise, without a word."""
    plan = Plan(cells())
    store = create(tmp_path / STORE, plan.axes, [Column("speed")], (3, 3, 2), ["state"], {}, {})
    for chunk, point in (((0, 0, 0), (0, 0, 0)), ((1, 0, 0), (3, 0, 0))):
        store.put(chunk, [point], one(5.0))
    assert store.forget_damaged() == []
    file = store.path / "speed" / "c.0.0.0"
    file.unlink() if missing else file.write_bytes(file.read_bytes()[::-1])
    assert store.forget_damaged() == [file] and not file.exists()
    assert store.states()[[0, 3], 0, 0].tolist() == [0, 1] and store.whole("speed")[3, 0, 0] == 5.0
    assert [task.chunk for task in tasks_of(store, 0, plan.first(), store.states())] == [(0, 0, 0), (1, 0, 0)]


def one(speed: float, state: int = 1) -> dict[str, np.ndarray]:
    return {"state": np.array([state], np.int8), "speed": np.array([speed])}


def test_a_writer_that_was_stopped_for_long_spoils_nothing(tmp_path, monkeypatch):
    """Another one takes its place in the midst of its files; it notices, and adds its points to those of the other."""
    monkeypatch.setattr(marks, "STALE", 0.2)
    plan = Plan(cells())
    store = store_of(plan, tmp_path, plan.shape)
    encoded, stopped = Store._encoded, threading.Event()

    def slow(self, name, values):
        if threading.current_thread().name == "slow" and not stopped.is_set():
            stopped.set()
            other.start()
            other.join()
        return encoded(self, name, values)

    monkeypatch.setattr(Store, "_encoded", slow)
    other = threading.Thread(target=lambda: store.put((0, 0, 0), [(0, 0, 1)], one(7.0)))
    writer = threading.Thread(target=lambda: store.put((0, 0, 0), [(0, 0, 0)], one(5.0)), name="slow")
    writer.start()
    writer.join()
    assert store.states()[0, 0].tolist() == [1, 1] and store.whole("speed")[0, 0].tolist() == [5.0, 7.0]


def test_a_mark_that_does_not_fit_on_the_disk_is_not_left(tmp_path):
    """An empty file needs no space on a full disk, and its content does: others would wait for it for half a minute."""
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, hard))
    try:
        with pytest.raises(OSError), marks.alone(tmp_path / "mark"):
            raise AssertionError("it is held")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)
    assert not list(tmp_path.iterdir())


def test_what_is_finished_is_not_written_again(tmp_path):
    """Neither by who did the same, nor by who gives up; a point that failed may still be done."""
    plan = Plan(cells())
    store = store_of(plan, tmp_path, plan.shape)
    store.put((0, 0, 0), [(0, 0, 0)], one(5.0))
    store.put((0, 0, 0), [(0, 0, 0), (0, 0, 1)], {"state": np.array([3, 3], np.int8)})
    assert store.states()[0, 0].tolist() == [1, 3] and store.whole("speed")[0, 0, 0] == 5.0
    store.put((0, 0, 0), [(0, 0, 1)], one(7.0))
    assert store.states()[0, 0].tolist() == [1, 1]


def test_a_task_of_a_study_that_was_replaced_writes_nothing(tmp_path):
    plan = Plan(cells())

    def begun(word: str) -> Store:
        return create(tmp_path / STORE, plan.axes, COLUMNS, plan.shape, OF_ALL, {"study": word}, {}, True)

    old = begun("old")
    assert old.identity == "old"
    new = begun("new")
    assert new.identity == "new" and os.listdir(tmp_path) == [STORE]
    with pytest.raises(RunFolderError, match="was removed, or replaced by another study"):
        old.put((0, 0, 0), [(0, 0, 0)], one(5.0))
    assert not new.states().any()


@pytest.mark.parametrize("measure", ["class", "speed"])
def test_refinement_adds_points_where_neighbours_differ_and_nowhere_else(tmp_path, measure):
    """Inside and outside of a circle in a plane of two ranges: every new point is in a cell that its edge crosses."""
    line = {"from": -1.0, "to": 1.0, "num": 9}
    plan = Plan(cells({"swimmers.cell.bend": {"from": 1e-3, "to": 1e-1, "num": 9, "scale": "log"},
                       "swimmers.cell.moment": line, "seeds": 1, "refine": 3}))  # fmt: skip
    store = store_of(plan, tmp_path, plan.shape)
    x, y = np.meshgrid(np.linspace(-1, 1, 65), np.linspace(-1, 1, 65), indexing="ij")
    inside = (np.hypot(x, y) < 0.6)[..., None]
    values = {"class": np.where(inside, "U", "S").astype(object), "speed": np.where(inside, 1.0, 0.05 * x[..., None])}
    counts = []
    for level, mask in levels(plan, store):
        assert level == len(counts)
        states = store.states()
        new = [tuple(map(int, p)) for p in np.argwhere(mask & (states == 0))]
        counts.append(len(new))
        at = tuple(np.array(new).T)
        store.put((0, 0, 0), new, {"state": np.ones(len(new), np.int8), measure: values[measure][at]})
        if level:
            spacing = 0.25 * 0.5 ** (level - 1)  # of the cells that were divided
            assert np.abs(np.hypot(x, y)[at[:2]] - 0.6).max() < 2**0.5 * spacing
    states = store.states()
    fine = (states[..., 0] > 0) & (np.abs(np.hypot(x, y) - 0.6) < 1 / 64)
    assert counts[0] == 81 and fine.sum() == (np.abs(np.hypot(x, y) - 0.6) < 1 / 64).sum()  # the edge is found whole
    assert sum(counts) < 0.4 * states.size
    assert not added(plan, store, 1, np.zeros_like(states)).any()  # unknown cells are not divided


def test_refinement_looks_at_the_seeds_that_have_a_value(tmp_path):
    """A seed without a number hides no jump; points where no seed has one differ from those where some have."""
    plan = Plan(cells({"swimmers.cell.bend": {"from": 1e-3, "to": 9e-3, "num": 9}, "seeds": 2, "refine": 1,
                       "swimmers.cell.moment": [0.0]}))  # fmt: skip
    store = store_of(plan, tmp_path, plan.shape)
    points = [tuple(map(int, p)) for p in np.argwhere(plan.first())]
    place, seed = (np.array([point[k] for point in points]) for k in (0, 2))
    speed = np.where(place < 6, 0.0, 1.0)
    speed[(place == 4) & (seed == 1)] = np.nan
    speed[place == 16] = np.nan
    words = np.where((place == 12) & (seed == 1), "failed", "U").astype(object)
    store.put((0, 0, 0), points, {"state": np.ones(len(points), np.int8), "speed": speed, "class": words})
    new = added(plan, store, 1, store.states()) & ~plan.first()
    assert np.flatnonzero(new.any(axis=(1, 2))).tolist() == [5, 15]

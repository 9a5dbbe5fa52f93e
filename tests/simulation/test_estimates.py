"""Estimates of memory, disk and time against what is allocated and written; what does not fit is refused by its key."""

import dataclasses
import shutil
import subprocess
import sys
from collections import namedtuple

import numpy as np
import pytest
import warp as wp

from warp_rods.errors import SceneError
from warp_rods.scene.scene import Scene
from warp_rods.simulation import estimates, timing
from warp_rods.simulation.loop import Simulation
from warp_rods.simulation.run_folder import RunFolder
from warp_rods.simulation.runner import simulate

CELLS = {"name": "c", "count": 2, "nodes": 17, "bend": 1e-2, "twist": 1e-3}
FILAMENTS = {"name": "f", "count": 4, "nodes": 33, "length": 0.5, "stiffness": [1, 1, 1], "drag": [1, 2, 0.1]}
SPRINGS = {"name": "k", "count": 2, "nodes": 17, "stiffness": [1, 1, 1, 100, 50, 50]}
CALLED = {"swimmers": "swimmer", "filaments": "filament", "cosserat": "Cosserat rod"}
STERIC = {"strength": 1.0, "range": 0.01, "core": 0.08}
PLANE = {"kind": "plane", "size": 1000.0}


def scene(**tables) -> Scene:
    return Scene.parse({"time": {"end": 1.0}, **tables})


def rows(kind: str, count: int, nodes: int, steric: bool) -> Scene:
    """Rods side by side."""
    at = [[0.0, 0.5 * i, 0.0] for i in range(count)]
    tables = {"steric": STERIC} if steric else {}
    if kind == "swimmers":
        tables["swimmers"] = [CELLS | {"count": count, "nodes": nodes, "placement": {"position": at}}]
    elif kind == "cosserat":
        tables["cosserat"] = [SPRINGS | {"count": count, "nodes": nodes, "placement": {"position": at}}]
    else:
        placed = {"position": at, "direction": [[1.0, 0.0, 0.0]] * count}
        tables["filaments"] = [FILAMENTS | {"count": count, "nodes": nodes, "placement": placed}]
        tables["surface"] = PLANE
    return scene(**tables, output={"usd": False})


# --- memory -----------------------------------------------------------------------------------------------------------


def arrays_in(part) -> list[wp.array]:
    """Every device array in nested structs, dataclasses, lists and tables."""
    if isinstance(part, wp.array):
        return [part]
    if isinstance(part, (list, tuple)):
        inner = part
    elif isinstance(part, dict):
        inner = list(part.values())
    elif dataclasses.is_dataclass(part):
        inner = [getattr(part, f.name) for f in dataclasses.fields(part)]
    else:
        inner = [getattr(part, name) for name in part._cls.vars] if hasattr(part, "_cls") else []
    return [array for value in inner for array in arrays_in(value)]


def allocated(simulation: Simulation, on_gpu: bool) -> int:
    """Bytes of the arrays of ensembles and contact; on CUDA workspace has a row for each rod and not one for all."""
    parts = [e._arrays for e in simulation.ensembles.values()]
    if contact := simulation._surroundings.neighbours:
        parts += [contact._points, contact._sums, contact._lists]
    found = {id(a): a for a in arrays_in(parts)}
    total = 0
    for a in found.values():
        # There, too, a constant zero has no strides, and what is one number along a rod none along its nodes.
        shared = [on_gpu and any(a.strides), *[False] * (a.ndim - 1)]
        items = [n for n, stride, all_rods in zip(a.shape, a.strides, shared, strict=True) if stride or all_rods]
        total += int(np.prod(items, dtype=np.int64)) * wp.types.type_size_in_bytes(a.dtype)
    return total


@pytest.mark.parametrize("steric", [False, True])
@pytest.mark.parametrize("kind", ["swimmers", "filaments", "cosserat"])
def test_arrays_take_what_is_estimated_within_a_tenth(kind, steric):
    footprint = estimates.FOOTPRINTS[kind]
    few, many = (Simulation(rows(kind, 16, nodes, steric), "cpu") for nodes in (33, 97))
    for on_gpu, expected in ((False, footprint.arrays), (True, footprint.on_gpu)):
        each = (allocated(many, on_gpu) - allocated(few, on_gpu)) / (16 * 64)
        assert each == pytest.approx(expected + steric * footprint.contact, rel=0.1)


PEAK = """
import resource, sys, tempfile
from simulation.test_estimates import rows
from warp_rods.simulation.runner import simulate
scene = rows(sys.argv[1], int(sys.argv[2]), 33, True)
time = scene.time.model_copy(update={"end": 1e-7, "save_every": 1e-7})
simulate(scene.model_copy(update={"time": time}), tempfile.mkdtemp() + "/run", device="cpu")
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024))
"""


@pytest.mark.long
@pytest.mark.parametrize("kind", ["swimmers", "filaments", "cosserat"])
def test_the_peak_of_a_process_is_the_estimate_within_a_quarter(kind, request):
    def peak(count: int) -> float:
        command = [sys.executable, "-c", PEAK, kind, str(count)]
        tests = request.config.rootpath / "tests"
        done = subprocess.run(command, cwd=tests, capture_output=True, text=True, check=True)
        return float(done.stdout.splitlines()[-1])

    few, many = 10, 5000
    expected = estimates.memory(rows(kind, many, 33, True)) - estimates.memory(rows(kind, few, 33, True))
    assert peak(many) - peak(few) == pytest.approx(expected, rel=0.25)
    assert peak(few) < estimates.PROCESS * 1.1


@pytest.mark.parametrize("kind", estimates.FOOTPRINTS)
def test_the_page_on_runs_says_what_a_rod_takes(kind, request):
    footprint = estimates.FOOTPRINTS[kind]
    alone, steric = (
        (next(estimates.needs(rows(kind, 1, 35, with_steric))).rod - footprint.rod) / 35e3
        for with_steric in (False, True)
    )
    words = (
        f"A {CALLED[kind]} takes {alone:.2f} kB a node and {footprint.rod / 1e3:g} kB besides, with steric forces "
        f"{steric:.2f} kB a node."
    )
    assert words in (request.config.rootpath / "docs" / "runs.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("count", [10**5, 10**6, 10**7])
@pytest.mark.parametrize("kind", estimates.FOOTPRINTS)
def test_many_rods_are_refused_with_the_number_that_fits(kind, count, monkeypatch):
    """On a machine with 2 GB, before anything is placed."""
    monkeypatch.setattr(estimates, "memory_of_machine", lambda: 2e9)
    table = {"swimmers": CELLS, "filaments": FILAMENTS, "cosserat": SPRINGS}[kind] | {"nodes": 33}
    surface = {"surface": PLANE} if kind == "filaments" else {}

    def check(number: int) -> None:
        estimates.check_memory(scene(**{kind: [table | {"count": number}]}, **surface))

    with pytest.raises(SceneError, match=rf"{kind}\[0\].count = {count}, nodes = 33 need about") as caught:
        Simulation(scene(**{kind: [table | {"count": count}]}, **surface), "cpu")
    most = int("".join(str(caught.value).partition("at most about")[2].partition("rods")[0].split()))
    check(int(0.94 * most))
    with pytest.raises(SceneError, match="fit here"):
        check(int(1.06 * most))


def test_more_nodes_than_memory_are_refused_with_the_number_that_fits():
    tables = {"swimmers": [CELLS | {"count": 10**7, "nodes": 999}]}
    with pytest.raises(
        SceneError, match=r"swimmers\[0\]\.count = 10000000, nodes = 999 need about .* TB .*at most about"
    ):
        Simulation(scene(**tables), "cpu")
    with pytest.raises(SceneError) as caught:
        estimates.check_memory(scene(**tables))
    most = int("".join(str(caught.value).partition("at most about")[2].partition("rods")[0].split()))
    estimates.check_memory(scene(swimmers=[CELLS | {"count": int(0.9 * most), "nodes": 999}]))
    with pytest.raises(SceneError, match="fit here"):
        estimates.check_memory(scene(swimmers=[CELLS | {"count": int(1.2 * most), "nodes": 999}]))


def test_ensembles_share_the_memory(monkeypatch):
    table = CELLS | {"count": 1000}
    needed = estimates.memory(scene(swimmers=[table]))
    monkeypatch.setattr(estimates, "memory_of_machine", lambda: 1.2 * needed)
    estimates.check_memory(scene(swimmers=[table]))
    large = table | {"name": "d", "count": 100_000}
    with pytest.raises(SceneError, match=r"swimmers\[1\]\.count = 100000"):
        estimates.check_memory(scene(swimmers=[table, large]))


def test_more_neighbours_than_memory_are_refused():
    tables = {"surface": {"kind": "sphere", "radius": 1.0}, "filaments": [FILAMENTS | {"nodes": 99_999}]}
    with pytest.raises(
        SceneError, match=r"filaments\[0\]\.count = 4, nodes = 99999, with .* neighbours .* not one fits"
    ):
        Simulation(scene(**tables, steric=STERIC | {"range": 0.02}), "cpu")


def test_nodes_that_growth_inserts_count():
    table = FILAMENTS | {"growth": {"rate": 1.0, "until": 4.0, "spacing": 0.02}}
    assert estimates.nodes_at_end(scene(surface=PLANE, filaments=[table]).filaments[0]) == 8 * 32 + 1


def test_too_large_a_scene_is_refused_before_anything_is_imported_to_build_it():
    code = """
import sys
from warp_rods.scene.scene import Scene
from warp_rods.simulation.check_scene import check_memory
cell = {"name": "c", "count": 10**7, "nodes": 33, "bend": 1e-2, "twist": 1e-3}
try:
    check_memory(Scene.parse({"time": {"end": 1.0}, "swimmers": [cell]}))
except ValueError as error:
    print(error, *sorted({"scipy", "xarray", "zarr", "sympy"} & set(sys.modules)))
"""
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.strip().endswith("divide the scene")


def test_a_box_of_any_size_has_a_grid_of_cells():
    box = {"kind": "periodic", "size": [1e10, 1e10, 1e10]}
    simulation = Simulation(
        scene(swimmers=[CELLS | {"placement": "random"}], box=box, steric=STERIC | {"range": 0.02}), "cpu"
    )
    assert simulation.rods == 2


def test_an_animation_counts_up_to_the_size_above_which_it_is_made_in_parts():
    def memory(usd: bool, frames: int) -> float:
        time = {"end": 1.0, "save_every": 1.0 / frames}
        return estimates.memory(scene(swimmers=[CELLS | {"count": 100}], time=time, output={"usd": usd}))

    assert memory(False, 1000) == memory(False, 10)
    nodes = 100 * CELLS["nodes"]
    assert memory(True, 1000) - memory(False, 1000) == pytest.approx(50 * nodes * 1001, rel=1e-6)
    assert memory(True, 10**5) - memory(False, 10**5) == pytest.approx(0.625e9)


# --- disk -------------------------------------------------------------------------------------------------------------

OUTPUTS = [{}, {"output": {"variables": ["energy", "energy_density"], "frames_per_file": 7}}]


@pytest.mark.parametrize("tables", OUTPUTS)
def test_a_trajectory_has_the_bytes_that_are_estimated(tmp_path, tables):
    """To a byte, but for attributes of a group and arrays that do not grow."""
    both = scene(
        swimmers=[CELLS | {"count": 30, "nodes": 65}], surface={"kind": "sphere", "radius": 1.0}, **tables,
        filaments=[FILAMENTS], time={"end": 1e-4, "save_every": 1e-5},
    )  # fmt: skip
    simulate(both, tmp_path / "run", device="cpu")
    store = tmp_path / "run" / "trajectory.zarr"
    growing = {
        v
        for group in ("c", "f")
        for v in store.glob(f"{group}/*/c.*")
        if "frame" in (v.parent / "zarr.json").read_text()
    }
    written = sum(path.stat().st_size for path in growing)
    static = sum(8 * t.count * len(estimates_static()) for t in (*both.swimmers, *both.filaments))
    assert estimates.trajectory_bytes(both) - static == written
    whole = sum(p.stat().st_size for p in store.rglob("*") if p.is_file())
    assert estimates.trajectory_bytes(both) == pytest.approx(whole, abs=250e3)


def estimates_static() -> dict:
    from warp_rods.rods.variables import STATIC

    return STATIC


def test_a_run_that_does_not_fit_on_the_disk_is_refused_before_it_writes(tmp_path, monkeypatch):
    cells = scene(swimmers=[CELLS | {"count": 100}], time={"end": 1.0, "save_every": 1e-4})
    needed = estimates.disk_bytes(cells)
    free = namedtuple("Usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda where: free(10 * needed, 0, 0.25 * needed))
    folder = tmp_path / "a" / "run"
    with pytest.raises(
        SceneError, match=r"time\.save_every = 0\.0001: 10001 frames need about .* about 2500 frames fit"
    ):
        simulate(cells, folder, device="cpu")
    assert not folder.exists()
    monkeypatch.setattr(shutil, "disk_usage", lambda where: free(10 * needed, 0, 1.5 * needed))
    assert "save less often" in estimates.check_disk(cells, folder)[0]
    monkeypatch.setattr(shutil, "disk_usage", lambda where: free(10 * needed, 0, 2.5 * needed))
    assert not estimates.check_disk(cells, folder)


def test_a_run_that_is_replaced_leaves_its_room_to_the_new_one(tmp_path, monkeypatch):
    """What is there of a run is free for its rest, and for another one in its place; other files are not."""
    cells = scene(swimmers=[CELLS], time={"end": 1e-3, "save_every": 1e-4})
    simulate(cells, tmp_path / "run", device="cpu")
    needed, there = estimates.disk_bytes(cells), RunFolder.size(tmp_path / "run")
    (tmp_path / "run" / "notes").write_bytes(b"0" * 1000)
    assert there == RunFolder.size(tmp_path / "run") > 0.1 * needed
    free = namedtuple("Usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda where: free(10 * needed, 0, needed - 0.9 * there))
    with pytest.raises(SceneError, match="fit"):
        simulate(cells, tmp_path / "other", device="cpu")
    simulate(cells, tmp_path / "run", device="cpu", overwrite=True)


# --- time -------------------------------------------------------------------------------------------------------------

MOVING = {
    "fixed": {"swimmers": [CELLS | {"shape": {"amplitude": 3.0}}], "time": {"end": 0.02, "step": 1e-3}},
    "own": {"swimmers": [CELLS | {"shape": {"amplitude": 3.0}}], "time": {"end": 0.02}},
    "together": {
        "swimmers": [CELLS | {"placement": {"position": [[0, 0, 0], [0.1, 0.06, 0]]}}],
        "steric": {"strength": 1000.0, "range": 0.02, "core": 0.08}, "time": {"end": 0.002},
    },
}  # fmt: skip


@pytest.mark.parametrize("tables", MOVING.values(), ids=MOVING)
def test_telling_the_time_changes_no_bit(tables):
    def end(told: bool) -> np.ndarray:
        simulation = Simulation(Scene.parse(tables), "cpu")
        simulation.warm_up()
        if told:
            seconds, _ = timing.estimated_seconds(simulation)
            assert 0 < seconds < 60 and simulation.now == 0
        for _ in simulation.advance():
            pass
        return simulation.ensembles["c"].position

    np.testing.assert_array_equal(end(True), end(False))


def test_equal_steps_are_extrapolated(monkeypatch):
    """A million steps, of which each takes a tick of ten milliseconds."""
    simulation = Simulation(scene(swimmers=[CELLS], time={"end": 1000.0, "step": 1e-3, "save_every": 500.0}), "cpu")
    ticks = 0

    def exhaust(steps) -> None:
        nonlocal ticks
        ticks += len(steps)

    monkeypatch.setattr(timing.time, "perf_counter", lambda: 0.01 * ticks)
    monkeypatch.setattr(simulation.together, "advance", lambda dt, steps: range(steps))
    monkeypatch.setattr(timing, "exhaust", exhaust)
    seconds, basis = timing._equal(simulation, 1.0)
    assert seconds == pytest.approx(1e4) and basis == "by the first 63 steps"


def test_first_steps_that_are_divided_do_not_stand_for_all(monkeypatch):
    """Of a million steps the first one takes 300 ms, the next ones 1/n of that, and from the 16th on 10 ms each."""
    simulation = Simulation(scene(swimmers=[CELLS], time={"end": 1000.0, "step": 1e-3, "save_every": 500.0}), "cpu")
    taken, seconds = 0, 0.0

    def exhaust(steps) -> None:
        nonlocal taken, seconds
        for _ in steps:
            taken += 1
            seconds += 0.3 / taken if taken < 16 else 0.01

    monkeypatch.setattr(timing.time, "perf_counter", lambda: seconds)
    monkeypatch.setattr(simulation.together, "advance", lambda dt, steps: range(steps))
    monkeypatch.setattr(timing, "exhaust", exhaust)
    assert timing._equal(simulation, 1.5)[0] == pytest.approx(1e4, rel=0.05)


def test_steps_that_are_long_already_are_not_taken_to_become_shorter():
    """A rod at rest may change soonest of all, but holds nothing up."""
    cells = {"count": 2, "nodes": 17, "bend": [1e-9, 1e-2], "twist": 1e-3, "shape": {"kind": "straight"}}
    placement = {"position": [[0, 0, 0], [3, 0, 0]]}
    cells |= {"flagella": {"law": "held"}, "placement": placement, "name": "cells"}
    box = {"kind": "slab", "size": [8, 8], "height": 0.4}
    tables = {"swimmers": [cells], "box": box, "time": {"end": 1e9, "save_every": 1e7}}
    simulation = Simulation(Scene.parse(tables), "cpu")
    assert timing._settled_step(simulation) < 1e-6
    assert timing._settled_step(simulation, 1e5) == pytest.approx(min(1e5, simulation.together.longest), rel=1e-12)


def test_a_run_that_is_continued_is_told_how_long_its_rest_takes(tmp_path):
    """Of twenty steps ten are left; those before are not counted again."""
    given = [scene(swimmers=[CELLS], time={"end": end, "step": 1e-3, "save_every": 5e-3}) for end in (0.01, 0.02)]
    first = simulate(given[0], tmp_path / "run", device="cpu")
    assert any(line.endswith("1 s on this machine (by the first 10 steps)") for line in first.messages)
    rest = simulate(given[1], tmp_path / "run", device="cpu", resume=True)
    assert any(line.endswith("1 s more on this machine (by the first 10 steps)") for line in rest.messages)


@pytest.mark.parametrize(("size", "words"), [(10, "1 kB"), (4e6, "4 MB"), (2.94e10, "29 GB"), (3.2e16, "32 PB")])
def test_sizes_in_words(size, words):
    assert estimates.shown_bytes(size) == words

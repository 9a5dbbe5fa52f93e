"""The store of a run: round trip, and runs that were killed, which can be read up to their last complete frame."""

import json
import os
import signal
import subprocess
import sys
import time
import tracemalloc
import warnings
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
import zarr
from examples.earlier_store import write_earlier

from warp_rods.errors import RunFolderError
from warp_rods.simulation.reading import open_run
from warp_rods.simulation.trajectory import (
    FILAMENT_VARIABLES,
    STORE,
    SWIMMER_VARIABLES,
    GroupSpec,
    TrajectoryWriter,
    Variable,
)

WIDTH = (Variable(("rod",), "float64", "length", "rod width", ""), np.array([0.5, 0.6, 0.7]))
GROUPS = {
    "sensors": GroupSpec(3, 9, FILAMENT_VARIABLES, {"width": WIDTH}),
    "cell": GroupSpec(2, 17, SWIMMER_VARIABLES),
}
ATTRIBUTES = {"title": "two ensembles", "scene": "[time]\nend = 1.0\n", "seed": 7}


def frame(number: int) -> dict[str, dict[str, np.ndarray]]:
    """Values that identify frame and variable, and are exact in float32 and int32."""
    return {
        group: {
            name: np.arange(np.prod(spec.shape(variable))).reshape(spec.shape(variable)) + 1000.0 * number + k
            for k, (name, variable) in enumerate(spec.variables.items())
        }
        for group, spec in GROUPS.items()
    }


def write(path, numbers) -> TrajectoryWriter:
    writer = TrajectoryWriter.create(path / STORE, GROUPS, ATTRIBUTES)
    for number in numbers:
        writer.append(0.1 * number, frame(number))
    return writer


def check_frames(run: xr.DataTree, count: int) -> None:
    """Every variable of every group has ``count`` frames, with the values of ``frame``."""
    for group, spec in GROUPS.items():
        np.testing.assert_array_equal(run[group].time, 0.1 * np.arange(count))
        for name in spec.variables:
            expected = [frame(number)[group][name] for number in range(count)]
            np.testing.assert_array_equal(run[group][name], np.reshape(expected, run[group][name].shape))
            assert run[group][name].sizes["frame"] == count


def test_round_trip_with_names_units_and_types(tmp_path):
    write(tmp_path, range(70)).close()  # more than the frames by which arrays grow at once
    run = open_run(tmp_path)
    check_frames(run, 70)
    assert run.attrs["title"] == "two ensembles"
    assert run.attrs["scene"] == ATTRIBUTES["scene"]
    assert run.attrs["warp_rods_version"]
    sensors = run["sensors"]
    named = {"axis": 3, "strain_component": 3, "quaternion": 4, "end": 2}
    assert dict(sensors.sizes) == {"frame": 70, "rod": 3, "node": 9, **named}
    assert sensors.end_load.dims == ("frame", "rod", "end", "axis")
    assert sensors.end_load.sel(end="last").equals(sensors.end_load[:, :, 1])
    assert sensors.position.dims == ("frame", "rod", "node", "axis")
    assert sensors.strain.dims == ("frame", "rod", "node", "strain_component")
    assert sensors.position.dtype == np.float64
    assert sensors["load"].dtype == np.float32
    assert sensors.status.dtype == np.int32
    assert sensors.energy.attrs["units"] == "force*length"
    assert sensors.energy.attrs["source"]
    np.testing.assert_array_equal(sensors["width"], WIDTH[1])
    np.testing.assert_allclose(sensors.s, np.linspace(-0.5, 0.5, 9), rtol=0, atol=1e-16)
    assert set(sensors.coords) == {"time", "s", *named}
    assert "activity" in run["cell"] and "gauss" not in run["cell"]


def test_components_have_names(tmp_path):
    """Axes of space, strains by kind of rod, quaternions with the real part last."""
    write(tmp_path, range(2)).close()
    run = open_run(tmp_path)
    assert {tuple(run[group].axis.to_numpy()) for group in GROUPS} == {("x", "y", "z")}
    assert run["sensors"].strain_component.values.tolist() == ["twist", "normal", "geodesic"]
    assert run["cell"].strain_component.values.tolist() == ["twist", "bend1", "bend2"]
    assert run["cell"].orientation.sel(quaternion="w").equals(run["cell"].orientation[..., 3])
    assert run["sensors"].strain.sel(strain_component="geodesic").equals(run["sensors"].strain[..., 2])


@pytest.mark.parametrize("labels", [True, False])
def test_a_trajectory_of_an_earlier_version_opens_with_present_names(tmp_path, labels):
    """Lazily, with the same dimensions and labels; and an earlier run can be resumed, at any number of its frames."""
    write(tmp_path / "now", range(5)).close()
    frames = [{name: {**values, "time": 0.1 * n} for name, values in frame(n).items()} for n in range(4)]
    write_earlier(tmp_path / "earlier", GROUPS, ATTRIBUTES, frames, labels)
    check_frames(open_run(tmp_path / "earlier"), 4)
    writer = TrajectoryWriter.resume(tmp_path / "earlier" / STORE, 3)
    check_frames(open_run(tmp_path / "earlier"), 3)
    for number in (3, 4):
        writer.append(0.1 * number, frame(number))
    check_frames(open_run(tmp_path / "earlier"), 5)
    writer.close()
    now, earlier = open_run(tmp_path / "now"), open_run(tmp_path / "earlier")
    assert not earlier["cell"].strain.variable._in_memory
    for group in GROUPS:
        xr.testing.assert_identical(earlier[group].to_dataset(), now[group].to_dataset())
    if labels:
        plain = xr.open_datatree(tmp_path / "earlier" / STORE, engine="zarr")
        assert plain["sensors"].to_dataset().equals(now["sensors"].to_dataset())


def test_each_group_has_the_scene_as_an_attribute(tmp_path):
    write(tmp_path, range(1)).close()
    assert {open_run(tmp_path)[group].attrs["scene"] for group in GROUPS} == {ATTRIBUTES["scene"]}


@pytest.mark.parametrize("together", [2, 3, 7, 11])
def test_frames_written_together_make_the_files_of_frames_written_alone(tmp_path, together):
    """With borders of files within a batch; a frame that waits is not seen, and may change after it was given."""
    groups = {name: replace(spec, frames_per_file=4) for name, spec in GROUPS.items()}
    alone, other = (TrajectoryWriter.create(tmp_path / name / STORE, groups, ATTRIBUTES) for name in ("one", "two"))
    for number in range(11):
        alone.append(0.1 * number, frame(number))
        given = frame(number)
        other.hold(0.1 * number, given)
        for values in (values for group in given.values() for values in group.values()):
            values[...] = -7
        assert other.bytes_held > 0 and other.frames == number - number % together
        if (number + 1) % together == 0:
            other.write()
            check_frames(open_run(tmp_path / "two"), number + 1)
            assert other.bytes_held == 0
    alone.close()
    other.close()  # which writes those that still wait
    files = [
        {
            file.relative_to(tmp_path / name): file.read_bytes()
            for file in (tmp_path / name).rglob("*")
            if file.is_file()
        }
        for name in ("one", "two")
    ]
    assert files[0] == files[1]
    check_frames(open_run(tmp_path / "two"), 11)


def test_memory_does_not_grow_with_the_number_of_frames(tmp_path):
    """A trajectory is streamed: nothing of a frame is kept once it is written."""
    writer = write(tmp_path, range(1))
    large = {group: {name: np.array(v, float) for name, v in values.items()} for group, values in frame(1).items()}
    held = []
    tracemalloc.start()
    for _ in range(8):
        for _ in range(50):
            writer.hold(0.1 * writer.frames, large)
        waiting = writer.bytes_held
        writer.write()
        held.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert writer.frames == 401 and max(held[2:]) - held[1] < 0.1 * waiting


def test_metadata_and_files_are_those_that_zarr_writes(tmp_path):
    """Of labels, values that are all equal or infinite or neither, frames in shards, and several frames in a chunk."""
    space = Variable(("axis",), "float64", "length", "period of the box", "", ("x", "y", "z"))
    static = {"width": WIDTH, "period": (space, np.full(3, np.inf)), "size": (space, np.array([2.0, 2.0, 2.0]))}
    spec = GroupSpec(3, 9, SWIMMER_VARIABLES, static)
    TrajectoryWriter.create(tmp_path / STORE, {"cell": spec}, ATTRIBUTES).close()
    ours = json.loads((tmp_path / STORE / "zarr.json").read_text())["consolidated_metadata"]["metadata"]
    group = zarr.create_group(tmp_path / "theirs").create_group("cell", attributes=ours["cell"]["attributes"])
    for name, node in ours.items():
        if name == "cell":
            continue
        own = zarr.open_array(tmp_path / STORE / name, mode="r")
        in_file = {"shards": {"shape": own.shards, "index_location": "start"}} if own.shards else {}
        made = group.create_array(
            name.removeprefix("cell/"), shape=own.shape, dtype="str" if node["data_type"] == "string" else own.dtype,
            chunks=own.chunks, **in_file, fill_value=own.fill_value, compressors=[zarr.codecs.Crc32cCodec()],
            chunk_key_encoding={"name": "default", "separator": "."}, dimension_names=node["dimension_names"],
            attributes=node["attributes"], config={"write_empty_chunks": (tmp_path / STORE / name / "c.0").exists()},
        )  # fmt: skip
        made[...] = own[...]
        assert json.loads((tmp_path / "theirs" / name / "zarr.json").read_text()) == node, name
        files = {file.name: file.read_bytes() for file in (tmp_path / STORE / name).glob("c*")}
        assert files == {file.name: file.read_bytes() for file in (tmp_path / "theirs" / name).glob("c*")}, name


@pytest.mark.long
@pytest.mark.parametrize("how", [{}, {"consolidated": True}, {"consolidated": False}], ids=str)
@pytest.mark.parametrize("frames", [5, 150])
def test_xarray_opens_the_store_with_the_same_contents(tmp_path, how, frames):
    """Without a warning, as a whole or a group at a time; except for the scene, an attribute of the root only."""
    write(tmp_path, range(frames)).close()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        direct = xr.open_datatree(tmp_path / STORE, engine="zarr", **how)
        alone = {name: xr.open_dataset(tmp_path / STORE, engine="zarr", group=name, **how) for name in GROUPS}
    for group in GROUPS:
        whole = direct[group].to_dataset().assign_attrs(scene=direct.attrs["scene"])
        xr.testing.assert_identical(whole, open_run(tmp_path)[group].to_dataset())
        xr.testing.assert_identical(alone[group], direct[group].to_dataset())


def test_xarray_opens_a_run_in_progress_up_to_its_last_complete_frame(tmp_path):
    """Without a warning, at every frame, with the values of ``frame``."""
    writer = write(tmp_path, [])
    for number in range(12):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_frames(xr.open_datatree(tmp_path / STORE, engine="zarr"), number)
        writer.append(0.1 * number, frame(number))


LOOKS = 60


@pytest.mark.long
def test_many_looks_with_xarray_while_a_process_writes(tmp_path):
    """Every look finds whole frames in all groups, and more of them as time goes on."""
    with writing_process(tmp_path) as child:
        seen = []
        for _ in range(LOOKS):
            plain = xr.open_datatree(tmp_path / STORE, engine="zarr")
            counts = {plain[group].sizes["frame"] for group in GROUPS}
            assert len(counts) == 1
            seen += counts
            last = seen[-1] - 1
            for group in GROUPS:
                for name in ("position", "energy", "status"):
                    expected = frame(last)[group][name]
                    np.testing.assert_array_equal(plain[group][name][-1], expected)
        os.kill(child.pid, signal.SIGKILL)
    assert seen == sorted(seen) and seen[-1] > seen[0]


def test_reads_lazily_and_by_parts(tmp_path):
    write(tmp_path, range(6))
    position = open_run(tmp_path)["sensors"].position
    everything = np.stack([frame(n)["sensors"]["position"] for n in range(6)])
    for part in [
        np.s_[[4, 1], ::2, -1],
        np.s_[-1],
        np.s_[[-1, 0], 1:],
        np.s_[::-2, :, 3:1:-1],
        np.s_[2:100, 0],
    ]:
        assert not position.variable._in_memory
        np.testing.assert_array_equal(position[part], everything[part])


def test_a_run_in_progress_can_be_read(tmp_path):
    writer = write(tmp_path, range(3))
    check_frames(open_run(tmp_path), 3)
    writer.append(0.1 * 3, frame(3))
    check_frames(open_run(tmp_path), 4)


@pytest.mark.parametrize("kept", [0, 3, 5])
def test_resume_removes_later_frames_and_continues(tmp_path, kept):
    write(tmp_path, range(5))
    writer = TrajectoryWriter.resume(tmp_path / STORE, kept)
    assert writer.frames == kept
    check_frames(open_run(tmp_path), kept)
    for number in range(kept, 8):
        writer.append(0.1 * number, frame(number))
    writer.close()
    check_frames(open_run(tmp_path), 8)


@pytest.mark.parametrize("stopped_at", ["position", "energy", "time"])
def test_an_incomplete_frame_is_ignored_and_overwritten(tmp_path, stopped_at):
    """A store whose frame 2 was only partly written: a part of a frame in a shard, or a chunk that holds it already."""
    write(tmp_path, range(2))
    if stopped_at == "position":
        [file] = (tmp_path / STORE / "sensors" / stopped_at).glob("c*")
        with file.open("ab") as shard:
            shard.write(b"c" * 40)
    else:
        incomplete = zarr.open_group(tmp_path / STORE)["sensors"][stopped_at]
        incomplete.resize((200, *incomplete.shape[1:]))
        incomplete[2] = 99
    check_frames(open_run(tmp_path), 2)
    writer = TrajectoryWriter.resume(tmp_path / STORE)
    writer.append(0.1 * 2, frame(2))
    check_frames(open_run(tmp_path), 3)


@contextmanager
def writing_process(folder):
    """A process that writes frames without a pause, with the first one written."""
    code = (
        "import itertools, sys; sys.path.insert(0, sys.argv[1])\n"
        "from pathlib import Path; from test_trajectory import frame, write\n"
        "writer = write(Path(sys.argv[2]), [0])\n"
        "print('first frame', flush=True)\n"
        "for n in itertools.count(1): writer.append(0.1 * n, frame(n))"
    )
    here = os.path.dirname(__file__)
    command = [sys.executable, "-c", code, here, str(folder)]
    paths = os.pathsep.join([os.path.dirname(here), os.environ.get("PYTHONPATH", "")])
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": paths}) as child:
        assert child.stdout.readline() == "first frame\n"
        yield child


@pytest.mark.long
def test_a_killed_run_is_read_up_to_its_last_complete_frame(tmp_path):
    """Killed with SIGKILL at several times while it writes without a pause."""
    for attempt, pause in enumerate((0.0, 0.05, 0.11)):
        folder = tmp_path / str(attempt)
        with writing_process(folder) as child:
            time.sleep(pause)
            os.kill(child.pid, signal.SIGKILL)
        complete = open_run(folder)["cell"].sizes["frame"]
        assert complete >= 1
        check_frames(open_run(folder), complete)
        check_frames(xr.open_datatree(folder / STORE, engine="zarr"), complete)
        writer = TrajectoryWriter.resume(folder / STORE)
        assert writer.frames == complete
        writer.append(0.1 * complete, frame(complete))
        writer.close()
        check_frames(open_run(folder), complete + 1)


def test_frames_that_do_not_fit_are_refused_before_anything_is_written(tmp_path):
    writer = write(tmp_path, range(1))
    short = frame(1)
    short["cell"]["energy"] = np.zeros(3)
    with pytest.raises(ValueError, match=r"cell/energy: shape \(3,\), declared \(2,\)"):
        writer.append(0.1, short)
    missing = frame(1)
    del missing["sensors"]["gauss"]
    with pytest.raises(ValueError, match="variables of sensors"):
        writer.append(0.1, missing)
    with pytest.raises(ValueError, match="groups"):
        writer.append(0.1, {"sensors": frame(1)["sensors"]})
    check_frames(open_run(tmp_path), 1)


def test_folders_without_a_run(tmp_path):
    with pytest.raises(RunFolderError, match=f"(?s){tmp_path}.*warp-rods run"):
        open_run(tmp_path)
    with pytest.raises(RunFolderError, match="no run"):
        TrajectoryWriter.resume(tmp_path / STORE)
    zarr.create_group(tmp_path / "other" / STORE)
    with pytest.raises(RunFolderError, match="not a trajectory"):
        open_run(tmp_path / "other")
    (tmp_path / "broken" / STORE).mkdir(parents=True)
    (tmp_path / "broken" / STORE / "zarr.json").write_text("{")
    with pytest.raises(RunFolderError, match="cannot be read"):
        open_run(tmp_path / "broken")


def test_a_store_is_never_overwritten(tmp_path):
    write(tmp_path, range(2)).close()
    with pytest.raises(RunFolderError, match="exists already"):
        write(tmp_path, range(1))
    check_frames(open_run(tmp_path), 2)
    with pytest.raises(RunFolderError, match="has 2 complete frames, 3 are needed"):
        TrajectoryWriter.resume(tmp_path / STORE, 3)

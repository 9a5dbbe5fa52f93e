"""The state of a run as another process sees it, while it runs, when it was killed, and when it is done."""

import json
import subprocess
import sys
import time

import pytest
from rich.console import Console

import warp_rods as wr
from warp_rods.draw import watch
from warp_rods.simulation.status import RunStatus, State, exit_code, status_of
from warp_rods.simulation.under_way import (
    LOCK,
    UNDER_WAY,
    Telling,
    UnderWay,
    is_under_way,
    lock_folder,
    telling_what_is_made,
)

LONG = """
title = "Long"
[[swimmers]]
name = "cells"
count = 3
nodes = 17
bend = 5e-3
twist = 1e-3
[time]
end = 1e4
step = 1e-3
save_every = 0.05
"""


def wait_for(condition, seconds=120):
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.05)


@pytest.fixture
def running(tmp_path):
    """The folder of a run in another process that would take hours."""
    (tmp_path / "long.toml").write_text(LONG)
    folder = tmp_path / "run"
    command = [sys.executable, "-m", "warp_rods", "run", "long.toml", "--out", str(folder), "--device", "cpu"]
    with (tmp_path / "log").open("w") as log:
        process = subprocess.Popen(command, cwd=tmp_path, stdout=log, stderr=log)
    try:
        wait_for(lambda: (told := UnderWay.read(folder)) is not None and told.time > 0.1)
        yield folder, process
    finally:
        process.kill()
        process.wait()


def test_a_run_is_watched_from_another_process(running, monkeypatch, capsys):
    folder, process = running
    status = status_of(folder)
    assert status.state is State.RUNNING and exit_code([status]) == 4
    assert 0 < status.time < 1e4 and status.end == 1e4 and status.all_frames == 200_001 and status.frames > 1
    assert status.rods == {"cells": 3} and status.lost == {"cells": 0}
    told = UnderWay.read(folder)
    assert told.seconds_left(1e4) == pytest.approx(told.seconds * (1e4 - told.time) / told.time)
    assert told.rod_steps == pytest.approx(3 * told.time / 1e-3, rel=0.05)  # the first steps are divided
    assert is_under_way(folder)
    with pytest.raises(wr.RunFolderError, match="another run is writing"):
        lock_folder(folder)
    view = Console(width=100, height=30, force_terminal=True, record=True, file=sys.stdout)
    view.print(watch._view(status, view))
    shown = view.export_text()
    for part in ("Long", "running", "rod-steps/s", "left", "cells", "mean energy", "→", "along"):
        assert part in shown
    assert any(0x2800 < ord(character) < 0x2900 for character in shown)
    monkeypatch.setattr(watch, "LOOK_EVERY", 0.05)
    monkeypatch.setattr(watch, "LINE_EVERY", 0.1)
    lines, console = [], Console(file=sys.stdout, width=300)

    def printed(text, **_):
        lines.append(str(text))
        if len(lines) == 3:
            process.kill()

    monkeypatch.setattr(console, "print", printed)
    last = watch.watch(folder, console)
    assert len(lines) >= 4 and all("running" in line and "left" in line for line in lines[1:3])
    assert last.state is State.STOPPED and "killed" in lines[-1] and exit_code([last]) == 1
    assert last.time == pytest.approx(0.05 * (last.frames - 1))
    assert (folder / UNDER_WAY).exists()  # it was killed
    lock_folder(folder).release()
    assert not (folder / UNDER_WAY).exists()  # nor would a run that begins here seem to be that far


def test_a_finished_run(tmp_path):
    table = {"name": "cells", "count": 2, "nodes": 17, "bend": 5e-3, "twist": 1e-3}
    run = wr.run(wr.Scene(swimmers=[table], time={"end": 0.02, "save_every": 0.01}), tmp_path / "run", device="cpu")
    before = {path: path.stat().st_mtime_ns for path in run.folder.rglob("*")}
    status = status_of(run.folder)
    assert {path: path.stat().st_mtime_ns for path in run.folder.rglob("*")} == before  # it only reads
    assert status.state is State.FINISHED and status.fraction == 1 and status.frames == status.all_frames == 3
    assert not (run.folder / UNDER_WAY).exists() and exit_code([status]) == 0
    text = watch.line(status).plain
    assert "finished  100 %  3 of 3 frames  t = 0.02 of 0.02  0 of 2 rods lost" in text
    with lock_folder(run.folder):
        with telling_what_is_made(run.folder, "animation"):
            made = status_of(run.folder)
        assert made.state is State.RUNNING and made.cells()[-1].endswith("rods lost, its animation is being made")
        assert made.speed is made.seconds_left is None and made.time == made.end
        assert status_of(run.folder).why == ""
    (run.folder / "trajectory.zarr" / "zarr.json").write_text("{}")
    damaged = status_of(run.folder)
    assert damaged.state is State.DAMAGED and exit_code([status, damaged]) == 2 and "damaged" in damaged.why


def test_a_run_that_a_hook_ended_says_why(tmp_path):
    def stop(simulation):
        simulation.stop("enough")

    table = {"name": "cells", "count": 2, "nodes": 17, "bend": 5e-3, "twist": 1e-3}
    scene = wr.Scene(swimmers=[table], time={"end": 0.02, "save_every": 0.01}, output={"usd": False})
    folder = wr.run(scene, tmp_path / "run", device="cpu", hooks=[(wr.every(time=0.01), stop)]).folder
    status = status_of(folder)
    assert status.state is State.STOPPED and "enough" in status.why and status.frames < 3


def test_folders_without_a_run(tmp_path):
    with pytest.raises(wr.RunFolderError, match="There is no run in"):
        status_of(tmp_path)
    assert list(tmp_path.iterdir()) == []
    (tmp_path / ".trajectory.zarr.new").mkdir()
    assert "begins it anew" in status_of(tmp_path).why


def test_looking_at_a_folder_never_stops_a_run_from_beginning(tmp_path):
    """A look holds a shared lock for some microseconds; a run that begins in them waits."""
    fcntl = pytest.importorskip("fcntl")
    (tmp_path / LOCK).touch()
    import threading

    with (tmp_path / LOCK).open() as looked_at:
        fcntl.flock(looked_at, fcntl.LOCK_SH)
        threading.Timer(0.1, lambda: fcntl.flock(looked_at, fcntl.LOCK_UN)).start()
        lock_folder(tmp_path).release()


def test_what_is_told_goes_with_the_run_and_may_fail(tmp_path):
    with Telling(tmp_path, 0.5) as others:
        others.tell(1.5, 100)
        told = UnderWay.read(tmp_path)
        assert (told.time, told.first, told.rod_steps) == (1.5, 0.5, 100)
        others.tell(2.0, 200)  # within a second: not yet
        assert UnderWay.read(tmp_path) == told
    assert not (tmp_path / UNDER_WAY).exists() and UnderWay.read(tmp_path) is None
    (tmp_path / UNDER_WAY).write_text(json.dumps({"time": 1.0})[:-3])
    assert UnderWay.read(tmp_path) is None
    with Telling(tmp_path / "gone", 0.0) as others:
        others.tell(1.0, 1)
    assert (
        UnderWay(3.0, 1.0, 10.0, 0).seconds_left(5.0) == 10.0 and UnderWay(1.0, 1.0, 9.0, 0).seconds_left(5.0) is None
    )


@pytest.mark.parametrize(
    ("states", "lost", "code"),
    [
        (["finished"], 0, 0), (["finished"], 2, 3), (["running", "finished"], 0, 4), (["running"], 2, 3),
        (["stopped", "running"], 2, 1), (["damaged", "stopped"], 0, 2), (["no run"], 0, 2),
    ],
)  # fmt: skip
def test_exit_codes(tmp_path, states, lost, code):
    assert exit_code([RunStatus(tmp_path, State(state), lost={"a": lost}) for state in states]) == code

"""Studies on clusters whose parts are killed, stopped or slow: nothing finished is lost, nothing has other bits."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from examples.study import cells

import warp_rods as wr
from warp_rods.simulation.storage import StorageError
from warp_rods.studies import begin, dispatch
from warp_rods.studies.status import status

TESTS = str(Path(__file__).parents[1])
LONGER = {"swimmers.cell.bend": {"from": 1e-4, "to": 1e-2, "num": 6, "scale": "log"}, "measure": ["speed", "class"]}
"""36 points."""


def study_scene():
    return cells(LONGER, time={"end": 0.4, "save_every": 0.02})


@pytest.fixture(scope="module")
def expected(tmp_path_factory) -> xr.Dataset:
    return wr.sweep(study_scene(), tmp_path_factory.mktemp("whole") / "study", device="cpu", part=(1, 1)).data.load()


@pytest.fixture(autouse=True)
def _small_tasks(monkeypatch):
    monkeypatch.setattr(begin, "FEWEST", 1)
    monkeypatch.setattr(begin, "SECONDS", 0.1)


def check(folder: Path, expected: xr.Dataset) -> None:
    found = xr.open_zarr(folder / "study.zarr").load()
    assert (found["state"] == 1).all()
    for name in expected.data_vars:
        equal_nan = expected[name].dtype.kind == "f"
        assert np.array_equal(found[name].to_numpy(), expected[name].to_numpy(), equal_nan=equal_nan), name


def finished(folder: Path) -> int:
    return len(list((folder / "study.zarr" / "state").glob("c.*")))


def when(folder: Path, tasks: int, act, seconds: float = 300.0) -> threading.Thread:
    """Act once so many tasks are finished."""

    def watch() -> None:
        end = time.monotonic() + seconds
        while finished(folder) < tasks and time.monotonic() < end:
            time.sleep(0.005)
        act()

    thread = threading.Thread(target=watch)
    thread.start()
    return thread


def children(process: int) -> list[int]:
    """Workers that a process has started."""
    import psutil

    found = psutil.Process(process).children(recursive=True)
    return [one.pid for one in found if any("spawn_main" in word for word in one.cmdline())]


def test_a_worker_of_two_is_killed(tmp_path, expected):
    """Its task is done by the other, or by the process that replaces it."""
    folder, killed = tmp_path / "study", []

    def kill() -> None:
        killed.append(children(os.getpid())[0])
        os.kill(killed[0], signal.SIGKILL)

    thread = when(folder, 2, kill)
    study = wr.sweep(study_scene(), folder, device="cpu", workers=2)
    thread.join()
    assert killed and study.left == 0 and not study.points.get("failed")
    check(folder, expected)


def client(
    folder: Path, *, scheduler: str | None = None, part: str = "", host: tuple[str, ...] = ()
) -> subprocess.Popen:
    """A process that does a study, as the command line does, with small tasks."""
    how = f"scheduler={scheduler!r}" if scheduler else part
    code = (
        f"import sys; sys.path.insert(0, {TESTS!r}); sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from test_cluster import study_scene, begin, wr\nbegin.FEWEST, begin.SECONDS = 1, 0.1\n"
        f"if __name__ == '__main__': wr.sweep(study_scene(), {str(folder)!r}, device='cpu', {how})\n"
    )
    return subprocess.Popen(
        [*host, sys.executable, "-c", code], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
    )


def test_the_client_is_killed_and_started_again(tmp_path, expected):
    folder = tmp_path / "study"
    process = client(folder, part="part=(1, 1)")
    when(folder, 3, process.kill).join()
    assert process.wait() == -signal.SIGKILL
    done = xr.open_zarr(folder / "study.zarr").load()
    kept = done["state"].to_numpy() == 1
    assert kept.any() and not kept.all() and re.search(r"of 36 points done \(", status(folder))
    np.testing.assert_array_equal(done["speed"].to_numpy()[kept], expected["speed"].to_numpy()[kept])
    stamps = {file: file.stat().st_mtime_ns for file in (folder / "study.zarr" / "state").glob("c.*")}
    wr.sweep(study_scene(), folder, device="cpu", part=(1, 1))
    check(folder, expected)
    assert all(file.stat().st_mtime_ns == stamp for file, stamp in stamps.items())  # finished tasks are not done again


@pytest.fixture
def disk(tmp_path):
    """A small file system of its own; mounting one needs the rights of root."""
    place = tmp_path / "disk"
    place.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", place], capture_output=True, text=True)
    if done.returncode:
        pytest.skip(f"no file system can be mounted here: {done.stderr.strip()}")
    yield place
    subprocess.run(["umount", place], check=True)


def fill(place: Path) -> None:
    """Leave no space on a file system."""
    with (place / "filler").open("wb", buffering=0) as file:
        try:
            while True:
                file.write(b"0" * 4096)
        except OSError:
            pass


@pytest.mark.parametrize("how", [{"part": (1, 1)}, pytest.param({"workers": 2}, marks=pytest.mark.long)])
def test_the_disk_becomes_full(disk, expected, how):
    folder = disk / "study"
    thread = when(folder, 2, lambda: fill(disk))
    with pytest.raises(StorageError, match=r"No space left on the disk of .* run the same command again"):
        wr.sweep(study_scene(), folder, device="cpu", **how)
    thread.join()
    assert finished(folder) > 0
    (disk / "filler").unlink()
    wr.sweep(study_scene(), folder, device="cpu", part=(1, 1))
    check(folder, expected)


# --- a scheduler and workers as separate processes -------------------------------------------------------------------


class Cluster:
    """`dask scheduler` and `dask worker` as processes of their own, each on a host, a command before theirs."""

    def __init__(self, count: int, ip: str = "127.0.0.1", hosts: tuple[tuple[str, ...], ...] = ((),)):
        self.scheduler = self._start(hosts[0], "scheduler", "--host", ip, "--port", "0", "--no-dashboard")
        self.address = self._said(self.scheduler, rf"(tcp://{re.escape(ip)}:\d+)")
        self.workers = [self.worker(hosts[number % len(hosts)]) for number in range(count)]

    def worker(self, host: tuple[str, ...] = ()) -> subprocess.Popen:
        started = self._start(host, "worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
        self._said(started, "Registered to")
        return started

    def _start(self, host: tuple[str, ...], *arguments: str) -> subprocess.Popen:
        command = [*host, sys.executable, "-m", "distributed.cli.dask_" + arguments[0], *arguments[1:]]
        return subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)

    def _said(self, process: subprocess.Popen, pattern: str) -> str:
        assert process.stderr is not None
        for line in process.stderr:
            if found := re.search(pattern, line):
                threading.Thread(target=process.stderr.read, daemon=True).start()
                return found[0]
        raise AssertionError(f"{process.args} ended")

    def close(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.send_signal(signal.SIGCONT)
            process.kill()
            process.wait()


@pytest.fixture
def outside():
    made = Cluster(2)
    yield made
    made.close()


@pytest.mark.long
def test_client_scheduler_and_worker_are_killed_in_turn(outside, tmp_path, expected):
    folder = tmp_path / "study"
    process = client(folder, scheduler=outside.address)
    when(folder, 2, process.kill).join()
    assert process.wait() == -signal.SIGKILL
    before = finished(folder)
    thread = when(folder, before + 3, outside.workers[0].kill)
    process = client(folder, scheduler=outside.address)
    when(folder, before + 6, outside.scheduler.kill).join()
    thread.join()
    _, said = process.communicate(timeout=200)
    assert process.returncode == 1 and "the scheduler is lost" in said and finished(folder) < 36
    other = Cluster(2)
    try:
        wr.sweep(study_scene(), folder, device="cpu", scheduler=other.address)
    finally:
        other.close()
    check(folder, expected)


@pytest.mark.long
def test_the_task_of_a_stuck_worker_is_done_by_another(outside, tmp_path, expected, monkeypatch):
    monkeypatch.setattr(dispatch, "LATE", 3.0)
    folder = tmp_path / "study"
    stop = lambda: outside.workers[0].send_signal(signal.SIGSTOP)  # noqa: E731
    thread = when(folder, 3, stop)
    study = wr.sweep(study_scene(), folder, device="cpu", scheduler=outside.address)
    thread.join()
    assert study.left == 0
    check(folder, expected)


@pytest.fixture
def two_hosts():
    """Two network namespaces with a cable between them; making them needs the rights of root."""
    names = ("rods-one", "rods-two")

    def ip(command: str) -> int:
        return subprocess.run(["ip", *command.split()], capture_output=True).returncode

    if any(ip(f"netns add {name}") for name in names):
        pytest.skip("no network namespace can be made here")
    ip(f"link add rods-a netns {names[0]} type veth peer name rods-b netns {names[1]}")
    for number, (name, end) in enumerate(zip(names, ("rods-a", "rods-b"), strict=True), 1):
        ip(f"-n {name} addr add 10.77.0.{number}/24 dev {end}")
        ip(f"-n {name} link set {end} up")
        ip(f"-n {name} link set lo up")
    yield tuple(("ip", "netns", "exec", name) for name in names)
    for name in names:
        ip(f"netns delete {name}")


@pytest.mark.long
def test_workers_on_two_hosts(two_hosts, tmp_path, expected):
    """Scheduler and client on one, a worker on each, which see each other over the network alone."""
    folder = tmp_path / "study"
    made = Cluster(2, "10.77.0.1", two_hosts)
    try:
        process = client(folder, scheduler=made.address, host=two_hosts[0])
        _, said = process.communicate(timeout=600)
    finally:
        made.close()
    assert process.returncode == 0, said
    check(folder, expected)


@pytest.mark.long
def test_a_task_that_kills_every_worker_is_given_up_and_the_rest_go_on(tmp_path, expected, monkeypatch):
    """As one that needs more memory than there is."""
    monkeypatch.setattr(dispatch, "work", _deadly)
    study = wr.sweep(study_scene(), tmp_path / "study", device="cpu", workers=2)
    data = study.data
    lost = data["state"].to_numpy() == 3
    assert lost[0, 0, 0] and not lost.all() and study.points["failed"] == lost.sum()
    assert "KilledWorker" in data["message"].to_numpy()[0, 0, 0]
    np.testing.assert_array_equal(data["speed"].to_numpy()[~lost], expected["speed"].to_numpy()[~lost])


def _deadly(folder, task, device, version):
    if (0, 0, 0) in task.points:
        os.kill(os.getpid(), signal.SIGKILL)
    from warp_rods.studies.tasks import do

    return do(folder, task, device, version)

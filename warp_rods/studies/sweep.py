"""A whole study: begun or continued, on all cores, on a cluster, or a part of it in this process."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from filelock import FileLock, Timeout

from warp_rods import __version__, arguments
from warp_rods import device as devices
from warp_rods.errors import RunFolderError, SceneError
from warp_rods.progress import Bar, waiting
from warp_rods.scene.scene import Scene
from warp_rods.simulation.files import check_writable, default_folder
from warp_rods.simulation.interruption import Interrupted
from warp_rods.simulation.storage import REMEDIES, StorageError
from warp_rods.studies import cluster, dispatch
from warp_rods.studies.begin import begin
from warp_rods.studies.plan import Plan
from warp_rods.studies.refine import levels
from warp_rods.studies.serial import run_here, share
from warp_rods.studies.status import counts, warnings
from warp_rods.studies.store import STORE, Store
from warp_rods.studies.study import Study
from warp_rods.studies.tasks import Outcome, Task, tasks_of

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["sweep"]

LOCK = ".lock"
STOPPING = "stopping: tasks at work have some seconds to end; a second Ctrl-C does not wait"


def sweep(
    scene: Scene | str | Path,
    out: str | Path | None = None,
    *,
    device: str | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    part: tuple[int, int] | str | None = None,
    overwrite: bool = False,
    console: Console | None = None,
) -> Study:
    """Simulate a scene at every point of its ``sweep`` into the folder ``out`` (default ``runs/<scene name>``).

    A study that was stopped, or killed, goes on where it was; points that failed are tried again. Tasks run on all
    cores with Dask (without it, one after the other); these processes import the script that calls this function, which
    therefore needs ``if __name__ == "__main__":``. ``scheduler``: the address of another cluster of Dask, whose workers
    see the same folder; ``workers``: how many processes on this machine. ``part=(3, 64)``, or "3/64": the third of 64
    parts, in this process and without Dask. Raises SceneError before anything is written, RunFolderError for a folder
    that holds something else, StorageError where it can no longer be written, SchedulerLost.
    """
    from rich.console import Console

    cluster.end_if_a_worker()
    console = console or Console(stderr=True, markup=False, highlight=False)
    folder = default_folder(scene) if out is None else arguments.path("out", out)
    plan = Plan(scene if isinstance(scene, Scene) else Scene.load(scene))
    mine = _part(part)
    _check(mine, scheduler, workers, overwrite)
    check_writable(folder, "out")
    plan.check()
    places = _places(device)
    how = How(",".join(places), scheduler, workers or (mine[1] if mine else _processes(places)), mine)
    said: list[str] = []
    tell = _teller(said, console)
    begun: tuple[Plan, Store] | None = None
    try:
        with _held(folder, mine):
            begun = plan, store = _begun(plan, folder, how, overwrite, tell, console)
            _levels(plan, store, folder, how, tell, console)
            for line in warnings(plan, store) if plan.sweep.keep == "trajectory" else ():
                tell(line)
            return Study(folder, *counts(plan, store), said)
    except OSError as fault:
        raise _storage(fault, folder) from None
    except (KeyboardInterrupt, Interrupted):
        if begun is not None and not (found := counts(*begun))[1]:
            console.print("all points were finished in the meantime", soft_wrap=True)
            return Study(folder, *found, said)
        console.print("stopped: what was finished is kept, and the same command goes on", soft_wrap=True)
        raise


@dataclass(frozen=True)
class How:
    """Where tasks are done: devices, with commas between them; a scheduler, or processes here; or a part of them."""

    device: str
    scheduler: str | None
    workers: int
    part: tuple[int, int] | None


def _begun(
    plan: Plan, folder: Path, how: How, overwrite: bool, tell: Callable[[str], None], console: Console
) -> tuple[Plan, Store]:  # fmt: skip
    """The store of a study, begun or as it was left, and the plan with the axes in its order."""
    with waiting("compiling kernels (once on a machine, then cached) and estimating times", console):
        store, lines = begin(plan, folder, how.device.split(",")[0], how.workers, overwrite)
    for line in [f"{plan.size} into {folder / STORE}", *lines]:
        tell(line)
    return Plan(plan.scene, store.dims), store


def _part(part: Any) -> tuple[int, int] | None:
    """A part of so many, such as (3, 64) or "3/64"; raises SceneError."""
    if part is None:
        return None
    given = "/".join(map(str, part)) if isinstance(part, (tuple, list)) else str(part)
    i, _, n = given.partition("/")
    if not (i.isdecimal() and n.isdecimal() and 1 <= int(i) <= int(n)):
        raise SceneError(f"part = {given}: must be i/n with 1 ≤ i ≤ n, such as 3/64")
    return int(i), int(n)


def _check(part: tuple[int, int] | None, scheduler: str | None, workers: int | None, overwrite: bool) -> None:
    """Raises SceneError for arguments that do not go together."""
    if part is not None:
        if scheduler is not None or workers is not None:
            raise SceneError("part: is done in this process: leave scheduler and workers out")
        if overwrite:
            raise SceneError("part: cannot overwrite what the other parts write: remove the study first")
    if workers is not None:
        arguments.whole("workers", workers, 1)
        if scheduler is not None:
            raise SceneError("workers: a scheduler has its own: leave one of them out")
    if scheduler is not None or workers is not None:
        cluster.require()


def _places(device: str | None) -> list[str]:
    """The devices that processes use in turn: the one that is asked for, or every GPU, or the CPU."""
    chosen = devices.choose(device)
    if device in (None, "auto") and chosen.startswith("cuda"):
        return [one.alias for one in devices.known() if one.is_cuda]
    return [chosen]


def _processes(places: list[str]) -> int:
    """How many processes use this machine: one for each GPU, or for each core."""
    return len(places) if places[0].startswith("cuda") else devices.cores()


@contextlib.contextmanager
def _held(folder: Path, part: tuple[int, int] | None) -> Iterator[None]:
    """The folder, for one client at a time; parts share it with anybody. What was begun in vain leaves no folder."""
    made = not folder.exists()
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(folder / LOCK)
    if part is None:
        try:
            lock.acquire(blocking=False)
        except Timeout:
            raise RunFolderError(
                f"another sweep is at work in {folder}: wait for it, --status shows how far it is"
            ) from None
    try:
        yield
    finally:
        lock.release()
        if made and [file.name for file in folder.iterdir()] in ([], [LOCK]):
            (folder / LOCK).unlink(missing_ok=True)
            folder.rmdir()


def _teller(said: list[str], console: Console) -> Callable[[str], None]:
    def tell(line: str) -> None:
        said.append(line)
        console.print(line, soft_wrap=True)

    return tell


def _levels(
    plan: Plan, store: Store, folder: Path, how: How, tell: Callable[[str], None], console: Console
) -> None:  # fmt: skip
    """All levels, each after the one before."""
    dask = how.part is None and cluster.available()
    if how.part is None and not dask:
        tell(f"Dask is not installed, so one core does all tasks in turn; for all cores: {cluster.INSTALL}")
    engine = _Dask(how, tell, twice=plan.sweep.keep == "summary") if dask else None
    tried = np.zeros(plan.shape, dtype=bool)  # what failed is tried once in a sweep
    try:
        for level, mask in levels(plan, store):
            tasks = list(tasks_of(store, level, mask & ~tried, store.states()))
            tried |= mask
            mine = share(tasks, list(store.chunks()), *how.part) if how.part else tasks
            if level and mine:
                tell(f"refinement {level} of {plan.levels}: {sum(len(task.points) for task in mine)} points more")
            if mine:
                _do(mine, folder, console, how.device, engine, level)
    except (KeyboardInterrupt, Interrupted):
        if engine is not None and engine.has_processes:
            console.print(STOPPING, soft_wrap=True)
        raise
    finally:
        if engine is not None:
            engine.close()


class _Dask:
    """A connection to a cluster, which is made when there is something to do."""

    def __init__(self, how: How, say: Callable[[str], None], twice: bool):
        self._how, self._say, self._twice = how, say, twice
        self._context: Any = None
        self._client: Any = None

    def run(self, tasks: list[Task], folder: Path, tell: Callable[[Task, Outcome], None]) -> None:
        if self._client is None:
            self._context = cluster.connected(self._how.scheduler, min(self._how.workers, len(tasks)))
            self._client = self._context.__enter__()
        device = self._how.device
        if self._how.scheduler is not None and device.startswith(dispatch.CUDA):
            device = dispatch.CUDA
        where = str(folder.resolve())
        dispatch.run_on(self._client, where, tasks, device, __version__, tell, self._say, twice=self._twice)

    @property
    def has_processes(self) -> bool:
        """Whether it has begun processes on this machine, which end with it."""
        return self._client is not None and self._how.scheduler is None

    def close(self) -> None:
        if self._context is not None:
            self._context.__exit__(None, None, None)


def _do(tasks: list[Task], folder: Path, console: Console, device: str, engine: _Dask | None, level: int) -> None:
    """Do tasks, with a bar that shows points, throughput and time left."""
    total, begun = sum(len(task.points) for task in tasks), time.monotonic()
    done = failed = 0
    with Bar(f"refinement {level}" if level else "sweep", total, console) as bar:

        def tell(_task: Task, outcome: Outcome) -> None:
            nonlocal done, failed
            done, failed = done + outcome.done + len(outcome.failed), failed + len(outcome.failed)
            speed = done / max(time.monotonic() - begun, 1e-9)
            bad = f", {failed} failed" if failed else ""
            bar.update(done, f"{done} of {total} points{bad}, {speed:.3g} points/s")

        if engine is None:
            run_here(str(folder.resolve()), tasks, device.split(",")[0], tell)
        else:
            engine.run(tasks, folder, tell)


def _storage(fault: OSError, folder: Path) -> Exception:
    """A storage error in words, or the error itself."""
    if fault.errno not in REMEDIES:
        return fault
    happened, remedy = REMEDIES[fault.errno]
    return StorageError(
        f"{happened.format(folder=folder)} ({os.strerror(fault.errno or 0)}: {fault.filename or folder}). All finished "
        f"points are kept. To go on, {remedy}, then run the same command again."
    )

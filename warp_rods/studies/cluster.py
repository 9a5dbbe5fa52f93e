"""Tasks on Dask: a cluster of this machine's cores (or devices), or any other one, whose scheduler has an address.

Only some tasks are with the scheduler at a time, a few for each worker: a million at once would cost it minutes and
gigabytes before the first one starts (docs/cluster.md). What a task found is in the store before the scheduler hears of
it: a worker, the scheduler or this client may be lost at any moment, and a task may be done twice, with the same bits.
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import queue
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from warp_rods.errors import RunFolderError, SceneError, WarpRodsError
from warp_rods.studies.tasks import Outcome, Task, again, do, give_up

__all__ = ["SchedulerLost", "available", "connected", "run_on"]

EACH = 2
"""Tasks with the scheduler for each worker: one that runs, and one that waits."""
TICK = 1.0
"""Seconds after which the number of workers, and tasks that take long, are looked at."""
LATE, LATER = 30.0, 4.0
"""A task is late, and done by another worker as well, after so many seconds and times the longest task so far."""
DISK = {errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG, errno.EACCES, errno.EPERM}
INSTALL = "pip install 'warp-rods[studies]'"


class SchedulerLost(WarpRodsError):
    """The scheduler of a cluster is gone, with all tasks that it had; what was finished is in the store."""


def available() -> bool:
    """Whether Dask is installed."""
    from importlib.util import find_spec

    return find_spec("distributed") is not None


def require() -> None:
    """Raises SceneError where Dask is not installed."""
    if not available():
        raise SceneError(f"a cluster needs Dask, which is not installed: {INSTALL}; or use --part")


@contextlib.contextmanager
def connected(scheduler: str | None, workers: int) -> Iterator[Any]:
    """A client of the scheduler at an address, or of a cluster of ``workers`` processes with one thread each here.

    Raises SceneError where there is no scheduler at the address.
    """
    require()
    import dask
    from distributed import Client, LocalCluster

    with contextlib.ExitStack() as held:
        held.enter_context(dask.config.set({"distributed.admin.tick.limit": "1h"}))  # a step may take long
        if scheduler is None:
            scheduler = held.enter_context(
                LocalCluster(
                    n_workers=workers, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0",
                    silence_logs=50, memory_limit=0,
                )
            )  # fmt: skip
        try:
            client = held.enter_context(Client(scheduler, timeout="20s", set_as_default=False))
        except (OSError, ValueError) as error:
            raise SceneError(
                f"scheduler = {scheduler}: there is none ({error}); start one with `dask scheduler`, which prints it"
            ) from None
        yield client


@dataclass
class _Running:
    """Tasks with the scheduler."""

    client: Any
    folder: str
    device: str
    version: str
    futures: dict[str, tuple[Task, Any, float]] = field(default_factory=dict)
    """By the name of the task: the task, its future, and when it was submitted."""
    twice: dict[str, Any] = field(default_factory=dict)
    """A second future of tasks that were late."""
    ended: queue.SimpleQueue[Any] = field(default_factory=queue.SimpleQueue)
    numbers: Iterator[int] = field(default_factory=itertools.count)
    """Of submissions: a key that the scheduler knows already would not be computed again."""

    def submit(self, task: Task, avoid: str = "") -> Any:
        """Give a task to the scheduler, if possible for another worker than ``avoid``."""
        others = [address for address in self.client.nthreads() if address != avoid] if avoid else []
        where = {"workers": others, "allow_other_workers": True} if others else {}
        future = self.client.submit(
            work,
            self.folder,
            task,
            self.device,
            self.version,
            key=f"point-{self.client.id}-{task.name}-{next(self.numbers)}",
            pure=False,
            **where,
        )
        future.add_done_callback(lambda done: self.ended.put((task.name, done)))
        return future

    def add(self, task: Task, avoid: str = "") -> None:
        self.futures[task.name] = (task, self.submit(task, avoid), time.monotonic())

    def finish(self, name: str, ended: Any) -> Task | None:
        """Forget a task, one of whose futures has ended; None where another one has before."""
        if name not in self.futures:
            return None
        task, first, _ = self.futures.pop(name)
        for future in (first, self.twice.pop(name, None)):
            if future is not None and future is not ended:
                future.cancel()
        return task


def work(folder: str, task: Task, device: str, version: str) -> Outcome:
    """What a worker does for a task."""
    from distributed import get_worker

    from warp_rods.device import use_one_core

    use_one_core()
    worker = get_worker()
    devices = device.split(",")
    own = devices[int(worker.name) % len(devices)] if str(worker.name).isdecimal() else devices[0]
    return do(folder, task, own, version)._replace(worker=worker.address)


def run_on(
    client: Any, folder: str, tasks: Iterable[Task], device: str, version: str,
    tell: Callable[[Task, Outcome], None], say: Callable[[str], None] = lambda line: None,
) -> None:  # fmt: skip
    """Do the tasks on a cluster; ``tell`` is called when one has ended, for good, ``say`` with lines for the user.

    A point that fails is tried once more, if possible by another worker, then recorded as failed. Raises SchedulerLost,
    and OSError where the store cannot be written, after nothing more was submitted.
    """
    running = _Running(client, folder, device, version)
    with _talking():
        _run(running, iter(tasks), tell, say)


def _run(
    running: _Running, left: Iterator[Task], tell: Callable[[Task, Outcome], None], say: Callable[[str], None]
) -> None:  # fmt: skip
    """Do the tasks that are left: some are with the scheduler, the next ones follow as they end."""
    more, room, looked, longest = True, 1, -TICK, 0.0
    while more or running.futures:
        if time.monotonic() - looked > TICK:
            looked, room, before = time.monotonic(), EACH * _workers(running.client), room
            if room == 0 and before:
                say("there are no workers: waiting for some to join the scheduler")
        while more and len(running.futures) < room:
            task = next(left, None)
            if task is None:
                more = False
            else:
                running.add(task)
        try:
            name, future = running.ended.get(timeout=TICK)
        except queue.Empty:
            if not more:
                _help_late(running, max(LATE, LATER * longest))
            continue
        task = running.finish(name, future)
        if task is not None:
            longest = max(longest, _ended(running, task, future, tell))


@contextlib.contextmanager
def _talking() -> Iterator[None]:
    """Raises SchedulerLost where the scheduler ends while it is talked to: about a task, an outcome or its workers."""
    from distributed.comm import CommClosedError

    try:
        yield
    except (CommClosedError, TimeoutError) as error:
        raise SchedulerLost(_lost(error)) from None


def _workers(client: Any) -> int:
    """The number of threads of the cluster; raises SchedulerLost."""
    try:
        return sum(client.nthreads().values())
    except (OSError, RuntimeError) as error:
        raise SchedulerLost(_lost(error)) from None


def _lost(why: object) -> str:
    return f"the scheduler is lost ({why}): what was finished is kept; start one, then run the same command again"


def _help_late(running: _Running, seconds: float) -> None:
    """Give tasks that take much longer than all others to a second worker: theirs may be stuck."""
    for name, (task, future, since) in running.futures.items():
        if time.monotonic() - since > seconds and name not in running.twice:
            running.twice[name] = running.submit(task, _doing(running, future))


def _doing(running: _Running, future: Any) -> str:
    """The worker that has a task."""
    return next((worker for worker, keys in running.client.processing().items() if future.key in keys), "")


def _ended(running: _Running, task: Task, future: Any, tell: Callable[[Task, Outcome], None]) -> float:
    """What becomes of a task whose future has ended; returns the seconds that it took."""
    if future.status == "finished":
        try:
            outcome: Outcome = future.result(timeout=LATE)
        except TimeoutError:  # the worker was stuck after it had done the task, and keeps the outcome
            running.add(task)
            return 0.0
        if outcome.failed and not task.final:
            running.add(again(task, outcome.failed), avoid=outcome.worker)
            outcome = outcome._replace(failed={})
        tell(task, outcome)
        return outcome.seconds
    if future.status in ("cancelled", "lost"):
        raise SchedulerLost(_lost(future.status))
    error = future.exception()
    if isinstance(error, OSError) and error.errno in DISK:
        raise error
    if isinstance(error, RunFolderError):
        raise error
    reasons = dict.fromkeys(task.points, f"{type(error).__name__}: {error}")
    if task.final or type(error).__name__ == "KilledWorker":
        give_up(running.folder, task, reasons)
        tell(task, Outcome(0, reasons, 0.0))
    else:
        running.add(again(task, reasons))
    return 0.0

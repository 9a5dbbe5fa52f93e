"""Tasks with the scheduler of a cluster: some at a time, what becomes of them, and who does them again.

Only a few for each worker are with it: a million at once would cost it minutes and gigabytes before the first
one starts (docs/cluster.md). What a task found is in the store before the scheduler hears of it: a worker, the
scheduler or this client may be lost at any moment, and a task may be done twice, with the same bits.
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import queue
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from dataclasses import dataclass, field
from typing import Any

from warp_rods.errors import RunFolderError, WarpRodsError
from warp_rods.simulation.storage import StorageError
from warp_rods.studies.tasks import Outcome, Task, again, do, each, give_up

__all__ = ["CUDA", "SchedulerLost", "run_on"]

CUDA = "cuda"
"""The device of workers elsewhere, each of which takes one that it sees."""
EACH = 2
"""Tasks with the scheduler for each worker: one that runs, and one that waits."""
TICK = 1.0
"""Seconds after which the number of workers, and tasks that take long, are looked at."""
LATE, LATER = 30.0, 4.0
"""A task is late, and done by another worker as well, after so many seconds and times the longest task so far."""
DISK = {errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG, errno.EACCES, errno.EPERM}


class SchedulerLost(WarpRodsError):
    """The scheduler of a cluster is gone, with all tasks that it had; what was finished is in the store."""


@dataclass
class _Running:
    """Tasks with the scheduler."""

    client: Any
    folder: str
    device: str
    version: str
    tasks: dict[str, _Copies] = field(default_factory=dict)
    """By the name of the task."""
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
        self.tasks[task.name] = _Copies(task, [self.submit(task, avoid)], time.monotonic())

    def next_ended(self) -> tuple[Task, Any] | None:
        """The next task that has ended, with its future; None where another copy has done it, or is still at work.

        Raises queue.Empty after ``TICK`` seconds in which none has ended.
        """
        name, future = self.ended.get(timeout=TICK)
        copies = self.tasks.get(name)
        if copies is None or future not in copies.futures:
            return None  # of a task that another copy has done before
        if future.status != "finished" and len(copies.futures) > 1:
            copies.futures.remove(future)
            return None
        return copies.task, future

    def forget(self, task: Task, ended: Any) -> None:
        """One copy of a task has ended: nobody needs to do it any more."""
        for future in self.tasks.pop(task.name).futures:
            if future is not ended:  # whose status and error would go, too
                future.cancel()


@dataclass
class _Copies:
    """A task that the scheduler has once, or twice where it was late, and when it was first submitted."""

    task: Task
    futures: list[Any]
    since: float


def work(folder: str, task: Task, device: str, version: str) -> Outcome:
    """What a worker does for a task."""
    from distributed import get_worker

    from warp_rods.device import use_one_core

    use_one_core()
    worker = get_worker()
    places = _own_gpus() if device == CUDA else device.split(",")
    own = places[int(worker.name) % len(places)] if str(worker.name).isdecimal() else places[0]
    return do(folder, task, own, version)._replace(worker=worker.address)


def _own_gpus() -> list[str]:
    """The GPUs that this process sees; raises RunFolderError where there is none."""
    from warp_rods import device

    found = [one.alias for one in device.known() if one.is_cuda]
    if not found:
        raise RunFolderError("this study is done on GPUs, and a worker sees none: start workers where there are some")
    return found


def run_on(
    client: Any, folder: str, tasks: Iterable[Task], device: str, version: str,
    tell: Callable[[Task, Outcome], None], say: Callable[[str], None] = lambda line: None, *, twice: bool = True,
) -> None:  # fmt: skip
    """Do the tasks on a cluster; ``tell`` is called when one has ended, for good, ``say`` with lines for the user.

    A point that fails is tried once more, if possible by another worker, then recorded as failed. twice: late tasks are
    given to a second worker. Raises SchedulerLost, and OSError or StorageError where the study cannot be written, after
    nothing more was submitted.
    """
    running = _Running(client, folder, device, version)
    with _talking():
        _run(running, iter(tasks), tell, say, twice)


def _run(
    running: _Running, left: Iterator[Task], tell: Callable[[Task, Outcome], None], say: Callable[[str], None],
    twice: bool,
) -> None:  # fmt: skip
    """Do the tasks that are left: some are with the scheduler, the next ones follow as they end."""
    more, room, looked, longest = True, 1, -TICK, 0.0
    while more or running.tasks:
        if time.monotonic() - looked > TICK:
            looked, room, before = time.monotonic(), EACH * _workers(running.client), room
            if room == 0 and before:
                say("there are no workers: waiting for some to join the scheduler")
        while more and len(running.tasks) < room:
            task = next(left, None)
            if task is None:
                more = False
            else:
                running.add(task)
        try:
            ended = running.next_ended()
        except queue.Empty:
            if twice and not more:
                _help_late(running, max(LATE, LATER * longest))
            continue
        if ended is not None:
            longest = max(longest, _ended(running, *ended, tell))


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
    for copies in running.tasks.values():
        if time.monotonic() - copies.since > seconds and len(copies.futures) == 1:
            copies.futures.append(running.submit(copies.task, _doing(running, copies.futures[0])))


def _doing(running: _Running, future: Any) -> str:
    """The worker that has a task."""
    return next((worker for worker, keys in running.client.processing().items() if future.key in keys), "")


def _ended(running: _Running, task: Task, future: Any, tell: Callable[[Task, Outcome], None]) -> float:
    """What becomes of a task, the last or only copy of which has ended; returns the seconds that it took."""
    if future.status == "finished":
        try:
            outcome: Outcome = future.result(timeout=LATE)
        except (TimeoutError, CancelledError):  # the worker is stuck, or lost, after it had done the task
            return _resubmitted(running, task, future)
        running.forget(task, future)
        if outcome.failed and not task.final:
            running.add(again(task, outcome.failed), avoid=outcome.worker)
            outcome = outcome._replace(failed={})
        tell(task, outcome)
        return outcome.seconds
    if future.status != "error":  # finished no more: the worker with the outcome is lost, or the scheduler
        return _resubmitted(running, task, future)
    running.forget(task, future)
    error = future.exception()
    if isinstance(error, (RunFolderError, StorageError)) or (isinstance(error, OSError) and error.errno in DISK):
        raise error
    _failed(running, task, error, tell)
    return 0.0


def _resubmitted(running: _Running, task: Task, future: Any) -> float:
    """Give a task whose outcome cannot be had to the scheduler again; raises SchedulerLost where there is none."""
    _workers(running.client)
    running.forget(task, future)
    running.add(task)
    return 0.0


def _failed(running: _Running, task: Task, error: BaseException, tell: Callable[[Task, Outcome], None]) -> None:
    """Of a task that raised an error, or killed its workers, those points that are not finished are tried one by one.

    What fails then is recorded as failed.
    """
    if not task.final:
        singles = each(running.folder, task)
        tell(task, Outcome(len(task.points) - len(singles), {}, 0.0))
        for single in singles:
            running.add(single)
        return
    reasons = dict.fromkeys(task.points, f"{type(error).__name__}: {error}")
    give_up(running.folder, task, reasons)
    tell(task, Outcome(0, reasons, 0.0))

"""Tasks one after the other in this process: without Dask, and for the elements of an array job."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from warp_rods.studies.plan import Index
from warp_rods.studies.tasks import Outcome, Task, again, do

__all__ = ["run_here", "share"]


def run_here(folder: str, tasks: Iterable[Task], device: str, tell: Callable[[Task, Outcome], None]) -> None:
    """Do the tasks; ``tell`` is called after each. A point that fails is tried once more, then recorded as failed."""
    for task in tasks:
        outcome = do(folder, task, device)
        if outcome.failed:
            last = do(folder, again(task, outcome.failed), device)
            outcome = Outcome(outcome.done + last.done, last.failed, outcome.seconds + last.seconds)
        tell(task, outcome)


def share(tasks: Sequence[Task], chunks: Sequence[Index], part: int, parts: int) -> list[Task]:
    """The tasks of one of ``parts`` processes, counted from 1: those of every so-many-th chunk of the store.

    Chunks do not depend on what is done already, so that no two parts do the same.
    """
    mine = set(list(chunks)[part - 1 :: parts])
    return [task for task in tasks if task.chunk in mine]

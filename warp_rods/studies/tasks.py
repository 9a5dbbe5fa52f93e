"""The tasks of a study: points of one chunk of the store at one level of refinement, done by any worker, any time."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from warp_rods import __version__
from warp_rods.errors import RunFolderError
from warp_rods.scene.scene import Scene
from warp_rods.simulation.files import TRAJECTORIES
from warp_rods.simulation.zarr_format import METADATA
from warp_rods.studies.plan import Index, Plan
from warp_rods.studies.points import Results, as_rods, each_alone
from warp_rods.studies.store import FAILED, FINISHED, STORE, Store

__all__ = ["SCENE", "Outcome", "Task", "again", "do", "each", "give_up", "plan_of", "scene_of", "tasks_of"]

SCENE = "scene.toml"
"""In the folder of a study, a copy of its scene."""


@dataclass(frozen=True)
class Task:
    """Points of one chunk, whose others are done or for another level. ``final``: what fails again is recorded so."""

    level: int
    chunk: Index
    points: tuple[Index, ...]
    final: bool = False

    @property
    def name(self) -> str:
        """A name that no other task of the study has."""
        place = ".".join(map(str, self.points[0]))
        return f"{self.level}-{place}-{len(self.points)}{'-again' if self.final else ''}"


class Outcome(NamedTuple):
    """What became of a task: points that are done, those that failed with the reason, seconds, and who did it."""

    done: int
    failed: dict[Index, str]
    seconds: float
    worker: str = ""


def tasks_of(store: Store, level: int, mask: np.ndarray, states: np.ndarray) -> Iterator[Task]:
    """The tasks of a level whose points are a mask of the grid: those points that are not computed.

    Chunks have a task's points before refinement; a refinement may add many times as many to one.
    """
    left = mask & ((states == 0) | (states == FAILED))
    most = int(store.attributes.get("points_in_a_task", 0)) or left.size
    for chunk in store.chunks():
        region = store.region(chunk)
        found = np.argwhere(left[region]) + np.array([part.start for part in region])
        for some in np.array_split(found, max(1, round(len(found) / most))):
            if len(some):
                yield Task(level, chunk, tuple(map(tuple, some.tolist())))


def do(folder: str, task: Task, device: str, version: str = __version__) -> Outcome:
    """Do a task and write what it found; of points that fail the reasons are returned, or written if it is ``final``.

    Points that somebody else has finished are done. Raises RunFolderError where this process does not see the study or
    has another version, OSError and StorageError as on a full disk.
    """
    if version != __version__:
        raise RunFolderError(f"this worker has warp-rods {__version__}, the study {version}: install the same version")
    begun = time.perf_counter()
    plan, store, together = _opened(folder)
    left = remaining(store, task)
    done, failed = len(task.points) - len(left.points), dict[Index, str]()
    for found in _simulated(plan, left, device, together, Path(folder) / TRAJECTORIES):
        if found.points:
            store.put(task.chunk, found.points, found.values)
        done, failed = done + len(found.points), failed | found.errors
    if task.final and failed:
        give_up(folder, task, failed)
    return Outcome(done, failed, time.perf_counter() - begun)


def remaining(store: Store, task: Task) -> Task:
    """The task with those of its points that nobody has finished."""
    states = store.state(task.points, task.chunk)
    return replace(task, points=tuple(p for p, s in zip(task.points, states, strict=True) if s not in FINISHED))


def _simulated(plan: Plan, task: Task, device: str, together: int, folder: Path) -> Iterator[Results]:
    """The results of the points of a task, so many ``together`` in a batch; 0: each point is simulated alone."""
    if plan.sweep.keep == "trajectory":
        yield from each_alone(plan, task.points, device, folder)
    elif not together:
        yield from each_alone(plan, task.points, device)
    else:
        for first in range(0, len(task.points), together):
            yield from _batch(plan, task.points[first : first + together], device)


def _batch(plan: Plan, points: tuple[Index, ...], device: str) -> Iterator[Results]:
    """Points as rods of a batch; one by one where some of them is not possible, so that the others are done."""
    try:
        found = as_rods(plan, points, device)
    except OSError:
        raise
    except Exception:  # whatever it is, it may be that of one point
        yield from each_alone(plan, points, device)
    else:
        yield found


def give_up(folder: str, task: Task, reasons: Mapping[Index, str]) -> None:
    """Record points of a task as failed, with the reasons; those that somebody has finished stay so."""
    points = list(reasons)
    states = np.full(len(points), FAILED, dtype=np.int8)
    messages = np.array([reasons[point] for point in points], dtype=object)
    _opened(folder)[1].put(task.chunk, points, {"state": states, "message": messages})


def again(task: Task, points: Mapping[Index, str]) -> Task:
    """The task with those points that failed, for the last time."""
    return replace(task, points=tuple(points), final=True)


def each(folder: str, task: Task) -> list[Task]:
    """A task for each point that nobody has finished."""
    left = remaining(_opened(folder)[1], task)
    return [replace(task, points=(point,), final=True) for point in left.points]


def scene_of(store: Store) -> Scene:
    """The scene of a study."""
    return Scene.parse(store.attributes["scene"])


def plan_of(store: Store) -> Plan:
    """The plan of a study that was begun."""
    return Plan(scene_of(store), store.dims, store.columns)


def _opened(folder: str) -> tuple[Plan, Store, int]:
    """The plan and the store of a study, and how many points are in a batch."""
    try:
        about = (Path(folder) / STORE / METADATA).stat()
    except OSError:
        raise RunFolderError(f"{folder} is not there: every worker must see the folder of the study") from None
    return _read(folder, about.st_mtime_ns, about.st_ino)


@lru_cache(maxsize=2)
def _read(folder: str, *_which: int) -> tuple[Plan, Store, int]:
    store = Store(Path(folder) / STORE)
    return plan_of(store), store, int(store.attributes["points_in_a_batch"])

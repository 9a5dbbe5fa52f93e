"""How far the run in a folder is: finished, running, stopped before its end, or damaged. Only reads the folder."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

from warp_rods.errors import RunFolderError, WarpRodsError
from warp_rods.progress import in_words
from warp_rods.scene.tables import Time
from warp_rods.simulation.document import Document
from warp_rods.simulation.files import STUDY, no_run
from warp_rods.simulation.frames import Frames
from warp_rods.simulation.leftovers import is_being_made
from warp_rods.simulation.store import STORE
from warp_rods.simulation.under_way import UnderWay, is_under_way

__all__ = ["RunStatus", "State", "exit_code", "status_of"]

ENDS = ("stopped at", "error: ")
"""How the message of a run begins that says why it ended before its end."""


class State(StrEnum):
    """What a run folder holds."""

    FINISHED = "finished"
    RUNNING = "running"
    STOPPED = "stopped"
    DAMAGED = "damaged"
    NONE = "no run"


@dataclass(frozen=True)
class RunStatus:
    """The state of a run, and how far it is."""

    folder: Path
    state: State
    time: float = 0.0
    end: float = 0.0
    frames: int = 0
    all_frames: int = 0
    rods: dict[str, int] = field(default_factory=dict)
    """Numbers of rods by ensemble."""
    lost: dict[str, int] = field(default_factory=dict)
    """Numbers of those that were frozen."""
    seconds_left: float | None = None
    speed: float | None = None
    """Rod-steps per second."""
    why: str = ""
    """What is damaged, what ended the run, or what is being made of it."""
    title: str = ""
    messages: tuple[str, ...] = ()

    @property
    def fraction(self) -> float:
        """The part of the run that is done."""
        return min(self.time / self.end, 1.0) if self.end else 0.0

    def cells(self) -> list[str]:
        """The parts of its line: folder, state, share, frames, time, rods lost, what is left."""
        if not self.all_frames:
            return [str(self.folder), self.state, self.why]
        left = "" if self.seconds_left is None else f"about {in_words(self.seconds_left)} left"
        speed = "" if self.speed is None else f"{self.speed:,.0f} rod-steps/s"
        lost = f"{sum(self.lost.values())} of {sum(self.rods.values())} rods lost"
        more = [part for part in (lost, speed, left, self.why) if part]
        return [
            str(self.folder),
            self.state,
            f"{100 * self.fraction:3.0f} %",
            f"{self.frames} of {self.all_frames} frames",
            f"t = {self.time:.4g} of {self.end:.4g}",
            ", ".join(more),
        ]


def status_of(folder: Path) -> RunStatus:
    """The state of the run in a folder; raises RunFolderError where there is no run."""
    if (folder / STUDY).exists():
        raise RunFolderError(no_run(folder))
    running = is_under_way(folder)
    if not (folder / STORE).exists():
        if running:
            return RunStatus(folder, State.RUNNING, why="it is being made")
        if is_being_made(folder):
            return RunStatus(folder, State.STOPPED, why="before its first frame; --resume begins it anew")
        raise RunFolderError(no_run(folder))
    try:
        return _read(folder, running)
    except WarpRodsError as fault:
        return RunStatus(folder, State.RUNNING if running else State.DAMAGED, why=str(fault).split("\n")[0])


def _read(folder: Path, running: bool) -> RunStatus:
    document = Document.read(folder / STORE)
    if "scene" not in document.attributes:
        raise RunFolderError(f"{folder / STORE} has no scene")
    frames = document.frames
    plan = Frames.of(Time(**tomllib.loads(document.attributes["scene"])["time"]))
    now, end = float(plan.times[max(frames - 1, 0)]), float(plan.times[-1])
    told = UnderWay.read(folder) if running else None
    finished = frames == len(plan.times)
    state = State.RUNNING if running else State.FINISHED if finished else State.STOPPED
    messages = tuple(document.attributes.get("messages", ()))
    rods, lost = _rods(folder) if frames else ({}, {})
    return RunStatus(
        folder,
        state,
        time=max(now, told.time) if told else now,
        end=end,
        frames=frames,
        all_frames=len(plan.times),
        rods=rods,
        lost=lost,
        seconds_left=told.seconds_left(end) if told else None,
        speed=told.rod_steps / told.seconds if told and told.seconds else None,
        why="; ".join(_reason(messages)) if state is State.STOPPED else _made(told),
        title=str(document.attributes.get("title", "")),
        messages=messages,
    )


def _made(told: UnderWay | None) -> str:
    """Which picture a run that has all its frames makes."""
    return f"its {told.making} is being made" if told and told.making else ""


def _rods(folder: Path) -> tuple[dict[str, int], dict[str, int]]:
    """Numbers of rods, and of those lost by the last frame, by ensemble."""
    from warp_rods.simulation.reading import open_run

    groups = open_run(folder).children
    rods = {name: group.sizes["rod"] for name, group in groups.items()}
    return rods, {name: int((group["status"].isel(frame=-1) != 0).sum()) for name, group in groups.items()}


def _reason(messages: tuple[str, ...]) -> list[str]:
    """Why a run ended, where it could say so: not where it was killed."""
    said = [line for line in messages if line.startswith(ENDS)]
    return [said[-1].removeprefix("error: ").partition(";")[0].partition("\n")[0]] if said else ["killed"]


def exit_code(found: Sequence[RunStatus]) -> int:
    """0: all are finished; else the first that holds: 2, one is damaged or no run; 1, one stopped; 3, rods were lost;
    4, one is running."""
    states = {one.state for one in found}
    if states & {State.DAMAGED, State.NONE}:
        return 2
    if State.STOPPED in states:
        return 1
    if any(sum(one.lost.values()) for one in found):
        return 3
    return 4 if State.RUNNING in states else 0

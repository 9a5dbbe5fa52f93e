"""How far a study is, from its store alone: for another terminal, and when it has ended."""

from __future__ import annotations

import re
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from warp_rods.errors import WarpRodsError
from warp_rods.progress import in_words
from warp_rods.simulation.status import RunStatus, State
from warp_rods.simulation.under_way import is_under_way
from warp_rods.studies.plan import Index, Plan
from warp_rods.studies.refine import levels
from warp_rods.studies.store import STATES, STORE, Store
from warp_rods.studies.tasks import plan_of

__all__ = ["counts", "in_a_line", "status", "warnings"]

SETTLING = {0: "not settled", -1: "unknown if settled"}
LATELY = 300.0
"""Seconds over which the throughput is measured."""
MOST_WARNINGS = 5
"""That are told at the end of a study."""


def counts(plan: Plan, store: Store) -> tuple[dict[str, int], int]:
    """Points by what became of them, and how many of the levels that are known are left."""
    states = store.states()
    *_, (_level, mask) = levels(plan, store)
    wanted = states[mask]
    found = {STATES[code]: int((states == code).sum()) for code in (1, 2, 3)}
    settled = store.whole("settled")[states == 1]
    found |= {words: int((settled == code).sum()) for code, words in SETTLING.items()}
    return {word: count for word, count in found.items() if count}, int((wanted == 0).sum())


def status(folder: str | Path) -> str:
    """How far the study in a folder is, in lines; raises RunFolderError where there is none."""
    folder = Path(folder)
    store = Store(folder / STORE)
    plan = plan_of(store)
    points, left = counts(plan, store)
    said = ", ".join(f"{count} {word}" for word, count in points.items() if word != "computed")
    lines = [f"{folder}: {_done(points, left)}{': ' if said else ''}{said}"]
    if left:
        lines.append(_pace(plan, store, left))
    elif plan.levels:
        lines.append(plan.refined if _all_levels(plan, store) else "the next refinement is still to come")
    return "\n".join(lines)


def warnings(plan: Plan, store: Store) -> list[str]:
    """The warnings of points, each once, with the first point that has it and the number of the others."""
    found: dict[str, list[Index]] = {}
    messages = store.whole("message")
    for point in map(tuple, np.argwhere(messages != "").tolist()):
        for line in re.split(r"(?:^|; )warning: ", messages[point])[1:]:
            found.setdefault(line, []).append(point)
    told = [
        f"warning, at {plan.words(points[0])}{_and_others(len(points) - 1)}: {line}" for line, points in found.items()
    ]
    left = len(told) - MOST_WARNINGS
    more = [f"{left} other warnings are in the variable message of {STORE}"] if left > 0 else []
    return told[:MOST_WARNINGS] + more


def _and_others(count: int) -> str:
    return f" and {count} other point{'s' * (count > 1)}" if count else ""


def in_a_line(folder: Path) -> RunStatus:
    """The same in a line of ``warp-rods status`` beside those of runs."""
    try:
        store = Store(folder / STORE)
        points, left = counts(plan_of(store), store)
        running = is_under_way(folder)
    except WarpRodsError as fault:
        return RunStatus(folder, State.DAMAGED, why=f"a study: {str(fault).splitlines()[0]}")
    state = State.RUNNING if running else State.STOPPED if left else State.FINISHED
    return RunStatus(folder, state, why=f"a study: {_done(points, left)}")


def _done(points: Mapping[str, int], left: int) -> str:
    done = sum(points.get(STATES[code], 0) for code in (1, 2, 3))
    return f"{done} of {done + left} points done ({100 * done / max(done + left, 1):.0f} %)"


def _all_levels(plan: Plan, store: Store) -> bool:
    *_, (level, _mask) = levels(plan, store)
    return level == plan.levels


def _pace(plan: Plan, store: Store, left: int) -> str:
    """Points a second of late, and the time that the others take at this pace.

    The points are those of the present level in chunks that were written after the first one of that time.
    """
    times, now = store.times(), time.time()
    if not times:
        return "nothing is finished yet"
    *before, (_level, mask) = levels(plan, store)
    new = (store.states() > 0) & mask & ~(before[-1][1] if before else np.zeros_like(mask))
    done = {chunk: int(new[store.region(chunk)].sum()) for chunk in times}
    last = max(times.values())
    since = max(min((at for chunk, at in times.items() if done[chunk]), default=last), now - LATELY)
    late, span = sum(done[chunk] for chunk, at in times.items() if at > since), last - since
    ended = f"the last task ended {in_words(now - last)} ago"
    if not late or span <= 0:
        return ended
    return f"{ended}; {late / span:.3g} points/s of late, about {in_words(left * span / late)} left"

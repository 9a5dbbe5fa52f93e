"""A progress bar for long loops."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from rich.console import Console

Item = TypeVar("Item")
WAIT = 2.0
"""Seconds before a bar is shown."""
REFRESH = 0.1
"""Seconds between updates of a bar."""


class Bar:
    """A progress bar with the label ``what``, a context manager; a terminal shows it after two seconds.

    total: the amount of work; done: how much of it is done at the start; console: default standard error.
    """

    def __init__(self, what: str, total: int, console: Console | None = None, done: int = 0):
        self._what, self._total, self._console, self._done = what, total, console, done
        self._began, self._shown = time.monotonic(), float("-inf")
        self._progress: Any = None
        self._task: Any = None

    def __enter__(self) -> Bar:
        return self

    def __exit__(self, *_exception: object) -> None:
        if self._progress is not None:
            self._progress.update(self._task, completed=self._done)
            self._progress.stop()

    def update(self, done: int, note: str = "") -> None:
        """Set how much of the total is done, and a note shown beside the bar."""
        self._done, now = done, time.monotonic()
        if now - self._began < WAIT or now - self._shown < REFRESH:
            return
        self._shown = now
        if self._progress is None:
            self._start()
        self._progress.update(self._task, completed=done, note=note)

    def _start(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        console = self._console or Console(stderr=True)
        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
        note = TextColumn("{task.fields[note]}")
        self._progress = Progress(*columns, note, console=console, transient=True, disable=not console.is_terminal)
        self._task = self._progress.add_task(self._what, total=self._total, completed=self._done, note="")
        self._progress.start()


def with_progress(items: Sequence[Item], what: str) -> Iterator[Item]:
    """The items one by one; after two seconds a terminal shows a bar with the label ``what``."""
    with Bar(what, len(items)) as bar:
        for done, item in enumerate(items):
            bar.update(done)
            yield item

"""Progress of what takes longer than two seconds: a bar on a terminal or in a notebook, else a line now and then."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["Bar", "waiting", "with_progress"]

Item = TypeVar("Item")
WAIT = 2.0
"""Seconds before anything is shown."""
REFRESH = 0.1
"""Seconds between updates of a bar."""
LINE_EVERY = 30.0
"""Seconds between lines where there is no terminal, as in the log of a batch job."""


class Bar:
    """A progress bar with the label ``what``, a context manager; a terminal or a notebook shows it after two seconds.

    Without a terminal a line tells every half a minute how much is done and how long the rest will take.

    total: the amount of work; done: how much of it is done at the start; console: default standard error.
    """

    def __init__(self, what: str, total: int, console: Console | None = None, done: int = 0):
        self._what, self._total, self._console, self._done = what, total, console, done
        self._began, self._shown, self._done_before = time.monotonic(), float("-inf"), done
        self._note = ""
        self._lines = Lines(self._line, console, bar_in_notebook=True)
        self._progress: Any = None
        self._task: Any = None
        self._in_notebook: Any = None

    def __enter__(self) -> Bar:
        self._lines.start(LINE_EVERY)
        return self

    def __exit__(self, *_exception: object) -> None:
        self._lines.close()
        if self._progress is not None:
            self._progress.update(self._task, completed=self._done)
            self._progress.stop()
        if self._in_notebook is not None:
            self._in_notebook.close()

    def update(self, done: int, note: str = "") -> None:
        """Set how much of the total is done, and a note shown beside the bar."""
        self._done, self._note, now = done, note, time.monotonic()
        if now - self._began < WAIT or now - self._shown < REFRESH or self._lines.wanted:
            return
        self._shown = now
        if self._lines.console.is_jupyter:
            self._show_in_notebook()
            return
        if self._progress is None:
            self._start()
        self._progress.update(self._task, completed=done, note=note)

    def _show_in_notebook(self) -> None:
        from warp_rods.notebook import Shown

        if self._in_notebook is None:
            self._in_notebook = Shown()
        self._in_notebook.update(self._done / self._total if self._total else 1.0, self._line())

    def _line(self) -> str:
        """What, how much of it, how long the rest takes if it goes on like this, and the note."""
        parts = [f"{self._what}: {100 * self._done / self._total:.0f} % done"]
        if done := self._done - self._done_before:
            seconds = (time.monotonic() - self._began) * (self._total - self._done) / done
            parts.append(f"about {in_words(seconds)} left")
        return ", ".join([*parts, self._note] if self._note else parts)

    def _start(self) -> None:
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
        note = TextColumn("{task.fields[note]}")
        self._progress = Progress(*columns, note, console=self._lines.console, transient=True)
        self._task = self._progress.add_task(self._what, total=self._total, completed=self._done, note="")
        self._progress.start()


class Lines:
    """Lines about what goes on, as a function ``line`` tells, every half a minute; only where there is no terminal.

    bar_in_notebook: whether a notebook shows a bar instead.
    """

    def __init__(self, line: Callable[[], str], console: Console | None = None, *, bar_in_notebook: bool = False):
        self._line, self._console, self._bar_in_notebook = line, console, bar_in_notebook
        self._done = threading.Event()

    @property
    def console(self) -> Console:
        """Where they are shown: standard error, if no other console was given."""
        if self._console is None:
            from rich.console import Console

            self._console = Console(stderr=True, markup=False, highlight=False)
        return self._console

    @property
    def wanted(self) -> bool:
        """Whether there is nothing that shows a bar instead."""
        return not (self.console.is_terminal or (self._bar_in_notebook and self.console.is_jupyter))

    def start(self, first: float) -> None:
        """Tell after ``first`` seconds and then every half a minute; from a thread, as one step may take longer."""
        threading.Thread(target=self._tell, args=(first,), daemon=True).start()

    def close(self) -> None:
        """Tell no more."""
        self._done.set()

    def _tell(self, seconds: float) -> None:
        while not self._done.wait(seconds) and self.wanted:
            self.console.print(self._line(), soft_wrap=True)
            seconds = LINE_EVERY


def in_words(seconds: float) -> str:
    """A duration such as "3 h" or "40 s", with one or two digits."""
    for unit, one in (("years", 3.156e7), ("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 1.5 * one:
            return f"{float(f'{seconds / one:.2g}'):,g} {unit}"
    return f"{max(round(seconds), 0)} s"


def with_progress(items: Sequence[Item], what: str) -> Iterator[Item]:
    """The items one by one; after two seconds a terminal shows a bar with the label ``what``."""
    with Bar(what, len(items)) as bar:
        for done, item in enumerate(items):
            bar.update(done)
            yield item


@contextlib.contextmanager
def waiting(what: str, console: Console | None = None) -> Iterator[None]:
    """Show that something goes on whose end cannot be foretold; without a terminal in a line now and then."""
    began = time.monotonic()
    lines = Lines(lambda: f"{what}: {in_words(time.monotonic() - began)} so far", console, bar_in_notebook=True)
    lines.start(WAIT)
    try:
        with _in_notebook(what) if lines.console.is_jupyter else lines.console.status(f"{what} …"):
            yield
    finally:
        lines.close()


@contextlib.contextmanager
def _in_notebook(what: str) -> Iterator[None]:
    from warp_rods.notebook import Shown

    shown = Shown()
    shown.update(None, f"{what} …")
    try:
        yield
    finally:
        shown.close()

"""A progress bar for work that may take long."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from typing import TypeVar

Item = TypeVar("Item")
WAIT = 2.0
"""Seconds before a bar is shown."""


def with_progress(items: Sequence[Item], what: str) -> Iterator[Item]:
    """The items one by one; once two seconds have passed a terminal shows a bar called ``what``."""
    began = time.monotonic()
    for done, item in enumerate(items):
        if time.monotonic() - began > WAIT:
            yield from _with_bar(items, done, what)
            return
        yield item


def _with_bar(items: Sequence[Item], done: int, what: str) -> Iterator[Item]:
    """The items that are left."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    if not console.is_terminal:
        yield from items[done:]
        return
    with Progress(console=console, transient=True) as bar:
        task = bar.add_task(what, total=len(items), completed=done)
        for item in items[done:]:
            yield item
            bar.advance(task)

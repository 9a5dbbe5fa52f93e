"""Sequences of kernel launches that are recorded once as a graph and then replayed, at half a microsecond a launch."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import warp as wp

from warp_rods.device import cores, exclusive

_thread = threading.local()
"""``_thread.recording`` is true while the thread records a sequence."""


class Recorded:
    """Records ``launches`` as a graph on the first call, on the CPU too, and replays the graph on every call.

    A graph keeps scalars and pointers fixed, so what changes between steps is stored in device arrays. A sequence that
    is called while the same thread records a longer one becomes part of the longer one. Different threads may record
    and replay at the same time.
    """

    def __init__(self, launches: Callable[[], None], device: Any):
        self._launches, self._device = launches, device
        self._graph: Any = None

    def __call__(self) -> None:
        if getattr(_thread, "recording", False):
            self._launches()
        else:
            self.record()
            wp.capture_launch(self._graph)

    def record(self) -> None:
        """Record the graph, unless that has been done."""
        if self._graph is not None:
            return
        with exclusive:
            _thread.recording = True
            try:
                with wp.ScopedCapture(device=self._device) as capture:
                    self._launches()
            finally:
                _thread.recording = False
            self._graph = capture.graph


class RecordedInThreads:
    """Recorded sequences that write to different memory, replayed at the same time in one thread each.

    A launch on the CPU runs in one thread and releases Python's lock. The bits do not depend on the number of threads.
    """

    def __init__(self, sequences: Sequence[Callable[[], None]], device: Any):
        self._recorded = [Recorded(launches, device) for launches in sequences]

    @property
    def threads(self) -> int:
        """The number of sequences."""
        return len(self._recorded)

    def __call__(self) -> None:
        self._in_threads(self._recorded)

    def while_true(self, conditions: Sequence[Callable[[], bool]]) -> None:
        """Replay each sequence as long as its condition holds afterwards, at least once."""

        def repeat(recorded: Recorded, condition: Callable[[], bool]) -> None:
            recorded()
            while condition():
                recorded()

        pairs = zip(self._recorded, conditions, strict=True)
        self._in_threads([functools.partial(repeat, *pair) for pair in pairs])

    def _in_threads(self, tasks: Sequence[Callable[[], None]]) -> None:
        first, *others = tasks
        if not others:
            return first()
        for recorded in self._recorded:
            recorded.record()
        pending = [_pool().submit(task) for task in others]
        first()
        for replay in pending:
            replay.result()


@functools.cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max(cores() - 1, 1), thread_name_prefix="warp_rods")

"""A sequence of kernel launches, recorded once and replayed: a launch then costs half a microsecond."""

from __future__ import annotations

import functools
import itertools
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import warp as wp

from warp_rods.device import cores, exclusive

WORTH_A_THREAD = 10_000
"""Nodes that take a thread a millisecond; with fewer, handing work over costs a share worth speaking of."""

_here = threading.local()
"""Its ``recording`` is true in a thread that is recording a sequence."""


class Recorded:
    """Calls ``launches`` once under capture, on the CPU too, and replays the graph at every call.

    A graph freezes scalars and pointers: what changes between steps lives in device arrays. A sequence that is called
    while the same thread records a longer one becomes a part of that. Threads may record and replay at the same time.
    """

    def __init__(self, launches: Callable[[], None], device: Any):
        self._launches, self._device = launches, device
        self._graph: Any = None

    def __call__(self) -> None:
        if getattr(_here, "recording", False):
            self._launches()
        else:
            self.record()
            wp.capture_launch(self._graph)

    def record(self) -> None:
        """Capture the graph, if that has not been done."""
        if self._graph is not None:
            return
        with exclusive:
            _here.recording = True
            try:
                with wp.ScopedCapture(device=self._device) as capture:
                    self._launches()
            finally:
                _here.recording = False
            self._graph = capture.graph


class SideBySide:
    """Sequences that do not touch what others write, each recorded, and replayed at the same time, a thread each.

    A launch on the CPU runs on one thread and lets others run; the bits do not depend on how many there are.
    """

    def __init__(self, sequences: Sequence[Callable[[], None]], device: Any):
        self._recorded = [Recorded(launches, device) for launches in sequences]

    @property
    def threads(self) -> int:
        """How many there are."""
        return len(self._recorded)

    def __call__(self) -> None:
        first, *others = self._recorded
        if not others:
            return first()
        for recorded in self._recorded:
            recorded.record()
        waiting = [_pool().submit(recorded) for recorded in others]
        first()
        for replay in waiting:
            replay.result()


def slices(count: int, size: int, device: Any) -> list[slice]:
    """``count`` things of ``size`` nodes each in slices, one for each thread that is worth it; on CUDA one."""
    threads = 1 if wp.get_device(device).is_cuda else min(cores(), count * size // WORTH_A_THREAD, count)
    edges = [count * i // max(threads, 1) for i in range(max(threads, 1) + 1)]
    return [slice(a, b) for a, b in itertools.pairwise(edges)]


@functools.cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max(cores() - 1, 1), thread_name_prefix="warp_rods")

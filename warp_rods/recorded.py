"""A sequence of kernel launches, recorded once and replayed: a launch then costs half a microsecond."""

from collections.abc import Callable
from typing import Any

import warp as wp


class Recorded:
    """Calls ``launches`` once under capture, on the CPU too, and replays the graph at every call.

    A graph freezes scalars and pointers: what changes between steps lives in device arrays.
    """

    def __init__(self, launches: Callable[[], None], device):
        self._launches, self._device = launches, device
        self._graph: Any = None

    def __call__(self) -> None:
        if self._graph is None:
            with wp.ScopedCapture(device=self._device) as capture:
                self._launches()
            self._graph = capture.graph
        wp.capture_launch(self._graph)

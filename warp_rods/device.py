"""Use of Warp: quiet start, devices by name, one thread at a time where Warp needs that."""

from __future__ import annotations

import contextlib
import logging
import os
import sys
import threading
from collections.abc import Iterator
from typing import Any

import warp as wp

from warp_rods.errors import SceneError

LOG = logging.getLogger("warp_rods")
exclusive = threading.RLock()
"""A lock, held wherever this package launches, copies or allocates outside a recorded graph.

Warp records a graph for the whole process: launches of another thread during recording would become part of the graph.
Graphs are replayed without the lock, so that several threads can step their ensembles in parallel.
"""


def start() -> None:
    """Start Warp without its banner and its warning of a missing CUDA driver; later calls do nothing."""
    global _started
    with exclusive:
        if _started:
            return
        if wp.config.log_level == wp.LOG_INFO:  # another level was set by the user
            wp.config.log_level = wp.LOG_WARNING
        try:
            with _without_stderr():
                wp.init()
        except OSError as fault:  # it makes the folder of its cache
            raise SceneError(_no_cache(fault)) from None
        if not os.access(wp.config.kernel_cache_dir or "", os.W_OK):
            LOG.warning(_no_cache("it is read-only; what it holds can be used"))
        _started = True


_started = False


def said(fault: OSError) -> str:
    """What a fault of the system is, in words; of one in the kernel cache, with the remedy."""
    cache = wp.config.kernel_cache_dir
    return _no_cache(fault) if cache and str(fault.filename or "").startswith(str(cache)) else str(fault)


def _no_cache(why: object) -> str:
    return (
        f"the cache of compiled kernels cannot be written: {why}. Set WARP_CACHE_PATH to a folder that can: "
        f"WARP_CACHE_PATH=/tmp/kernels warp-rods …"
    )


class Shared:
    """A one-dimensional ``array`` of a few numbers that the host reads or writes in every step.

    On the CPU it is the same memory: a copy by Warp would take 30 µs.
    """

    def __init__(self, array: wp.array):
        self.array = array
        self._view = None if wp.get_device(array.device).is_cuda else array.numpy()

    def write(self, values: list[float]) -> None:
        """Set all numbers."""
        if self._view is not None:
            self._view[:] = values
        else:
            with exclusive:
                self.array.assign(values)

    def read(self) -> list[float]:
        """All numbers."""
        if self._view is not None:
            return self._view.tolist()
        with exclusive:
            return self.array.numpy().tolist()


def device(name: Any = None) -> wp.Device:
    """The Warp device with this name; by default that of Warp. Raises SceneError for an unknown device."""
    start()
    try:
        return wp.get_device(choose(name) if name == "auto" else name)
    except (ValueError, TypeError):
        raise _unknown(name) from None


def known() -> list[wp.Device]:
    """The devices of this machine."""
    start()
    return list(wp.get_devices())


def choose(name: str | None) -> str:
    """The name of a device; None or "auto" is CUDA where available. Raises SceneError for an unknown device."""
    names = [device.alias for device in known()]
    if name in (None, "auto"):
        return "cuda:0" if "cuda:0" in names else "cpu"
    if name not in names:
        raise _unknown(name)
    return name


def _unknown(name: object) -> SceneError:
    names = [device.alias for device in known()]
    return SceneError(f"device = {name}: no such device; must be one of {', '.join(['auto', *names])}")


def use_one_core() -> None:
    """Let this process step its rods in one thread, as other processes use the other cores."""
    global _cores
    _cores = 1


_cores: int | None = None


def cores() -> int:
    """The number of cores that this process may use."""
    if _cores is not None:
        return _cores
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextlib.contextmanager
def _without_stderr() -> Iterator[None]:
    """Silence native code, which writes to the file descriptor of standard error and not to the stream of Python."""
    try:
        sys.stderr.flush()
        kept, null = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    except (OSError, AttributeError):  # there is no standard error
        yield
        return
    os.dup2(null, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(null)

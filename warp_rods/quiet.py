"""Warp started without its greeting, nor its warning of a missing CUDA driver: no news to someone without one."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator

import warp as wp


def start_warp() -> None:
    """Start Warp; from here on it tells of warnings only."""
    wp.config.log_level = wp.LOG_WARNING
    with _without_stderr():
        wp.init()


@contextlib.contextmanager
def _without_stderr() -> Iterator[None]:
    """The warning comes from native code, which writes to the file and not to Python's stream."""
    sys.stderr.flush()
    kept, null = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(null)

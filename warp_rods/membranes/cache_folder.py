"""Files that can be made again, kept in the folder of Warp's compiled kernels."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path

import warp as wp

from warp_rods.device import start

__all__ = ["cache_folder", "replace_file"]


def cache_folder(name: str) -> Path:
    """The folder of this name in that of Warp's cache."""
    start()  # which decides where the cache is
    return Path(wp.config.kernel_cache_dir or tempfile.gettempdir()) / name


def replace_file(file: Path, content: bytes) -> None:
    """Replace a file as a whole: other processes may read it, or write it at the same time.

    A cache that cannot be written is no fault.
    """
    with contextlib.suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        number, partial = tempfile.mkstemp(dir=file.parent, suffix=".partial")
        try:
            with os.fdopen(number, "wb") as opened:
                opened.write(content)
            os.replace(partial, file)
        except OSError:
            os.unlink(partial)
            raise

"""Files of a folder that are written in halves, with something between them: a kill, or a disk that is full."""

import pathlib
from collections.abc import Callable
from pathlib import Path


class Halves:
    """A file that is written in halves, and ``between()`` them."""

    def __init__(self, file, between: Callable[[], object]):
        self._file, self._between = file, between

    def write(self, data) -> None:
        data = memoryview(data).cast("B")
        self._file.write(data[: len(data) // 2])
        self._file.flush()
        self._between()
        self._file.write(data[len(data) // 2 :])

    def __getattr__(self, name: str):
        return getattr(self._file, name)

    def __enter__(self):
        return self

    def __exit__(self, *_exception) -> None:
        self._file.close()


def opening(folder: Path, wrap: Callable):
    """In place of ``Path.open``: ``wrap(file)`` of every file in the folder that is opened to be written."""
    real = pathlib.Path.open

    def opened(path: Path, mode: str = "r", *rest, **named):
        file = real(path, mode, *rest, **named)
        return wrap(file) if mode in ("wb", "r+b") and str(folder) in str(path) else file

    return opened

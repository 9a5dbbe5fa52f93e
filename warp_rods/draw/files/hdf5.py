"""Files of HDF5 on disks that become full: the library crashes where it cannot write, and so never learns of it."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from warp_rods.draw.files.optional import needed

__all__ = ["new_file"]


@contextlib.contextmanager
def new_file(path: Path, option: str) -> Iterator[tuple[Any, _Forgiving]]:
    """A new ``h5py.File``, and the file below it, whose ``check`` is to be called from time to time.

    Raises OSError where it cannot be written, and WarpRodsError where h5py, which ``option`` needs, is not installed.
    """
    h5py = needed("h5py", option)
    with path.open("w+b", buffering=0) as disk:
        below = _Forgiving(disk)
        try:
            with h5py.File(below, "w") as file:
                yield file, below
        except RuntimeError as fault:  # how h5py tells of most that fails in the library
            below.check()
            raise OSError(str(fault)) from None
        below.check()


class _Forgiving(io.RawIOBase):
    """A file that keeps what can no longer be written, so that what is written to it can be read from it and closed."""

    def __init__(self, disk: BinaryIO | io.FileIO) -> None:
        super().__init__()
        self._disk, self._place, self._kept = disk, 0, list[tuple[int, bytes]]()
        self._end = 0
        self._fault: BaseException | None = None

    def check(self) -> None:
        """Raises what has failed since the file was opened: an OSError, or a signal that ended it."""
        if self._fault is not None:
            raise self._fault

    def write(self, data: Any) -> int:
        """Write at the present place; never fails."""
        view, first = memoryview(data).cast("B"), self._place
        try:
            if self._fault is None:
                self._disk.seek(first)
                rest = view
                while rest:
                    rest = rest[self._disk.write(rest) :]
        except BaseException as fault:
            self._fault = fault
        if self._fault is not None:
            self._kept.append((first, bytes(view)))
        self._place = first + len(view)
        self._end = max(self._end, self._place)
        return len(view)

    def readinto(self, buffer: Any) -> int:
        """Read at the present place what was written there, on the disk or not."""
        view, first = memoryview(buffer).cast("B"), self._place
        count = max(0, min(len(view), self._end - first))
        self._disk.seek(first)
        found = bytearray(self._disk.read(count)).ljust(count, b"\0")
        for place, data in self._kept:
            low, high = max(place, first), min(place + len(data), first + count)
            if low < high:
                found[low - first : high - first] = data[low - place : high - place]
        view[:count] = found
        self._place = first + count
        return count

    def truncate(self, size: int | None = None) -> int:
        """Set the end of the file; never fails."""
        self._end = self._place if size is None else size
        try:
            if self._fault is None:
                self._disk.truncate(self._end)
        except BaseException as fault:
            self._fault = fault
        return self._end

    def seek(self, place: int, whence: int = io.SEEK_SET) -> int:
        """Go to a place."""
        self._place = place + {io.SEEK_SET: 0, io.SEEK_CUR: self._place, io.SEEK_END: self._end}[whence]
        return self._place

    def tell(self) -> int:
        """The present place."""
        return self._place

"""The files of one array of a trajectory: where each frame is, and its bytes with their checksum.

A large frame is a chunk of its own in a shard (Zarr's codec ``sharding_indexed``). The index at the start of a shard
lists the places of all frames that the file can hold: chunks are not compressed, so their sizes are known. A frame is
written once, in its place, and nothing else in the file changes. Several small frames make one chunk, a file that is
replaced whenever more of them come.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import google_crc32c  # the package that Zarr uses for its codec crc32c
import numpy as np

from warp_rods.errors import RunFolderError
from warp_rods.simulation.files import replace_file

__all__ = ["Chunks", "column", "crc"]


def crc(data: Any) -> bytes:
    """The checksum CRC32C that Zarr's codec ``crc32c`` appends to a chunk."""
    return google_crc32c.value(bytes(data)).to_bytes(4, "little")


@dataclass(frozen=True)
class Chunks:
    """The files of an array, from its metadata; an array without the dimension ``frame`` is one frame."""

    folder: Path
    shape: tuple[int, ...]
    """The shape of a frame."""
    dtype: str
    per_file: int
    """Frames in one file."""
    sharded: bool
    checked: bool
    """Whether chunks have checksums; in stores of earlier versions they have none."""
    required: bool
    """Whether a missing file is damage; otherwise it means the fill value."""
    fill: Any
    separator: str
    dimensions: int

    @classmethod
    def of(cls, node: Mapping[str, Any], folder: Path) -> Chunks:
        """From the metadata of an array (its ``zarr.json``) and its folder."""
        moving = list(node.get("dimension_names") or ())[:1] == ["frame"]
        grid, codecs = node["chunk_grid"]["configuration"]["chunk_shape"], node["codecs"]
        sharded = codecs[0]["name"] == "sharding_indexed"
        inner = codecs[0]["configuration"]["codecs"] if sharded else codecs
        return cls(
            folder,
            tuple(node["shape"][moving:]),
            node["data_type"],
            grid[0] if moving else 1,
            sharded,
            checked := any(codec["name"] == "crc32c" for codec in inner),
            checked and (moving or not _is_its_fill_value(node)),
            node["fill_value"],
            node["chunk_key_encoding"].get("configuration", {}).get("separator", "/"),
            len(grid),
        )

    @cached_property
    def frame_bytes(self) -> int:
        """Bytes of a frame without checksum."""
        return math.prod(self.shape) * np.dtype(self.dtype).itemsize

    def in_its_type(self, values: Any, copy: bool) -> np.ndarray:
        """The values of a frame as they are stored; what single precision cannot hold is infinite."""
        with np.errstate(over="ignore"):
            return np.array(values, dtype=self.dtype, order="C", copy=copy or None)

    @cached_property
    def index(self) -> bytes:
        """The index of a shard: place and size of each chunk, and a checksum."""
        size, count = self.frame_bytes + 4, self.per_file
        places = 16 * count + 4 + size * np.arange(count)
        table = np.stack([places, np.full(count, size)], axis=-1).astype("<u8").tobytes()
        return table + crc(table)

    def file(self, frame: int) -> Path:
        """The file that holds a frame."""
        place = [frame // self.per_file, *[0] * (self.dimensions - 1)][: self.dimensions]
        return self.folder / self.separator.join(["c", *map(str, place)])

    def place(self, frame: int) -> int:
        """The first byte of a frame in its shard."""
        return len(self.index) + (frame % self.per_file) * (self.frame_bytes + 4)

    def holds(self, frame: int) -> bool:
        """Whether a frame is in the files, as far as their sizes tell."""
        path = self.file(frame)
        least = self.place(frame) + self.frame_bytes + 4 if self.sharded else 0
        return path.is_file() and path.stat().st_size >= least

    def first_missing(self, frames: Iterable[int]) -> int | None:
        """The first of these frames that is not in the files; None where all are, or a missing file is no damage."""
        return next((frame for frame in frames if not self.holds(frame)), None) if self.required else None

    def damage(self, problem: object) -> RunFolderError:
        """The error for a file of this array that cannot be used."""
        return RunFolderError(f"{self.folder.parent.name}/{self.folder.name} is damaged: {problem}")


def column(chunks: Chunks, frames: int, partial: Path) -> Appended | Rewritten:
    """A writer after the first ``frames`` frames; ``partial`` is a temporary name on the same file system.

    Raises RunFolderError where a file that is to be continued is missing or damaged.
    """
    return (Appended if chunks.sharded else Rewritten)(chunks, frames, partial)


class Appended:
    """Writes large frames into shards, each once."""

    def __init__(self, chunks: Chunks, frames: int, partial: Path) -> None:
        self.chunks, self._partial = chunks, partial
        if frames % chunks.per_file and not chunks.holds(frames - 1):
            raise chunks.damage(f"frame {frames - 1} is missing")
        if frames % chunks.per_file:
            with chunks.file(frames - 1).open("rb") as file:
                if file.read(len(chunks.index)) != chunks.index:
                    raise chunks.damage(f"the index of {file.name} is wrong")

    def put(self, first: int, frames: Sequence[np.ndarray]) -> None:
        """Write frames in the type of the array, from the number ``first`` on; those in one file with one write."""
        for number, part in _by_file(self.chunks, first, frames):
            whole = [values.tobytes() for values in part]
            data = b"".join(piece + crc(piece) for piece in whole)
            path = self.chunks.file(number)
            if number % self.chunks.per_file == 0:
                replace_file(path, self.chunks.index + data, self._partial)
                continue
            with path.open("r+b") as file:  # must exist: a run must not make a new store where one was removed
                file.seek(self.chunks.place(number))
                file.write(data)


class Rewritten:
    """Writes small frames: the chunk that is being filled is kept here, and its file is replaced as a whole."""

    def __init__(self, chunks: Chunks, frames: int, partial: Path) -> None:
        self.chunks, self._partial = chunks, partial
        fill = np.nan if chunks.fill == "NaN" else chunks.fill
        self._values = np.full((chunks.per_file, *chunks.shape), fill, chunks.dtype)
        filled = frames % chunks.per_file
        if filled and (chunks.required or chunks.file(frames - 1).exists()):
            self._values[:filled] = self._read(frames - 1)[:filled]

    def put(self, first: int, frames: Sequence[np.ndarray]) -> None:
        """Write frames from the number ``first`` on; each file once."""
        for number, part in _by_file(self.chunks, first, frames):
            place = number % self.chunks.per_file
            self._values[place : place + len(part)] = part
            data, path = self._values.tobytes(), self.chunks.file(number)
            if not self.chunks.checked:  # a store of an earlier version, where chunks have folders
                path.parent.mkdir(parents=True, exist_ok=True)
            replace_file(path, data + crc(data) if self.chunks.checked else data, self._partial)

    def _read(self, frame: int) -> np.ndarray:
        path = self.chunks.file(frame)
        try:
            data = path.read_bytes()
        except OSError as fault:
            raise self.chunks.damage(fault) from None
        if self.chunks.checked:
            data, stored = data[:-4], data[-4:]
            if crc(data) != stored:
                raise self.chunks.damage(f"the checksum of {path} is wrong")
        if len(data) != self._values.nbytes:
            raise self.chunks.damage(f"{path} has {len(data)} bytes, not {self._values.nbytes}")
        return np.frombuffer(data, self._values.dtype).reshape(self._values.shape)


def _by_file(chunks: Chunks, first: int, frames: Sequence[np.ndarray]) -> Iterator[tuple[int, Sequence[np.ndarray]]]:
    """Frames from the number ``first`` on, divided into files: the number of the first one in each, and its frames."""
    done = 0
    while done < len(frames):
        number = first + done
        fit = chunks.per_file - number % chunks.per_file
        yield number, frames[done : done + fit]
        done += fit


def _is_its_fill_value(node: Mapping[str, Any]) -> bool:
    """Whether all values of an array without frames equal its fill value, so that no file is needed."""
    return node["data_type"].startswith("float") and node["fill_value"] != "NaN"

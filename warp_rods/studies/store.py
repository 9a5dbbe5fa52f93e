"""The store of a study: one labelled Zarr store, ``xarray.open_zarr(path)``, written in regions as tasks finish.

Dimensions are the swept keys and ``seed``. A task has one chunk of every array, a file. Its file of ``state`` is
written last: what it says is in the other files. Every file is replaced as a whole, so that a reader, or a task that
does the same again after a kill, meets whole chunks only. Of several tasks in one chunk one writes at a time, and a
point that is finished stays as it is.
"""

from __future__ import annotations

import contextlib
import json
import math
import shutil
import struct
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.errors import RunFolderError
from warp_rods.simulation.chunks import crc
from warp_rods.simulation.files import STUDY, replace_file
from warp_rods.simulation.leftovers import this_process
from warp_rods.simulation.zarr_format import (
    METADATA,
    text_chunk,
)
from warp_rods.studies.columns import Column
from warp_rods.studies.marks import MarkLost, alone

__all__ = ["COMPUTED", "FAILED", "FINISHED", "LOST", "OWN", "STATES", "STORE", "Store"]

STORE = STUDY
STATE = "state"
COMPUTED, LOST, FAILED = 1, 2, 3
"""States of a point: measured; all its rods lost, or one where a run would stop; not possible to simulate."""
STATES = {0: "not computed", COMPUTED: "computed", LOST: "lost", FAILED: "failed"}
OWN: dict[str, tuple[str, Any, dict[str, Any]]] = {
    STATE: ("int8", 0, {"long_name": "state of the point", "flag_values": list(STATES),
                        "flag_meanings": " ".join(word.replace(" ", "_") for word in STATES.values())}),
    "settled": ("int8", -1, {"long_name": "whether the motion had settled: 1, 0, or −1 where it cannot be told"}),
    "lost": ("int32", 0, {"long_name": "rods that were lost"}),
    "message": ("string", "", {"long_name": "why the point was lost or failed; warnings"}),
    "trajectory": ("string", "", {"long_name": "the folder of the run of the point"}),
}  # fmt: skip
"""What every study has at each point: type, fill value, attributes."""
FINISHED = (COMPUTED, LOST)
OLD = 600.0
"""Seconds after which a temporary file is a leftover of a process that was killed."""


@dataclass(frozen=True)
class Store:
    """A store at ``path``, which ``new_store.create`` made."""

    path: Path

    # --- what there is -------------------------------------------------------------------------------------------

    @cached_property
    def _document(self) -> dict[str, Any]:
        try:
            return json.loads((self.path / METADATA).read_bytes())  # type: ignore[no-any-return]
        except FileNotFoundError:
            raise RunFolderError(
                f"There is no study in {self.path.parent}: {self.path.name} is missing. Give the folder that "
                f"`warp-rods sweep SCENE --out DIR` wrote."
            ) from None
        except (OSError, ValueError) as fault:
            raise RunFolderError(f"{self.path / METADATA} cannot be read ({fault}): start the study again.") from None

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the root."""
        return dict(self._document["attributes"])

    @property
    def identity(self) -> str:
        """A word that no other study has."""
        return str(self.attributes.get("study", ""))

    @cached_property
    def _nodes(self) -> dict[str, Any]:
        return dict(self._document["consolidated_metadata"]["metadata"])

    @cached_property
    def variables(self) -> list[str]:
        """Variables at the points, the state last."""
        first = self._nodes[STATE]["dimension_names"]
        names = [
            n for n, node in self._nodes.items() if node["dimension_names"][: len(first)] == first and n not in first
        ]
        return [*(name for name in names if name != STATE), STATE]

    @property
    def dims(self) -> tuple[str, ...]:
        """The swept keys, and the seeds; a file in TOML may have another order."""
        return tuple(self._nodes[STATE]["dimension_names"])

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """The shape of the grid of points."""
        return tuple(self._nodes[STATE]["shape"])

    @cached_property
    def scalars(self) -> list[str]:
        """Measures without further dimensions."""
        return [n for n in self.variables if n not in OWN and len(self._nodes[n]["shape"]) == len(self.shape)]

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The measures with their further dimensions and the labels of these."""
        return tuple(self._column(name) for name in self.variables if name not in OWN)

    def _column(self, name: str) -> Column:
        node, points = self._nodes[name], len(self.shape)
        dims = tuple(node["dimension_names"][points:])
        labels = {dim: self._read(dim, (0,)).tolist() for dim in dims if dim in self._nodes}
        text = node["data_type"] == "string"
        return Column(name, dims, tuple(node["shape"][points:]), labels, text, node["attributes"])

    @cached_property
    def chunk(self) -> tuple[int, ...]:
        """The shape of a chunk of points."""
        return tuple(self._nodes[STATE]["chunk_grid"]["configuration"]["chunk_shape"])

    def chunks(self) -> Iterator[tuple[int, ...]]:
        """The numbers of all chunks."""
        return np.ndindex(*(-(-n // c) for n, c in zip(self.shape, self.chunk, strict=True)))

    def region(self, chunk: Sequence[int]) -> tuple[slice, ...]:
        """Where a chunk is in the grid."""
        ends = zip(chunk, self.chunk, self.shape, strict=True)
        return tuple(slice(i * c, min((i + 1) * c, n)) for i, c, n in ends)

    # --- reading and writing -----------------------------------------------------------------------------------------

    def states(self) -> np.ndarray:
        """The state of each point of the grid; 0 where a file cannot be read, so that it is computed again."""
        return self.whole(STATE)

    def whole(self, name: str) -> np.ndarray:
        """A variable without further dimensions at all points of the grid."""
        found = self._read(name, (0,) * len(self.shape))
        whole = np.full(self.shape, found.flat[0], dtype=found.dtype)
        for chunk in self.chunks():
            region = self.region(chunk)
            whole[region] = self._read(name, chunk)[tuple(slice(0, part.stop - part.start) for part in region)]
        return whole

    def state(self, points: Sequence[tuple[int, ...]], chunk: Sequence[int]) -> np.ndarray:
        """The states of points of a chunk."""
        return np.asarray(self._read(STATE, chunk)[self._inside(chunk, points)])

    def times(self) -> dict[tuple[int, ...], float]:
        """When each chunk was last written, in seconds since 1970."""
        found = {}
        for file in (self.path / STATE).glob("c.*"):
            with contextlib.suppress(FileNotFoundError):
                found[tuple(map(int, file.name.split(".")[1:]))] = file.stat().st_mtime
        return found

    def put(self, chunk: Sequence[int], points: Sequence[tuple[int, ...]], values: Mapping[str, np.ndarray]) -> None:
        """Write values [point, …] at those points of a chunk that are not finished; raises OSError.

        Raises RunFolderError where another study has taken the place of this one.
        """
        while True:
            with contextlib.suppress(MarkLost), alone(self._mark(chunk)) as still_alone:
                self._check_that_it_is_there()
                self._add(chunk, points, values, still_alone)
                return

    def _add(
        self, chunk: Sequence[int], points: Sequence[tuple[int, ...]], values: Mapping[str, np.ndarray],
        still_alone: Callable[[], None],
    ) -> None:  # fmt: skip
        whole = {name: self._read(name, chunk) for name in self.variables if name in values}
        inside = self._inside(chunk, points)
        left = ~np.isin(whole[STATE][inside], FINISHED)
        if not left.any():
            return
        for name, chunk_of_it in whole.items():
            chunk_of_it[tuple(i[left] for i in inside)] = values[name][left]
            data, file = self._encoded(name, chunk_of_it), self._file(name, chunk)
            replace_file(file, data, self.partial(), durable=True, before=still_alone)

    def forget_damaged(self) -> list[Path]:
        """Let points, a file of whose chunk is damaged or lacking, be computed again; returns these files."""
        found = []
        for chunk in self.chunks():
            if not np.isin(self._read(STATE, chunk), FINISHED).any():
                continue
            wrong = [file for name in self.variables if not _is_whole(file := self._file(name, chunk))]
            if wrong:
                with alone(self._mark(chunk)):
                    for file in (self._file(STATE, chunk), *wrong):
                        file.unlink(missing_ok=True)
            found += wrong
        return found

    def _inside(self, chunk: Sequence[int], points: Sequence[tuple[int, ...]]) -> tuple[np.ndarray, ...]:
        """The places of points in their chunk."""
        return tuple(np.array(points).T - np.array([[part.start] for part in self.region(chunk)]))

    def _check_that_it_is_there(self) -> None:
        try:
            there = json.loads((self.path / METADATA).read_bytes())["attributes"].get("study", "")
        except FileNotFoundError:
            there = None
        if there != self.identity:
            raise RunFolderError(f"{self.path} was removed, or replaced by another study, while this one was at work")

    def _mark(self, chunk: Sequence[int]) -> Path:
        """The mark of who writes to a chunk."""
        return self.path.with_name(f".{self.path.name}.{'.'.join(map(str, chunk))}.writing")

    def _file(self, name: str, chunk: Sequence[int]) -> Path:
        further = len(self._nodes[name]["shape"]) - len(chunk)
        return self.path / name / ".".join(["c", *map(str, chunk), *["0"] * further])

    def _read(self, name: str, chunk: Sequence[int]) -> np.ndarray:
        """A whole chunk of a variable; its fill value where there is no file, or it is damaged."""
        node = self._nodes[name]
        shape = tuple(node["chunk_grid"]["configuration"]["chunk_shape"])
        text = node["data_type"] == "string"
        empty = np.full(shape, "" if text else _fill(node), dtype=object if text else node["data_type"])
        try:
            data = self._file(name, chunk).read_bytes()
        except FileNotFoundError:
            return empty
        if not _is_right(data):
            return empty
        if text:
            return np.array(_texts(data[:-4]), dtype=object).reshape(shape)
        return np.frombuffer(data[:-4], node["data_type"]).reshape(shape).copy()

    def _encoded(self, name: str, values: np.ndarray) -> bytes:
        text = self._nodes[name]["data_type"] == "string"
        data = text_chunk([str(value) for value in values.flat]) if text else np.ascontiguousarray(values).tobytes()
        return data + crc(data)

    def partial(self) -> Path:
        """A temporary name that no other process uses."""
        return self.path.with_name(f".{self.path.name}.{this_process()}-{threading.get_ident()}.partial")

    def clear_leftovers(self) -> None:
        """Remove temporary files of processes that were killed."""
        for file in self.path.parent.glob(f".{self.path.name}.*"):
            with contextlib.suppress(FileNotFoundError):  # another process does the same
                if time.time() - file.stat().st_mtime > OLD:
                    shutil.rmtree(file, ignore_errors=True) if file.is_dir() else file.unlink()


def _is_whole(file: Path) -> bool:
    """Whether a chunk is there, and as it was written."""
    return file.is_file() and _is_right(file.read_bytes())


def _is_right(data: bytes) -> bool:
    """Whether the bytes of a chunk agree with their checksum."""
    return crc(data[:-4]) == data[-4:]


def _fill(node: Mapping[str, Any]) -> Any:
    return math.nan if node["fill_value"] == "NaN" else node["fill_value"]


def _texts(data: bytes) -> list[str]:
    """Texts of a chunk that ``text_chunk`` made."""
    found, at = list[str](), 4
    for _ in range(struct.unpack_from("<I", data)[0]):
        (size,) = struct.unpack_from("<I", data, at)
        found.append(data[at + 4 : at + 4 + size].decode())
        at += 4 + size
    return found

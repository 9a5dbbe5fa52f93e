"""Groups and arrays in Zarr's format 3, as zarr-python writes them; its import alone takes half a second.

Chunks have a checksum and are not compressed: positions hardly compress, compression would take a third of the time,
and sizes of chunks would not be known. All chunks of an array are in its own folder.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.simulation.chunks import crc

__all__ = ["METADATA", "NUMBERS", "TEXT", "text_chunk", "write_array", "write_group", "write_labels", "write_values"]

METADATA = "zarr.json"
_BYTES = {"name": "bytes", "configuration": {"endian": "little"}}
_CRC = {"name": "crc32c"}
NUMBERS = (_BYTES, _CRC)
"""The codecs of arrays of numbers."""
TEXT = ({"name": "vlen-utf8", "configuration": {}}, _CRC)
"""The codecs of arrays of text."""


def write_group(folder: Path, attributes: Mapping[str, Any]) -> None:
    """A group without members in a new folder."""
    folder.mkdir(parents=True)
    _write(folder, {"attributes": dict(attributes), "zarr_format": 3, "node_type": "group"})


def write_labels(folder: Path, labels: Sequence[str], attributes: Mapping[str, Any] | None = None) -> None:
    """The array of the names of the entries of a dimension, which is the name of the new folder."""
    shape = (len(labels),)
    write_array(folder, shape, "string", "", (folder.name,), attributes or {}, codecs=TEXT)
    _write_chunk(folder, shape, text_chunk(labels))


def text_chunk(texts: Sequence[str]) -> bytes:
    """A chunk of an array of text, without its checksum."""
    parts = [text.encode() for text in texts]
    return struct.pack("<I", len(parts)) + b"".join(struct.pack("<I", len(part)) + part for part in parts)


def write_values(folder: Path, values: np.ndarray, dims: Sequence[str], attributes: Mapping[str, Any]) -> None:
    """An array [...] of numbers with its values. Where they are all equal they are its fill value, without a file."""
    first = values.flat[0].item()
    equal, other = bool((values == first).all()), math.nan if values.dtype.kind == "f" else 0
    write_array(folder, values.shape, str(values.dtype), first if equal else other, dims, attributes)
    if not equal:
        _write_chunk(folder, values.shape, np.ascontiguousarray(values).tobytes())


def write_array(
    folder: Path,
    shape: Sequence[int],
    dtype: str,
    fill: Any,
    dims: Sequence[str],
    attributes: Mapping[str, Any],
    *,
    file_shape: Sequence[int] | None = None,
    chunk: Sequence[int] | None = None,
    codecs: Sequence[Mapping[str, Any]] = NUMBERS,
) -> None:
    """An array without chunks in a new folder.

    file_shape: the part of it that is in one file; by default all. chunk: the parts of a file that are chunks with a
    checksum each, behind an index (the codec ``sharding_indexed``); None: the file is one chunk.
    """
    folder.mkdir()
    if chunk is not None:
        shards = {"chunk_shape": list(chunk), "codecs": list(codecs), "index_codecs": [_BYTES, _CRC]}
        codecs = [{"name": "sharding_indexed", "configuration": shards | {"index_location": "start"}}]
    grid = {"name": "regular", "configuration": {"chunk_shape": list(shape if file_shape is None else file_shape)}}
    document = {
        "shape": list(shape),
        "data_type": dtype,
        "chunk_grid": grid,
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
        "fill_value": _in_json(fill),
        "codecs": list(codecs),
        "attributes": dict(attributes),
        "dimension_names": list(dims),
        "zarr_format": 3,
        "node_type": "array",
        "storage_transformers": [],
    }
    _write(folder, document)


def _in_json(fill: Any) -> Any:
    """A fill value as the format writes it."""
    if not isinstance(fill, float) or math.isfinite(fill):
        return fill
    return "NaN" if math.isnan(fill) else "Infinity" if fill > 0 else "-Infinity"


def _write_chunk(folder: Path, shape: Sequence[int], data: bytes) -> None:
    """The only chunk of an array of this shape."""
    (folder / ".".join(["c", *("0" for _ in shape)])).write_bytes(data + crc(data))


def _write(folder: Path, document: Mapping[str, Any]) -> None:
    (folder / METADATA).write_text(json.dumps(document, allow_nan=False), encoding="ascii")

"""Makes the store of a study: all arrays with their labels and attributes, none with values at points."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.simulation.files import replace_file
from warp_rods.simulation.leftovers import replace_folder, this_process
from warp_rods.simulation.zarr_format import (
    METADATA,
    NUMBERS,
    TEXT,
    write_array,
    write_group,
    write_labels,
    write_values,
)
from warp_rods.studies.axes import SEED, Axis
from warp_rods.studies.columns import Column
from warp_rods.studies.store import OWN, Store

__all__ = ["create"]


def create(
    path: Path, axes: Sequence[Axis], columns: Sequence[Column], chunk: Sequence[int],
    own: Sequence[str], attributes: Mapping[str, Any], explained: Mapping[str, Mapping[str, Any]],
    overwrite: bool = False,
) -> Store:  # fmt: skip
    """A store that appears as a whole, with ``overwrite`` in place of the one that is there.

    Where another process was faster, its store, which may be that of another study.
    """
    new = path.with_name(f".{path.name}.{this_process()}.new")
    shutil.rmtree(new, ignore_errors=True)
    write_group(new, attributes)
    shape, dims = tuple(map(len, axes)), tuple(axis.key for axis in axes)
    for axis in axes:
        _write_axis(new / axis.key, axis)
    for name, labels in {dim: v for column in columns for dim, v in column.labels.items()}.items():
        _write_labels(new / name, name, labels)
    for name in own:
        dtype, fill, said = OWN[name]
        _write_empty(new / name, shape, dtype, fill, dims, {**said, **explained.get(name, {})}, chunk)
    for column in columns:
        dtype, fill = ("string", "") if column.text else ("float64", math.nan)
        whole = (*shape, *column.shape)
        chunks = (*chunk, *column.shape)
        _write_empty(new / column.name, whole, dtype, fill, (*dims, *column.dims), column.attributes, chunks)
    _consolidate(new)
    try:
        if overwrite and path.exists():
            replace_folder(path, new)
        else:
            new.rename(path)
    except OSError:
        shutil.rmtree(new, ignore_errors=True)
        if not (path / METADATA).exists():
            raise
    return Store(path)


def _write_axis(folder: Path, axis: Axis) -> None:
    labels = axis.labels
    said = {"scale": axis.scale, "first_points": f"every {axis.stride}"} if axis.key != SEED else {"long_name": "seed"}
    if labels.dtype == object:
        write_labels(folder, [str(label) for label in labels], said)
    else:
        write_values(folder, labels, (axis.key,), said)


def _write_labels(folder: Path, name: str, labels: Sequence[Any]) -> None:
    if all(isinstance(label, (int, float)) for label in labels):
        write_values(folder, np.array(labels), (name,), {})
    else:
        write_labels(folder, [str(label) for label in labels])


def _write_empty(
    folder: Path, shape: Sequence[int], dtype: str, fill: Any, dims: Sequence[str], attributes: Mapping[str, Any],
    chunk: Sequence[int],
) -> None:  # fmt: skip
    codecs = TEXT if dtype == "string" else NUMBERS
    write_array(folder, shape, dtype, fill, dims, attributes, file_shape=chunk, codecs=codecs)


def _consolidate(folder: Path) -> None:
    """Put the metadata of all arrays into the root."""
    nodes = {file.parent.name: json.loads(file.read_bytes()) for file in sorted(folder.glob(f"*/{METADATA}"))}
    root = json.loads((folder / METADATA).read_bytes())
    root["consolidated_metadata"] = {"kind": "inline", "must_understand": False, "metadata": nodes}
    replace_file(folder / METADATA, json.dumps(root).encode())

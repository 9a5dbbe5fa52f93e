"""Starts that a run, or ``wr.steady``, kept in one file: arrays at the nodes, and where they are from."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.archive import read_archive
from warp_rods.centrelines.track import TrackError
from warp_rods.scene.filaments import FilamentsTable
from warp_rods.scene.scene import Scene
from warp_rods.scene.swimmers import SwimmersTable
from warp_rods.simulation.start_arrays import Arrays, Given, Source, resampled

__all__ = ["KEPT_STARTS", "archive", "from_kept", "kept_starts", "stored", "tables_from_files", "with_starts"]

KEPT_STARTS = "starts.npz"
"""The file in a run folder with the shapes of rods that came from files."""
NEEDED = {
    "swimmers": ("strain", "position", "rotation"),
    "filaments": ("line", "tangent", "geodesic_curvature", "length"),
}
OWN = ("points", "run", "kind", "perturbation")
"""Keys of a shape that do not choose what is read."""

Table = SwimmersTable | FilamentsTable


def kept_starts(scene: Scene, starts: Mapping[str, Given]) -> tuple[bytes, dict[str, Any]]:
    """The content of a file with the starts of a scene, and their provenance.

    Of each ensemble, by its name, arrays at its nodes, the keys of its table and its sources.
    """
    arrays: dict[str, Any] = {}
    for table in tables_from_files(scene).values():
        arrays |= stored(table, starts[table.name].at(table.node_count)[0], starts[table.name].sources)
    data = archive(arrays)
    every = {name: list(map(list, given.sources)) for name, given in starts.items()}
    sources = list(dict.fromkeys(source for given in starts.values() for source in given.sources))
    return data, {
        "sha256": hashlib.sha256(data).hexdigest(),
        "source": ", ".join(path for path, _ in sources),
        "source_sha256": hashlib.sha256(json.dumps(sources).encode()).hexdigest(),
        "sources": every,
    }


def stored(table: Table, values: Arrays, sources: tuple[Source, ...]) -> dict[str, np.ndarray]:
    """The arrays of one ensemble in such a file."""
    words = {"keys": json.dumps(keys_of(table), sort_keys=True), "sources": json.dumps(sources)}
    arrays = values | {key: np.array(text) for key, text in words.items()}
    return {f"{table.name}/{key}": value for key, value in arrays.items()}


def archive(arrays: Mapping[str, np.ndarray]) -> bytes:
    """The content of a file with these arrays."""
    buffer, given = io.BytesIO(), dict[str, Any](arrays)
    np.savez(buffer, **given)
    return buffer.getvalue()


def keys_of(table: Table) -> dict[str, Any]:
    """The keys of a shape that choose what is read from its file."""
    assert table.shape is not None
    kept: dict[str, Any] = json.loads(table.shape.model_dump_json(exclude_none=True, exclude=set(OWN)))
    length = getattr(table, "length", None)
    return kept if length is None else kept | {"length": json.loads(json.dumps(length))}


def from_kept(table: Table, path: Path) -> Given:
    """The start of an ensemble in a file; raises TrackError for a damaged file, and for another count or other keys."""
    try:
        stored = read_archive(path)
    except ValueError as fault:
        raise TrackError(f"is no start that a run kept, or is damaged: {fault}") from None
    names = list(dict.fromkeys(name.partition("/")[0] for name in stored))
    name = table.name if table.name in names or len(names) != 1 else names[0]
    arrays = {key.partition("/")[2]: value for key, value in stored.items() if key.startswith(f"{name}/")}
    kind = "swimmers" if isinstance(table, SwimmersTable) else "filaments"
    if not {*NEEDED[kind], "keys", "sources"} <= arrays.keys():
        raise TrackError(f"has no start of {kind} named {table.name}; it has {', '.join(names) or 'none'}")
    keys, sources = (json.loads(str(arrays.pop(key))) for key in ("keys", "sources"))
    if (count := len(arrays[NEEDED[kind][0]])) != table.count:
        raise TrackError(f"is a start of {count} rods, and count = {table.count}: give the same count")
    if (asked := keys_of(table)) != keys:
        key = next(key for key in (*keys, *asked) if keys.get(key) != asked.get(key))
        raise TrackError(
            f"is a start that was kept, read with {key} = {keys.get(key, 'none')}, not {asked.get(key, 'none')}: give "
            f"the original file to read it again"
        )
    return Given(lambda nodes: (resampled(arrays, nodes), []), tuple((path, sha) for path, sha in sources))


def tables_from_files(scene: Scene) -> dict[str, Table]:
    """The tables whose shape is from a file, by their key paths."""
    return {
        f"{kind}[{index}]": table
        for kind in ("filaments", "swimmers")
        for index, table in enumerate(getattr(scene, kind))
        if table.shape is not None and table.shape.from_file
    }


def with_starts(scene: Scene, path: str) -> Scene:
    """The scene with the shapes that are from files in this file."""

    def changed(table: Table) -> Table:
        if table.shape is None or not table.shape.from_file:
            return table
        key = "run" if table.shape.run is not None else "points"
        return table.model_copy(update={"shape": table.shape.model_copy(update={key: path})})

    return scene.model_copy(
        update={kind: tuple(map(changed, getattr(scene, kind))) for kind in ("filaments", "swimmers")}
    )

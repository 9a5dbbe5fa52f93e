"""The root of a store of a trajectory: attributes and the metadata of all arrays, in one file with a checksum.

The file is the ``zarr.json`` of the root with consolidated metadata. It is replaced as a whole after the files of a
frame are written: all arrays grow by this frame at the same moment, for every reader.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.errors import RunFolderError
from warp_rods.simulation.chunks import Chunks
from warp_rods.simulation.files import STUDY, beside, no_run, replace_file
from warp_rods.simulation.zarr_format import METADATA

__all__ = ["CHECKSUM", "FRAMES", "METADATA", "Document"]

FRAMES = "complete_frames"
"""The attribute of the root with the number of complete frames."""
EARLIER_FRAMES = "_complete_frames"
"""The array with that number in stores of earlier versions."""
CHECKSUM = "metadata_sha256"
"""The attribute of the root with the SHA-256 of everything else in its file."""


@dataclass
class Document:
    """Attributes of the root, and the metadata of groups and arrays by path (``sensors``, ``sensors/position``)."""

    path: Path
    """The folder of the store."""
    attributes: dict[str, Any]
    nodes: dict[str, dict[str, Any]]
    _written: os.stat_result | None = field(default=None, repr=False)

    @classmethod
    def read(cls, path: Path) -> Document:
        """The root of the store at ``path``.

        Raises RunFolderError where there is no store, it is damaged, or it is not one of this version.
        """
        document = _parsed(path / METADATA)
        attributes = document.get("attributes")
        if not isinstance(attributes, dict) or CHECKSUM not in attributes:
            return cls._earlier(path)
        if attributes[CHECKSUM] != _checksum(document):
            raise RunFolderError(
                f"{path / METADATA} is damaged, or was changed by another program: its checksum is wrong. Restore it "
                f"from a copy, or run the scene again."
            )
        return cls(path, attributes, document["consolidated_metadata"]["metadata"])

    @classmethod
    def _earlier(cls, path: Path) -> Document:
        """The root of a store of an earlier version, which has the number of complete frames in an array."""
        if not (path / EARLIER_FRAMES / METADATA).is_file():
            raise RunFolderError(
                f"{path} is not a trajectory of warp-rods, or its {METADATA} is damaged: restore it from a copy, or "
                f"run the scene again."
            )
        import zarr

        document = cls.collect(path)
        del document.nodes[EARLIER_FRAMES]
        try:
            document.attributes[FRAMES] = int(np.asarray(zarr.open_array(path / EARLIER_FRAMES, mode="r")[...]))
        except Exception as fault:  # each codec of Zarr raises its own
            raise RunFolderError(f"{path / EARLIER_FRAMES} is damaged ({fault}): run the scene again.") from None
        return document

    @classmethod
    def collect(cls, path: Path) -> Document:
        """The root of a store without consolidated metadata: a new one, or one of an earlier version."""
        files = sorted([*path.glob(f"*/{METADATA}"), *path.glob(f"*/*/{METADATA}")])
        nodes = {file.parent.relative_to(path).as_posix(): _parsed(file) for file in files}
        for node in nodes.values():
            node.pop("consolidated_metadata", None)
        return cls(path, _parsed(path / METADATA).get("attributes", {}), nodes)

    @property
    def frames(self) -> int:
        """The number of complete frames."""
        return int(self.attributes[FRAMES])

    @property
    def checked(self) -> bool:
        """Whether the store has checksums; those of earlier versions have none."""
        return CHECKSUM in self.attributes

    @property
    def groups(self) -> list[str]:
        """The names of the groups, one for each ensemble."""
        return [name for name, node in self.nodes.items() if node.get("node_type") == "group"]

    def arrays(self, group: str) -> Iterator[tuple[str, Chunks]]:
        """The arrays of a group by name; raises RunFolderError for metadata that are not those of an array."""
        for name, node in self.nodes.items():
            if name.startswith(f"{group}/"):
                try:
                    yield name.removeprefix(f"{group}/"), Chunks.of(node, self.path / name)
                except (LookupError, TypeError, ValueError, AttributeError) as fault:
                    raise RunFolderError(
                        f"{self.path / name / METADATA} is damaged ({fault!r}): run the scene again."
                    ) from None

    def commit(self, frames: int) -> None:
        """Show the first ``frames`` frames to readers, and the present attributes."""
        self.attributes[FRAMES] = frames
        for node in self.nodes.values():
            if moves(node):
                node["shape"][0] = frames
        for group in self.groups:
            members = {n.removeprefix(f"{group}/"): node for n, node in self.nodes.items() if n.startswith(f"{group}/")}
            self._replace(self.path / group, _with_metadata(self.nodes[group]["attributes"], members))
        document = _with_metadata(self.attributes, self.nodes)
        self.attributes[CHECKSUM] = document["attributes"][CHECKSUM] = _checksum(document)
        self._replace(self.path, document)
        self._written = (self.path / METADATA).stat()

    def close(self) -> None:
        """Write the metadata of the arrays themselves, for readers that do not use consolidated metadata."""
        for name, node in self.nodes.items():
            if moves(node):
                self._replace(self.path / name, node)

    def is_in_place(self) -> bool:
        """Whether the root is the file that was written last, not removed nor replaced by another."""
        try:
            now = (self.path / METADATA).stat()
        except OSError:
            return False
        before = self._written
        return before is None or (os.path.samestat(now, before) and now.st_mtime_ns == before.st_mtime_ns)

    def _replace(self, folder: Path, document: Mapping[str, Any]) -> None:
        replace_file(folder / METADATA, json.dumps(document).encode(), partial_of(self.path))


def partial_of(store: Path) -> Path:
    """The temporary name of files of a store: outside it, so that no reader of the store meets it."""
    return store.with_name(f".{store.name}.partial")


def moves(node: Mapping[str, Any]) -> bool:
    """Whether a node is an array with the dimension ``frame``."""
    return list(node.get("dimension_names") or ())[:1] == ["frame"]


def _with_metadata(attributes: Mapping[str, Any], nodes: Mapping[str, Any]) -> dict[str, Any]:
    """The ``zarr.json`` of a group with consolidated metadata, in the form in which zarr-python writes it."""
    consolidated = {"kind": "inline", "must_understand": False, "metadata": nodes}
    return {
        "attributes": dict(attributes),
        "zarr_format": 3,
        "consolidated_metadata": consolidated,
        "node_type": "group",
    }


def _checksum(document: Mapping[str, Any]) -> str:
    """SHA-256 of the content without the checksum, independent of order and spaces."""
    attributes = {key: value for key, value in document["attributes"].items() if key != CHECKSUM}
    return hashlib.sha256(json.dumps({**document, "attributes": attributes}, sort_keys=True).encode()).hexdigest()


def _parsed(file: Path) -> dict[str, Any]:
    """The JSON object in a file; raises RunFolderError."""
    folder = file.parent.parent
    try:
        document = json.loads(file.read_bytes())
    except FileNotFoundError:
        if (folder / STUDY).exists():
            raise RunFolderError(no_run(folder)) from None
        raise RunFolderError(
            f"There is no run in {folder}{beside(folder, file.parent.name)}: {file.parent.name}/{file.name} is "
            "missing. Give the folder that `warp-rods run SCENE --out DIR` wrote."
        ) from None
    except (OSError, ValueError, RecursionError) as fault:
        raise RunFolderError(f"{file} cannot be read ({fault}): run the scene again.") from None
    if not isinstance(document, dict):
        raise RunFolderError(f"{file} cannot be read: it is not the metadata of a store; run the scene again.")
    return document

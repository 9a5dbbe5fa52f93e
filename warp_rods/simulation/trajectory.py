"""The trajectory of a run: a Zarr store with one group for each ensemble, written frame by frame, or several at once.

The files of frames are written first; then the metadata of the store, one file, which shows the frames to readers.
However a run ends, and at any moment of it, the store is read up to its last complete frame, by ``open_run`` and by
``xarray.open_datatree(path, engine="zarr")``.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from warp_rods.errors import RunFolderError
from warp_rods.rods.variables import FILAMENT_VARIABLES, SWIMMER_VARIABLES, Variable
from warp_rods.simulation.chunks import column
from warp_rods.simulation.document import EARLIER_FRAMES, Document, moves, partial_of
from warp_rods.simulation.leftovers import new_store
from warp_rods.simulation.store import STORE, GroupSpec, create_group
from warp_rods.simulation.zarr_format import write_group

__all__ = [
    "FILAMENT_VARIABLES",
    "STORE",
    "SWIMMER_VARIABLES",
    "GroupSpec",
    "TrajectoryWriter",
    "Variable",
]


class TrajectoryWriter:
    """Appends frames to a store: ``create`` or ``resume`` it, ``append`` frames, ``close`` it.

    ``hold`` keeps a frame in memory, ``write`` writes those held, with the work of about one: each array has a file.
    ``frames`` is the number of complete frames in the store; ``bytes_held``: those in memory.
    """

    def __init__(self, document: Document, frames: int) -> None:
        """Continue a store after its first ``frames`` frames; writes nothing before the files were looked at."""
        self.frames, self.bytes_held = frames, 0
        self._held: list[dict[tuple[str, str], np.ndarray]] = []
        self._document = document
        partial = partial_of(document.path)
        self._groups = {
            group: {
                name: column(chunks, frames, partial)
                for name, chunks in document.arrays(group)
                if moves(document.nodes[f"{group}/{name}"])
            }
            for group in document.groups
        }
        document.commit(frames)

    @classmethod
    def create(
        cls,
        path: str | Path,
        groups: Mapping[str, GroupSpec],
        attributes: Mapping[str, Any],
        before_it_appears: Callable[[], object] = lambda: None,
    ) -> TrajectoryWriter:
        """Create a store at ``path``; its root gets ``attributes`` (title, scene, seed, units, …).

        The store appears as a whole, after a call of ``before_it_appears``. Raises RunFolderError if ``path`` exists.
        """
        path = Path(path)
        if path.exists():
            raise RunFolderError(f"{path} exists already: remove it, or choose another folder.")
        new = new_store(path)
        shutil.rmtree(new, ignore_errors=True)
        write_group(new, {"warp_rods_version": version("warp-rods"), **attributes})
        for name, spec in groups.items():
            create_group(new / name, spec)
        document = Document.collect(new)
        document.commit(0)
        before_it_appears()
        new.rename(path)
        document.path = path
        return cls(document, 0)

    @classmethod
    def resume(
        cls, path: str | Path, frames: int | None = None, attributes: Mapping[str, Any] | None = None
    ) -> TrajectoryWriter:
        """Continue a store after its complete frames, or after the first ``frames`` of them; later frames are removed.

        ``attributes`` of the root are updated: the scene may end later than before.

        Raises RunFolderError, and writes nothing, if there is no store, it is damaged where it is to be continued, or
        it has fewer than ``frames`` complete frames.
        """
        document = Document.read(Path(path))
        keep = document.frames if frames is None else frames
        if not 0 <= keep <= document.frames:
            raise RunFolderError(f"{path} has {document.frames} complete frames, {keep} are needed to resume the run.")
        document.attributes.update(attributes or {})
        writer = cls(document, keep)
        shutil.rmtree(document.path / EARLIER_FRAMES, ignore_errors=True)  # the root has the number now
        return writer

    def append(self, time: float, frames: Mapping[str, Mapping[str, np.ndarray]]) -> None:
        """Save one frame: ``frames[group][variable]``, every variable of every group, without the frame axis.

        Raises ValueError, and writes nothing, if a group, variable or shape is not the one declared; RunFolderError if
        the store was removed or replaced since the last frame.
        """
        self.hold(time, frames, copy=False)
        self.write()

    def hold(self, time: float, frames: Mapping[str, Mapping[str, np.ndarray]], copy: bool = True) -> None:
        """Keep a frame, as ``append`` takes it, until frames are written; raises what it does.

        copy: whether its arrays may change before.
        """
        self._check(frames)
        self._check_in_place()
        held = {
            (name, variable): columns[variable].chunks.in_its_type(values, copy)
            for name, columns in self._groups.items()
            for variable, values in {**frames[name], "time": time}.items()
        }
        self._held.append(held)
        self.bytes_held += sum(values.nbytes for values in held.values())

    def write(self) -> None:
        """Write the frames that are held, and show all of them; raises RunFolderError as ``append`` does, OSError."""
        if not self._held:
            return
        self._check_in_place()
        try:
            for name, columns in self._groups.items():
                for variable, column in columns.items():
                    column.put(self.frames, [held[name, variable] for held in self._held])
            self._document.commit(self.frames + len(self._held))
        except FileNotFoundError as fault:
            raise self._give_up(f"{fault.filename or fault} is missing") from None
        self.frames += len(self._held)
        self._held, self.bytes_held = [], 0

    def describe(self, **attributes: Any) -> None:
        """Set attributes of the root of the store; raises RunFolderError if it was removed or replaced."""
        self._check_in_place()
        self._document.attributes.update(attributes)
        self._document.commit(self.frames)

    @property
    def messages(self) -> list[str]:
        """The messages of the run so far, from the store."""
        return list(self._document.attributes.get("messages", []))

    def close(self) -> None:
        """Write frames that are held, and the metadata of each array, too; a store that was removed is left alone."""
        if self._groups and self._document.is_in_place():
            self.write()
            self._document.close()
        self._groups = {}

    def _check_in_place(self) -> None:
        if not self._document.is_in_place():
            raise self._give_up("it was removed, or another was put in its place")

    def _give_up(self, what: str) -> RunFolderError:
        """The error for a store that is lost; nothing is written any more, by ``close`` either."""
        self._groups, self._held = {}, []
        return RunFolderError(
            f"{self._document.path}: {what}, while the run was writing to it. The run stops after {self.frames} "
            f"complete frames, and nothing more is written: run the scene again, into a folder that is left alone."
        )

    def _check(self, frames: Mapping[str, Mapping[str, np.ndarray]]) -> None:
        _same_names("groups", frames, self._groups)
        for name, columns in self._groups.items():
            _same_names(f"variables of {name}", {"time": None, **frames[name]}, columns)
            for variable, values in frames[name].items():
                declared = columns[variable].chunks.shape
                if np.shape(values) != declared:
                    raise ValueError(f"{name}/{variable}: shape {np.shape(values)}, declared {declared}")


def _same_names(what: str, given: Mapping[str, Any], declared: Mapping[str, Any]) -> None:
    if given.keys() != declared.keys():
        raise ValueError(f"{what}: given {sorted(given)}, declared {sorted(declared)}")

"""Read the trajectory of a run: lazily, complete frames only, and no damage without a message."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr
from xarray.backends import BackendArray
from xarray.core import indexing  # see "How to add a new backend" of xarray; hence the upper bound in pyproject

from warp_rods import arguments
from warp_rods.errors import RunFolderError
from warp_rods.scene.scene import text_with_whole_paths
from warp_rods.simulation.chunks import Chunks
from warp_rods.simulation.document import CHECKSUM, FRAMES, Document
from warp_rods.simulation.earlier import labelled
from warp_rods.simulation.store import STORE

__all__ = ["open_run"]


def open_run(run_dir: str | Path) -> xr.DataTree:
    """The trajectory of a run, complete frames only, read lazily: one group for each ensemble.

    The run may still be in progress, or have been killed. Raises RunFolderError if there is no run, or its metadata are
    damaged; and where values are read later, for a frame that is missing or damaged, naming it and its variable.
    """
    run_dir = arguments.path("run_dir", run_dir)
    path = run_dir / STORE
    document = Document.read(path)
    attributes = {key: value for key, value in document.attributes.items() if key not in (FRAMES, CHECKSUM)}
    if "scene" in attributes:
        # Of the files that the run folder keeps, wherever the folder is now.
        attributes["scene"] = text_with_whole_paths(attributes["scene"], run_dir.resolve())
    # Each group keeps the scene, which describes its membrane and its box, and the units of its numbers.
    scene = {key: text for key, text in attributes.items() if key in ("scene", "units")}
    try:
        root = zarr.open_group(path, mode="r", use_consolidated=document.checked)
        tree = {name: _dataset(root, document, name).assign_attrs(scene) for name in sorted(document.groups)}
    except RunFolderError:
        raise
    except Exception as fault:  # of a store of an earlier version, which has no checksums
        raise RunFolderError(f"{path} cannot be read ({fault}): run the scene again.") from None
    return xr.DataTree.from_dict({"/": xr.Dataset(attrs=attributes), **tree})


class _Lazy(BackendArray):
    """A Zarr array up to its last complete frame, read lazily by xarray."""

    def __init__(self, array: zarr.Array, shape: tuple[int, ...], chunks: Chunks, moving: bool) -> None:
        self.array, self.shape, self.dtype = array, shape, array.dtype
        self.chunks, self._moving = chunks, moving

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> Any:
        """The values; raises RunFolderError naming the first frame that is missing or damaged."""
        first = slice(*key[0].indices(self.shape[0])) if isinstance(key[0], slice) else key[0]
        frames = np.atleast_1d(np.arange(self.shape[0])[first]) if self._moving else [0]
        missing = self.chunks.first_missing(map(int, frames))
        if missing is not None:
            raise self._damage(missing, "it is missing")
        try:
            return self.array.oindex[(first, *key[1:])]
        except Exception as fault:  # each codec of Zarr raises its own
            raise self._damage(self._first_unreadable(frames), str(fault).split(". ")[0]) from None

    def _first_unreadable(self, frames: Any) -> int:
        for frame in map(int, frames) if self._moving else ():
            try:
                self.array.oindex[(slice(frame, frame + 1),)]
            except Exception:
                return frame
        return 0

    def _damage(self, frame: int, what: str) -> RunFolderError:
        name, file = f"{self.chunks.folder.parent.name}/{self.chunks.folder.name}", self.chunks.file(frame)
        where = f"frame {frame} of {name}" if self._moving else name
        return RunFolderError(f"{where} is damaged: {what} ({file}). Other frames and variables can be read.")


def _dataset(root: zarr.Group, document: Document, name: str) -> xr.Dataset:
    """The variables of an ensemble, read lazily; labels of dimensions are read at once, as in xarray."""
    variables = {}
    for label, chunks in sorted(document.arrays(name)):
        array = root[f"{name}/{label}"]
        assert isinstance(array, zarr.Array)
        dims = dims_of(array)
        moving = dims[:1] == ("frame",)
        # Arrays of earlier versions are longer than the number of complete frames while the run is in progress.
        shape = (min(document.frames, array.shape[0]), *array.shape[1:]) if moving else array.shape
        lazy = indexing.LazilyIndexedArray(_Lazy(array, shape, chunks, moving))
        variables[label] = xr.Variable(dims, lazy, dict(array.attrs))
        if dims == (label,):
            variables[label] = xr.Variable(dims, np.asarray(variables[label].values).tolist())
    dataset = xr.Dataset(variables).set_coords(["time", "s"])
    return dataset if set(dataset.dims) & set(dataset.indexes) else labelled(dataset)


def dims_of(array: zarr.Array) -> tuple[str, ...]:
    """The names of the dimensions of an array."""
    names = getattr(array.metadata, "dimension_names", None)  # arrays of Zarr's format 2 have none
    return tuple(name or "" for name in names or ())

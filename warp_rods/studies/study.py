"""A study in a folder: what became of its points, and its results."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from warp_rods.documented import Documented
from warp_rods.studies.store import STORE

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Study"]


class Study(metaclass=Documented):
    """A study in a folder.

    folder: where it is. points: how many there are by what became of them. left: how many are still to be computed.
    messages: what was said.
    """

    def __init__(self, folder: Path, points: dict[str, int], left: int, messages: list[str]):
        self.folder, self.points, self.left, self.messages = folder, points, left, messages

    def __repr__(self) -> str:
        counts = ", ".join(f"{count} {word}" for word, count in self.points.items())
        return f"<Study in {self.folder}: {counts or 'no points'}{f', {self.left} left' if self.left else ''}>"

    @property
    def summary(self) -> str:
        """What became of the points, in a line."""
        counts = ", ".join(f"{count} {word}" for word, count in self.points.items())
        left = f"; {self.left} left: run the same command again when the other parts are done" if self.left else ""
        return f"{counts or 'no point is computed'}{left}; results in {self.folder / STORE}"

    @property
    def data(self) -> xr.Dataset:
        """The results, read lazily: dimensions are the swept keys and ``seed``."""
        import xarray

        return xarray.open_zarr(self.folder / STORE, chunks=None)

"""A membrane or a container as it is drawn: its mesh with curvatures, at each chosen frame where it moves."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from warp_rods.membranes.mesh import Curvatures, Mesh, curvatures, follow, triangulate
from warp_rods.membranes.surfaces import make
from warp_rods.scene.tables import SurfaceTable

__all__ = ["Sheet"]

_CELLS, _CELLS_MOVING = 96, 48
"""Cells of the mesh along the longest edge of its box; fewer for a moving one, which has a mesh at every frame."""
_KEPT = 128
"""Meshes of a moving surface that are kept in memory, about 0.3 MB each."""


class Sheet:
    """A surface at the chosen frames; a frame is given by its number among these, from 0.

    moving; lost: how many points of the mesh could not follow a moving surface so far. ``times`` [frame of the
    trajectory] are all saved ones, as the mesh follows a moving surface from each to the next.
    """

    def __init__(self, table: SurfaceTable, times: np.ndarray, frames: range) -> None:
        self.surface = make(table.kind, table.parameters)
        self.moving, self.lost = self.surface.moving, 0
        self._times, self._frames = times, frames
        self._at = -1  # the frame of the trajectory at which the mesh is
        self._mesh: Mesh | None = None
        self._kept: dict[int, Mesh] = {}
        self._curvatures: tuple[int, Curvatures] | None = None

    def mesh(self, frame: int) -> Mesh:
        """The mesh; its triangles are those of every frame."""
        wanted = self._frames[frame] if self.moving else 0
        if wanted in self._kept:
            return self._kept[wanted]
        if self._mesh is None or wanted < self._at:
            self._mesh, self._at = triangulate(self.surface, _CELLS_MOVING if self.moving else _CELLS), -1
        while self.moving and self._at < wanted:
            self._at += 1
            self._mesh, lost = follow(self._mesh, self.surface.at(float(self._times[self._at])))
            self.lost = max(self.lost, lost)
        if len(self._kept) < _KEPT:
            self._kept[wanted] = self._mesh
        return self._mesh

    @cached_property
    def size(self) -> float:
        """Longest side of the box of the mesh at the first chosen frame."""
        return float(np.ptp(self.mesh(0).points, axis=0).max())

    def curvatures(self, frame: int) -> Curvatures:
        """The curvatures at the points of the mesh."""
        kept = self._frames[frame] if self.moving else 0
        if self._curvatures is None or self._curvatures[0] != kept:
            now = self.surface.at(float(self._times[kept])) if self.moving else self.surface
            self._curvatures = kept, curvatures(now, self.mesh(frame).points)
        return self._curvatures[1]

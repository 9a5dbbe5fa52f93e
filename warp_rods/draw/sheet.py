"""A membrane or a container as it is drawn: its mesh with curvatures, at each chosen frame where it moves."""

from __future__ import annotations

import logging
from functools import cached_property

import numpy as np

from warp_rods.membranes.mesh import Curvatures, Mesh, curvatures, follow, triangulate
from warp_rods.membranes.surfaces import make
from warp_rods.scene.tables import SurfaceTable

__all__ = ["CURVED", "PALE", "Sheet", "curvature_colours"]

_CELLS, _CELLS_MOVING = 96, 48
"""Cells of the mesh along the longest edge of its box; fewer for a moving one, which has a mesh at every frame."""
_KEPT = 128
"""Meshes of a moving surface that are kept in memory, about 0.3 MB each."""
PALE = 0.55
"""How much of white is in the colours of a membrane, so that the rods stand out."""
CURVED = "coolwarm"
"""Map of the Gaussian curvature of a membrane: blue for saddles, red for caps."""


class Sheet:
    """A surface at the chosen frames; a frame is given by its number among these, from 0.

    ``times`` [frame of the trajectory] are all saved ones, as the mesh follows a moving surface from each to the next.
    A warning says once where points of the mesh cannot follow; they stay at their last places.
    """

    def __init__(self, table: SurfaceTable, times: np.ndarray, frames: range) -> None:
        self.surface = make(table.kind, table.parameters)
        self.moving, self._warned = self.surface.moving, False
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
            self._warn_of(lost)
        if len(self._kept) < _KEPT:
            self._kept[wanted] = self._mesh
        return self._mesh

    def _warn_of(self, lost: int) -> None:
        if lost and not self._warned:
            self._warned = True
            logging.getLogger(__name__).warning(
                f"t = {self._times[self._at]:g}: {lost} points of the mesh of the membrane cannot follow it, and are "
                "drawn at their last places from then on: it may move too far between two frames (time.save_every)"
            )

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

    @cached_property
    def curvature(self) -> float:
        """The Gaussian curvature at both ends of the colours of the surface, 1/length²; 0 where it hardly varies.

        That of the first, the middle and the last frame, so that a moving surface has one scale.
        """
        count = len(self._frames)
        frames = sorted({0, count // 2, count - 1}) if self.moving else [0]
        every = np.concatenate([self.curvatures(frame).gaussian for frame in frames])
        low, high = np.quantile(every[np.isfinite(every)], (0.02, 0.98))
        largest = max(abs(low), abs(high))
        return float(largest) if high - low > 0.02 * largest else 0.0

    def ratio(self, frame: int) -> np.ndarray:
        """Where the points of the mesh are on the scale of the curvature, from −1 to 1; 0 where it is not known."""
        return np.clip(np.nan_to_num(self.curvatures(frame).gaussian / self.curvature), -1.0, 1.0)


def curvature_colours(ratio: np.ndarray) -> np.ndarray:
    """sRGB [..., 3] of Gaussian curvature over its largest value [...]."""
    from matplotlib import colormaps

    mapped = colormaps[CURVED]((ratio + 1) / 2)[..., :3]
    return PALE + (1 - PALE) * mapped

"""A picture of a run at one frame: lit tubes, translucent membrane, edges of the box, on white.

Pictures are made by kernels of our own (``kernels/picture.py``), on the CPU: they need neither a display nor OpenGL,
and equal runs give equal bytes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from warp_rods.device import exclusive, start
from warp_rods.draw.content import Content
from warp_rods.draw.rods import Rods
from warp_rods.draw.sheet import curvature_colours
from warp_rods.draw.view import View
from warp_rods.kernels import picture as kernels
from warp_rods.membranes.mesh import Mesh

__all__ = ["Painter"]

FINER = 2
"""Pixels of the drawing for one of the picture, along each side: their mean has smooth edges."""
THINNEST = 0.8
"""Smallest radius of a tube, pixels of the drawing."""
_LEAST = 1 / 150
"""Radius over half the width of the picture, at least, of rods on a membrane that have no steric core."""
_OPACITY, _CONTAINER_OPACITY = 0.5, 0.13
_NEUTRAL = (0.78, 0.80, 0.84)
_EDGE = (0.62, 0.64, 0.68)
_LINE = 0.6 * FINER
"""Half the thickness of edges and trails, pixels of the drawing."""
_TRAIL_RODS, _TRAIL_FRAMES = 20, 200
"""Rods that travel far leave trails, where they are few; from so many frames at most."""


class Painter:
    """Paints frames of what is shown, in pictures of one size: ``Painter(shown, view, width, height)``.

    scale: the number of pixels in a unit of length: the view fills the picture as far as its shape allows. curvature:
    that at both ends of the colours of the membrane, 0 where it has none.
    """

    def __init__(self, shown: Content, view: View, width: int, height: int) -> None:
        start()
        self.shown, self.view, self.size = shown, view, (height, width)
        self.scale = float(min(width / (2 * view.half[0]), height / (2 * view.half[1])))
        self._least = _LEAST * view.half.max() if shown.membrane and not shown.scene.steric else 0.0
        self._sheet = shown.membrane or shown.container
        self._opacity = _OPACITY if shown.membrane else _CONTAINER_OPACITY
        self.curvature = shown.membrane.curvature if shown.membrane else 0.0
        with exclusive:
            self._rods, self._front, self._back = (self._layer() for _ in range(3))
            self._out: Any = wp.empty((FINER * height, FINER * width), dtype=wp.vec3, device="cpu")
        self._paths: np.ndarray | None = None  # of the middles at sampled frames, for the trails
        self._drawn: tuple[Mesh, np.ndarray] | None = None  # the mesh that is in the layers of the membrane

    def paint(self, frame: int) -> np.ndarray:
        """The picture [height, width, 3] of a frame, sRGB from 0 to 255."""
        view = self.view.at(self.shown, frame)
        tubes = self._tubes(view, frame)
        with exclusive:
            self._clear(self._rods)
            wp.launch(kernels.draw_capsules, len(tubes.radius), [tubes, self._rods], device="cpu")
            self._paint_sheet(view, frame)
            least = FINER * self.scale * min(self._radius(rods) for rods in self.shown.rods)
            inputs = [self._rods, self._front, self._back, self._opacity, FINER, max(least, 2.0)]
            wp.launch(kernels.compose, self._out.shape, [*inputs, self._out], device="cpu")
            fine = self._out.numpy()
        height, width = self.size
        mean = fine.reshape(height, FINER, width, FINER, 3).mean(axis=(1, 3))
        return np.rint(255 * np.clip(mean, 0.0, 1.0)).astype(np.uint8)

    def _radius(self, rods: Rods) -> float:
        """The radius with which rods are drawn in this view."""
        return max(rods.radius, self._least)

    def to_pixels(self, points: np.ndarray, view: View) -> np.ndarray:
        """Points [..., 3] in pixels of the drawing: right, down, towards the viewer."""
        height, width = self.size
        scaled = FINER * self.scale * ((points - view.centre) @ view.axes.T) * (1.0, -1.0, 1.0)
        middle = np.array([FINER * width / 2, FINER * height / 2, 0.0])
        return (scaled + middle).astype(np.float32)

    def _tubes(self, view: View, frame: int) -> Any:
        """The rods of all ensembles, the edges of the box and trails, as capsules."""
        scale = self.shown.scale(frame)
        parts: list[tuple[np.ndarray, ...]] = []
        for rods in self.shown.rods:
            points, colours = self.to_pixels(rods.positions(frame), view), scale.rgb(rods.values(frame))
            radius = np.full(rods.count * (rods.nodes - 1), max(FINER * self.scale * self._radius(rods), THINNEST))
            ends = (points[:, :-1], points[:, 1:], colours[:, :-1], colours[:, 1:])
            parts.append((*(end.reshape(-1, 3) for end in ends), radius))
        lines = self.to_pixels(np.concatenate([self.shown.edges, self._trail(frame)]), view)
        grey = np.broadcast_to(_EDGE, (len(lines), 3))
        parts.append((lines[:, 0], lines[:, 1], grey, grey, np.full(len(lines), _LINE)))
        capsules: Any = kernels.Capsules()
        names = ("start", "end", "start_colour", "end_colour", "radius")
        for name, column in zip(names, zip(*parts, strict=True), strict=True):
            kind = wp.float32 if name == "radius" else wp.vec3
            setattr(capsules, name, wp.array(np.concatenate(column).astype(np.float32), dtype=kind, device="cpu"))
        return capsules

    def _trail(self, frame: int) -> np.ndarray:
        """Ends [n, 2, 3] of the pieces of the paths of the middles until a frame, where the view follows the rods."""
        if not self.view.follows or sum(rods.count for rods in self.shown.rods) > _TRAIL_RODS:
            return np.empty((0, 2, 3))
        sampled = self.shown.sample(_TRAIL_FRAMES)
        if self._paths is None:
            middles = [[rods.positions(f)[:, rods.nodes // 2] for rods in self.shown.rods] for f in sampled]
            self._paths = np.array([np.concatenate(each) for each in middles])
        now = np.concatenate([rods.positions(frame)[:, rods.nodes // 2] for rods in self.shown.rods])
        path = np.concatenate([self._paths[np.array(sampled) < frame], now[None]])
        return np.stack([path[:-1], path[1:]], axis=2).reshape(-1, 2, 3)

    def _paint_sheet(self, view: View, frame: int) -> None:
        """Membrane or container into its layers, unless it is there already."""
        if self._sheet is None:
            return
        mesh = self._sheet.mesh(frame)
        if self._drawn and self._drawn[0] is mesh and np.array_equal(self._drawn[1], view.centre):
            return
        sheet: Any = kernels.Sheet()
        colours = np.broadcast_to(_NEUTRAL, mesh.points.shape)
        if self.curvature:
            colours = curvature_colours(self._sheet.ratio(frame))
        normals = mesh.normals @ view.axes.T * (1.0, -1.0, 1.0)
        for name, values in (("points", self.to_pixels(mesh.points, view)), ("normals", normals), ("colours", colours)):
            setattr(sheet, name, wp.array(np.asarray(values, np.float32), dtype=wp.vec3, device="cpu"))
        sheet.triangles = wp.array(mesh.triangles.astype(np.int32), dtype=wp.int32, device="cpu")
        self._clear(self._front)
        self._clear(self._back)
        wp.launch(kernels.draw_sheet, len(mesh.triangles), [sheet, self._front, self._back], device="cpu")
        self._drawn = mesh, view.centre

    def _layer(self) -> Any:
        layer: Any = kernels.Layer()
        shape = tuple(FINER * side for side in self.size)
        layer.depth = wp.full(shape, kernels.FAR, dtype=wp.float32, device="cpu")
        layer.normal = wp.zeros(shape, dtype=wp.vec3, device="cpu")
        layer.colour = wp.zeros(shape, dtype=wp.vec3, device="cpu")
        return layer

    def _clear(self, layer: Any) -> None:
        layer.depth.fill_(kernels.FAR)

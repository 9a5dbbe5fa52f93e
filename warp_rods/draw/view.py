"""From where a run is looked at, and what is in the picture: the same in pictures, films and USD.

Planar motion is seen along its normal, a film of swimmers from above, everything else at an angle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from warp_rods.draw.content import Content

__all__ = ["View", "fixed_corners", "looking_along", "view_of"]

AT_AN_ANGLE = (1.0, -1.7, 0.7)
"""From the centre towards the viewer, where nothing else is better."""
_FLAT = 0.02
"""Thickness over size below which motion is planar."""
_MARGIN, _ROOM = 1.06, 0.6
"""The picture over what it holds; room round the rods on an open membrane, in sizes of what they fill."""
_FOLLOWING = 1.5
"""The picture over the rods, where it follows them, so that trails are seen."""
_FEW = 4000
"""Largest number of points of a frame that decide about the view."""


@dataclass(frozen=True)
class View:
    """A parallel view: axes [3, 3], rows to the right, up and towards the viewer; centre [3]; half width and height.

    follows: the centre moves with the rods, as they travel far; ``at`` gives the view of a frame.
    """

    axes: np.ndarray
    centre: np.ndarray
    half: np.ndarray
    follows: bool = False

    def at(self, shown: Content, frame: int) -> View:
        """The view of a frame."""
        if not self.follows:
            return self
        points = _points(shown, frame)
        return replace(self, centre=(points.min(axis=0) + points.max(axis=0)) / 2)


def view_of(shown: Content, frames: range | list[int] | None = None) -> View:
    """The view of what is shown at these frames (default: at a sample of all)."""
    frames = shown.sample() if frames is None else frames
    every = [_points(shown, frame) for frame in frames]
    radius = max(rods.radius for rods in shown.rods)
    axes = looking_along(_towards_viewer(shown, every, radius))
    whole = np.concatenate(every)
    fixed = fixed_corners(shown, whole.min(axis=0), whole.max(axis=0), frames)
    corners = np.concatenate([*every, fixed]) @ axes.T
    low, high = corners.min(axis=0), corners.max(axis=0)
    half = (high - low) / 2
    follows = False
    if not len(fixed):
        own = np.max([np.ptp(points @ axes.T, axis=0) for points in every], axis=0) / 2
        follows = bool(half[:2].max() > 2.5 * own[:2].max())
        half = _FOLLOWING * own if follows else half
    half = _MARGIN * (half[:2] + radius)
    half = np.maximum(half, 0.3 * half.max())  # a straight rod needs room, too
    return View(axes, (low + high) / 2 @ axes, half, follows)


def _points(shown: Content, frame: int) -> np.ndarray:
    """Some of the nodes at a frame [n, 3]."""
    points = np.concatenate([rods.positions(frame).reshape(-1, 3) for rods in shown.rods])
    return points[:: -(-len(points) // _FEW)]


def _towards_viewer(shown: Content, every: list[np.ndarray], radius: float) -> np.ndarray:
    """The direction from the centre to the viewer."""
    if shown.scene.box and shown.scene.box.kind == "slab":
        return np.array([0.0, 0.0, 1.0])
    if shown.membrane is None and shown.container is None and shown.box is None:
        normal = _normal(every, radius)
        if normal is not None:
            return normal
    x, y, _ = np.ptp(np.concatenate(every), axis=0)
    right, back, up = AT_AN_ANGLE
    return np.array([-back, -right, up]) if y > 1.3 * x else np.array(AT_AN_ANGLE)  # the longer side across


def _normal(every: list[np.ndarray], radius: float) -> np.ndarray | None:
    """The normal of the plane in which all points move, each frame about its centre; None where there is none."""
    points = np.concatenate(every)
    points = points - points.mean(axis=0)
    directions = np.linalg.svd(points[:: -(-len(points) // _FEW)], full_matrices=False)[2]
    spread = np.ptp(points @ directions.T, axis=0)
    if spread[2] > max(_FLAT * spread[0], 2 * radius):
        return None
    if spread[1] > max(_FLAT * spread[0], 2 * radius):
        normal = directions[2]
    else:  # a line: from above as far as possible
        line = directions[0]
        normal = np.array([0.0, 0.0, 1.0]) - line[2] * line
        normal = normal if np.linalg.norm(normal) > 0.1 else np.array([0.0, -1.0, 0.0])
    towards = normal @ np.array([0.01, -0.1, 1.0])
    return normal if towards >= 0 else -normal


def looking_along(backward: np.ndarray) -> np.ndarray:
    """Rows: right, up and ``backward``, towards the viewer; up is z as far as possible, y for a view from above."""
    back = np.asarray(backward, dtype=float) / np.linalg.norm(backward)
    upward = np.array([0.0, 1.0, 0.0]) if abs(back[2]) > 0.9 else np.array([0.0, 0.0, 1.0])
    right = np.cross(upward, back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def fixed_corners(shown: Content, low: np.ndarray, high: np.ndarray, frames: range | list[int]) -> np.ndarray:
    """Points [n, 3] of membrane, container and box that belong into the picture; none where there is none.

    An open membrane goes on beyond the picture: of it only what is near the rods, which are between low and high [3].
    """
    found = [np.empty((0, 3))]
    for sheet in (shown.membrane, shown.container):
        if sheet is None:
            continue
        points = np.concatenate([sheet.mesh(frame).points for frame in (frames if sheet.moving else [0])])
        if not sheet.surface.closed:
            room = _ROOM * (high - low).max()
            points = points[np.all((points > low - room) & (points < high + room), axis=1)]
        found.append(points)
    return np.concatenate([*found, shown.edges.reshape(-1, 3)])

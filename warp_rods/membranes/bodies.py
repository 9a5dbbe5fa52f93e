"""The bodies of a membrane: its closed pieces, each oriented by what is around it; which of them a point is on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from warp_rods.membranes.files import shown_point
from warp_rods.membranes.triangles import Triangles

__all__ = ["Bodies", "Body", "oriented"]

MOST_LISTED = 8


class Body(NamedTuple):
    """One closed piece of a membrane."""

    volume: float
    """The volume enclosed by it."""
    centre: np.ndarray
    """The middle of its box [3]."""
    depth: int
    """The number of bodies around it; where odd, it is a cavity and the space inside it is outside."""


class Bodies(NamedTuple):
    """The bodies of a membrane, largest first, and the body of each of its points."""

    bodies: list[Body]
    triangles: Triangles
    """The membrane as triangles."""
    of_points: np.ndarray
    """The number of the body of each point of the triangles [v]."""

    def __len__(self) -> int:
        return len(self.bodies)

    def box(self, numbers: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner [3] around these bodies."""
        return _box(self.triangles.points[np.isin(self.of_points, numbers)])

    def nearest(self, x: np.ndarray) -> np.ndarray:
        """The number of the body nearest to each point [n, 3]."""
        from scipy.spatial import cKDTree

        return self.of_points[cKDTree(self.triangles.points).query(x)[1]]

    def moved(self, by: np.ndarray) -> Bodies:
        """The bodies displaced by a vector [3]."""
        bodies = [body._replace(centre=body.centre + by) for body in self.bodies]
        return Bodies(bodies, Triangles(self.triangles.points + by, self.triangles.faces), self.of_points)

    def with_volume(self, volume: float, farthest: float) -> Bodies:
        """The bodies moved along their normals, by ``farthest`` at most, such that they have this volume in all."""
        triangles = self.triangles
        for _ in range(2):
            by = (volume - float(triangles.volumes().sum())) / float(triangles.areas().sum())
            points = triangles.points + np.clip(by, -farthest, farthest) * triangles.normals_at_points()
            triangles = Triangles(points, triangles.faces)
        return Bodies(self.bodies, triangles, self.of_points)

    def listed(self) -> str:
        """One line that numbers the bodies."""
        words = []
        for number, body in enumerate(self.bodies[:MOST_LISTED]):
            kind = "cavity" if body.depth % 2 else "body"
            rounded = np.round(body.centre / self.triangles.size, 6) * self.triangles.size
            words.append(f"{number} ({kind}, volume {body.volume:.4g}, around {shown_point(rounded)})")
        more = len(self.bodies) - MOST_LISTED
        return ", ".join(words) + (f", and {more} smaller ones" if more > 0 else "")


def oriented(points: np.ndarray, faces: np.ndarray) -> tuple[Bodies, int]:
    """The bodies of closed triangles, outer ones turned to face outwards and cavities inwards; how many were turned."""
    found = Triangles(points, faces)
    pieces = found.pieces()
    of_face = pieces[found.faces[:, 0]]
    count = int(pieces.max()) + 1
    volumes = np.bincount(of_face, weights=found.volumes(), minlength=count)
    order = np.argsort(-np.abs(volumes), kind="stable")
    order = order[np.isin(order, of_face)]  # points without triangles are no body
    boxes = [_box(found.points[pieces == piece]) for piece in order]
    depth = _depths(found, of_face, order, boxes)
    turned = faces.copy()
    number = np.zeros(count, dtype=int)
    number[order] = np.arange(len(order))
    wrong = np.zeros(count, dtype=bool)
    wrong[order] = (volumes[order] < 0) != (depth % 2 == 1)
    turned[wrong[of_face]] = turned[wrong[of_face]][:, ::-1]
    bodies = [
        Body(abs(float(volumes[piece])), (low + high) / 2, int(d))
        for piece, (low, high), d in zip(order, boxes, depth, strict=True)
    ]
    return Bodies(bodies, Triangles(points, turned), number[pieces]), int(wrong.sum())


def _box(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return x.min(axis=0), x.max(axis=0)


def _depths(found: Triangles, of_face: np.ndarray, order: np.ndarray, boxes: list) -> np.ndarray:
    """The number of pieces around each piece: those in which one of its points lies."""
    depth = np.zeros(len(order), dtype=int)
    lows, highs = (np.array(corners).reshape(-1, 3) for corners in zip(*boxes, strict=True))
    for j, piece in enumerate(order):
        within = np.flatnonzero(((lows > lows[j]) & (highs < highs[j])).all(axis=-1))
        if len(within):
            faces = found.faces[of_face == piece]
            shell = Triangles(found.points, faces if _faces_outwards(found.points, faces) else faces[:, ::-1])
            starts = [found.faces[of_face == order[i]][0, 0] for i in within]
            depth[within] += shell.distance(found.points[starts], signed=True) < 0
    return depth


def _faces_outwards(points: np.ndarray, faces: np.ndarray) -> bool:
    return Triangles(points, faces).volumes().sum() > 0

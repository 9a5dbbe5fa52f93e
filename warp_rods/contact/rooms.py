"""Rooms with walls: what pushes swimmers back, and the region in which they are placed; one row of ``WALLED`` for each.

The keys of these kinds of boxes are in ``warp_rods/scene/box.py``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from warp_rods.scene.box import Box

__all__ = ["WALLED", "Walled", "turned_to"]


@dataclass(frozen=True)
class Walled:
    """The walls of a room: a curved one, φ = 0 of a field of ``kernels/contact/box.py``, and flat faces.

    numbers: parameters of the field. distance: φ of the same in NumPy, points [..., 3] → [...], a distance.
    faces [2, 3]: corners of the box whose finite faces are walls. axis: that of a pore or duct. free(c): lengths along
    the axis (0 if it is endless) and across it, and the volume, of the region that keeps a distance c from the walls.
    """

    field: str
    numbers: tuple[float, ...]
    distance: Callable[[np.ndarray], np.ndarray]
    faces: np.ndarray
    axis: int
    free: Callable[[float], tuple[np.ndarray, float]]

    def holds(self, points: np.ndarray, clearance: float = 0.0) -> np.ndarray:
        """Whether points [..., 3] are inside, by the clearance [...]."""
        low, high = self.faces + clearance * np.array([[1.0], [-1.0]])
        within = (points >= low).all(axis=-1) & (points <= high).all(axis=-1)
        return np.asarray(within & (self.distance(points) <= -clearance))


def turned_to(axis: int) -> np.ndarray:
    """The rotation [3, 3] that exchanges axes in turn, so that x becomes this one."""
    return np.roll(np.eye(3), axis, axis=0)


def pore(box: Box) -> Walled:
    """A cylinder: φ = ρ − R with ρ the distance from the axis."""
    assert box.radius is not None
    radius, axis = box.radius, box.along
    across = [k for k in range(3) if k != axis]

    def free(clearance: float) -> tuple[np.ndarray, float]:
        sides = _sides(box, 2 * radius, 2 * radius, clearance)
        return sides, float(np.pi / 4 * sides.prod())

    def distance(points: np.ndarray) -> np.ndarray:
        return np.hypot(points[..., across[0]], points[..., across[1]]) - radius

    return Walled("pore", (radius, *turned_to(axis)[:, 0]), distance, _faces(box, np.inf, np.inf), axis, free)


def duct(box: Box) -> Walled:
    """Flat walls at half the sides, along the two axes that follow that of the duct."""
    assert box.sides is not None
    width, height = box.sides

    def free(clearance: float) -> tuple[np.ndarray, float]:
        sides = _sides(box, width, height, clearance)
        return sides, float(sides.prod())

    def distance(points: np.ndarray) -> np.ndarray:
        return np.full(points.shape[:-1], -np.inf)

    return Walled("nowhere", (), distance, _faces(box, width, height), box.along, free)


WALLED: dict[str, Callable[[Box], Walled]] = {"pore": pore, "duct": duct}
"""Walls by kind of box. Slabs and containers, which are surfaces, have theirs in ``walls.py``."""


def _sides(box: Box, width: float, height: float, clearance: float) -> np.ndarray:
    """Sides [3] of the region that keeps the clearance, the one along the axis first."""
    along = box.length or 0.0
    if box.ends == "closed":
        along = max(along - 2 * clearance, 0.0)
    return np.array([along, max(width - 2 * clearance, 0.0), max(height - 2 * clearance, 0.0)])


def _faces(box: Box, width: float, height: float) -> np.ndarray:
    """Corners [2, 3] of the box of flat walls."""
    along = box.length if box.ends == "closed" and box.length else np.inf
    half = np.roll([along, width, height], box.along) / 2
    return np.stack([-half, half])

"""How many rods could fit, however they are placed: upper bounds, by which hopeless placements are refused at once.

A rod of which every other centre line keeps a distance d owns the points closer than d/2 to its own: a capsule, or a
strip with round ends on a surface. No packing is closer than that of parallel straight ones.
"""

from __future__ import annotations

import math

import numpy as np

from warp_rods.errors import SceneError

DENSEST = math.pi / math.sqrt(12)
"""Part of the space that infinitely long parallel cylinders, or of the plane that equal discs, can fill."""
CURVED = 1.1
"""Allowance for errors of the area, and for membranes that curve within the width of a strip."""


def extents(lines: np.ndarray) -> np.ndarray:
    """Largest distance of a node from either end of its rod [rod], for centre lines [rod, node, 3]."""
    ends = (np.linalg.norm(lines - lines[:, end : end + 1 or None], axis=-1).max(axis=1) for end in (0, -1))
    return np.maximum(*ends)


def refuse_crowd(extent: np.ndarray, clearance: float, volume: float) -> None:
    """Raises SceneError where rods of these extents [rod] cannot keep the clearance in a volume.

    The points within r = d/2 of a curve whose ends are D apart fill at least as much as a straight capsule,
    π r² D + 4π r³/3: every section across the line between the ends contains a disc of radius r.
    """
    r = clearance / 2
    _refuse(math.pi * r**2 * (extent + 4 / 3 * r), clearance, DENSEST * volume, "volume")


def refuse_crowd_on(length: np.ndarray, clearance: float, area: float) -> None:
    """Raises SceneError where geodesic filaments of these lengths [rod] cannot keep the clearance on a surface."""
    _refuse(_strips(length, clearance), clearance, CURVED * area, "area")


def area_for(length: np.ndarray, clearance: float) -> float:
    """The least area on which geodesic filaments of these lengths [rod] could keep the clearance."""
    return float(_strips(length, clearance).sum()) / CURVED


def _strips(length: np.ndarray, clearance: float) -> np.ndarray:
    """Their shares of it [rod]: on a plane strips lie side by side, and their round ends as densely as discs."""
    r = clearance / 2
    return 2 * r * length + math.pi / DENSEST * r**2


def _refuse(shares: np.ndarray, clearance: float, room: float, what: str) -> None:
    count = len(shares)
    if (needed := float(shares.sum())) <= room:
        return
    fit = int(np.searchsorted(np.cumsum(np.sort(shares)), room))
    raise SceneError(
        f"count = {count}: centre lines {clearance:g} apart would need {needed / room:.3g} times the {what} that is "
        f"there, packed as closely as possible; at most {fit} could fit, and at random about half of them: place fewer"
    )

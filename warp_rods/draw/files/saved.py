"""Positions of the trajectory as saved: without the jumps of rods that are drawn in a periodic box."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from warp_rods.draw.rods import Rods

__all__ = ["blocks", "saved_positions"]

_READ_AT_ONCE = 16e6
"""Bytes."""


def blocks(rods: Rods, numbers_of_a_node: int) -> Iterator[range]:
    """The chosen frames of the trajectory in parts of a limited size: a read of Zarr costs milliseconds."""
    step = max(1, int(_READ_AT_ONCE / (8 * numbers_of_a_node * rods.count * rods.nodes)))
    for start in range(0, len(rods.frames), step):
        yield rods.frames[start : start + step]


def saved_positions(rods: Rods) -> Iterator[np.ndarray]:
    """Centre lines [rod, node, 3] at each chosen frame, NaN where a rod is lost; not shifted into a periodic box."""
    for frame in range(len(rods.frames)):
        yield rods.without_lost(rods.variable("position", frame), frame)

"""Positions of the trajectory as saved: without the jumps of rods that are drawn in a periodic box."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from warp_rods.draw.rods import Rods

__all__ = ["saved_positions"]


def saved_positions(rods: Rods) -> Iterator[np.ndarray]:
    """Centre lines [rod, node, 3] at each chosen frame, NaN where a rod is lost; not shifted into a periodic box."""
    for frame in range(len(rods.frames)):
        yield rods.without_lost(rods.variable("position", frame), frame)

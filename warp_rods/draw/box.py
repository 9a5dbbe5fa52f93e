"""The edges of a box."""

from __future__ import annotations

import numpy as np

__all__ = ["edges_of"]


def edges_of(box: np.ndarray) -> np.ndarray:
    """Both ends [12, 2, 3] of the edges of a box of these sizes [3] around the origin."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    pairs = [(a, b) for a in range(8) for b in range(a + 1, 8) if (corners[a] != corners[b]).sum() == 1]
    return corners[np.array(pairs)] * box

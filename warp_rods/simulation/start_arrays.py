"""What the shape of rods at the start is when files give it: arrays at their nodes, and where they are from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

__all__ = ["Arrays", "Given", "Source", "largest_bending", "resampled"]

Arrays = dict[str, np.ndarray]
Source = tuple[str, str]
"""A file or a frame of a run, and the SHA-256 of what was read."""
AT_NODES = ("strain", "activity", "line", "tangent", "geodesic_curvature")
"""Arrays [rod, node, …]."""


@dataclass(frozen=True)
class Given:
    """Rods as files have them.

    at(nodes): of swimmers ``strain`` [rod, node, 3], perhaps ``activity`` [rod, node], and ``position`` [rod, 3] and
    ``rotation`` [rod, 3, 3] of the middle node; of filaments ``line`` and ``tangent`` [rod, node, 3],
    ``geodesic_curvature`` [rod, node], ``length`` [rod]; with lines for the user.
    """

    at: Callable[[int], tuple[Arrays, list[str]]]
    sources: tuple[Source, ...]


def resampled(arrays: Arrays, nodes: int) -> Arrays:
    """Arrays of a start with another number of nodes, by cubic splines along the rod; the same where it is the same."""
    given = arrays["strain" if "strain" in arrays else "geodesic_curvature"].shape[1]
    if given == nodes:
        return arrays
    from scipy.interpolate import make_interp_spline

    old, new = np.linspace(-0.5, 0.5, given), np.linspace(-0.5, 0.5, nodes)
    return {
        name: make_interp_spline(old, values, axis=1)(new) if name in AT_NODES else values
        for name, values in arrays.items()
    }


def largest_bending(arrays: Arrays) -> float:
    """The largest curvature of swimmers, or geodesic curvature of filaments, at a node; 1/length."""
    if "strain" in arrays:
        return float(np.linalg.norm(arrays["strain"][..., 1:], axis=-1).max())
    return float(np.abs(arrays["geodesic_curvature"]).max())

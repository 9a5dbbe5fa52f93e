"""Points as measured, made fit for a curve: without missing and repeated ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warp_rods.centrelines.track import TrackError

__all__ = ["FEWEST", "Points", "cleaned"]

FEWEST = 4
"""Points of a line, at least."""
FARTHEST = 1e6
"""Largest distance of points from the origin in lengths of the line: beyond, digits are lost."""
LARGEST, SMALLEST = 1e30, 1e-30
"""Of coordinates, and of the size of a line."""
FAR_APART = 10.0
"""Steps from point to point above so many median ones are told."""


@dataclass(frozen=True)
class Points:
    """Points [point, 3] in order along a line, of which no two neighbours coincide.

    flat: whether all were given in two dimensions, or lie in one plane z = const. notes: lines for the user.
    """

    points: np.ndarray
    flat: bool
    notes: tuple[str, ...]


def cleaned(given: np.ndarray) -> Points:
    """Points [point, 2 or 3] without rows that have a NaN, and without repetitions of the point before.

    Raises TrackError for infinite values, and where fewer than four different points are left.
    """
    if given.ndim != 2 or given.shape[1] not in (2, 3):
        raise TrackError(f"must be points [point, 2 or 3]; has shape {given.shape}")
    if np.isinf(given).any():
        raise TrackError(f"has an infinite value in row {int(np.isinf(given).any(axis=1).argmax())}")
    if np.nanmax(np.abs(given), initial=0.0) > LARGEST:
        raise TrackError(f"has coordinates up to {np.nanmax(np.abs(given)):.3g}: use other units; at most {LARGEST:g}")
    there = ~np.isnan(given).any(axis=1)
    points = np.zeros((int(there.sum()), 3))
    points[:, : given.shape[1]] = given[there]
    size = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if 0 < size < SMALLEST:
        raise TrackError(f"has a size of {size:.3g}: use other units; at least {SMALLEST:g}")
    apart = np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-12 * size
    new = np.r_[True, apart] if len(points) else np.zeros(0, dtype=bool)
    repeated, points = int((~new).sum()), points[new]
    if len(points) < FEWEST:
        raise TrackError(f"has {len(points)} different points, of {len(given)} rows: must be {FEWEST} or more")
    if np.abs(points).max() > FARTHEST * size:
        raise TrackError(f"has a size of {size:.3g}, more than {FARTHEST:g} sizes from the origin: move it there")
    notes = [f"{len(given) - int(there.sum())} missing points left out"] if not there.all() else []
    notes += [f"{repeated} repeated points left out"] if repeated else []
    return Points(points, not np.ptp(points[:, 2]), (*notes, *_far_steps(points)))


def _far_steps(points: np.ndarray) -> list[str]:
    """A line on the longest step, where it is so long that points may be missing or not in order."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    longest = int(steps.argmax())
    ratio = steps[longest] / np.median(steps)
    if ratio < FAR_APART:
        return []
    return [
        f"points {longest} and {longest + 1} are {ratio:.3g} times as far apart as usual: points must be in order "
        f"along the line, and gaps are bridged smoothly"
    ]

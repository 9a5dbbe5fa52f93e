"""Paths in traced trees (SWC): rows of id, type, x, y, z, radius and the id of the parent, −1 for a root."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from warp_rods.centrelines.track import Track, TrackError, listed

__all__ = ["read_swc"]

COLUMNS = "id, type, x, y, z, radius, parent"


def read_swc(path: Path, branch: int | None = None) -> Track:
    """The path from the root to the tip with the id ``branch``, or to the only tip of a tree without branches."""
    places, parents = _read(path)
    tips = sorted(parents.keys() - set(parents.values()))
    if branch is None and len(tips) != 1:
        raise TrackError(f"has {len(tips)} tips, with the ids {listed(tips)}: choose one by branch")
    tip = tips[0] if branch is None else branch
    if tip not in tips:
        raise TrackError(f"branch = {tip}: must be the id of a tip, one of {listed(tips)}")
    route = [tip]
    while parents[route[-1]] != -1:
        route.append(parents[route[-1]])
        if len(route) > len(parents):
            raise TrackError(f"is no tree: the parents of {tip} form a loop")
    return Track(np.array([places[one] for one in reversed(route)]), None, f"from {route[-1]} to the tip {tip}")


def _read(path: Path) -> tuple[dict[int, list[float]], dict[int, int]]:
    """Place and parent of each node, by its id."""
    places: dict[int, list[float]] = {}
    parents: dict[int, int] = {}
    for number, line in enumerate(path.read_text(encoding="utf-8-sig").splitlines(), start=1):
        cells = line.partition("#")[0].replace(",", " ").split()
        if not cells:
            continue
        try:
            one, parent = int(float(cells[0])), int(float(cells[6]))
            place = [float(cell) for cell in cells[2:5]]
        except (ValueError, IndexError, OverflowError):
            raise TrackError(f"line {number}: must be the numbers {COLUMNS}; is {line.strip()[:60]!r}") from None
        if one in places:
            raise TrackError(f"line {number}: the id {one} is there twice")
        places[one], parents[one] = place, parent if parent >= 0 else -1
    if not places:
        raise TrackError("has no nodes")
    if lost := [one for one, parent in parents.items() if parent != -1 and parent not in places]:
        raise TrackError(f"the parent {parents[lost[0]]} of {lost[0]} is missing")
    return places, parents

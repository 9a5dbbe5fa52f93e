"""Midlines of worms in files of the Tracker Commons (WCON), which are JSON: https://github.com/openworm/tracker-commons."""

from __future__ import annotations

import json
import math
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from warp_rods.centrelines.track import Track, TrackError, chosen_frame, listed, metres_of

__all__ = ["read_wcon"]


class Midline(NamedTuple):
    """A worm at a time: points [point, 2], from the head where that is known."""

    worm: str
    time: float
    points: np.ndarray


def read_wcon(path: Path, worm: str | int | None = None, frame: int | None = None, time: float | None = None) -> Track:
    """The midline of a worm, by its id, at a frame of this worm or at a time in units of the file.

    Points begin at the head where the file says which end that is. Missing points (null) are NaN.
    """
    content = _content(path)
    unit = content["units"].get("x") if isinstance(content.get("units"), dict) else None
    try:
        lines = sorted(_midlines(content.get("data")), key=lambda line: line.time)
    except (TypeError, ValueError, KeyError, IndexError) as fault:
        raise TrackError(f"is no WCON: its data cannot be read ({fault})") from None
    worms = list(dict.fromkeys(line.worm for line in lines))
    if not worms:
        raise TrackError("has no worms")
    if worm is None and len(worms) > 1:
        raise TrackError(f"has the worms {listed(worms)}: choose one by worm")
    if worm is not None and str(worm) not in worms:
        raise TrackError(f"worm = {worm!r}: has the worms {listed(worms)}")
    name = worms[0] if worm is None else str(worm)
    own = [line for line in lines if line.worm == name]
    line = own[chosen_frame([line.time for line in own], frame, time)]
    if not np.isfinite(line.points).all(axis=1).any():
        seen = [i for i, other in enumerate(own) if np.isfinite(other.points).all(axis=1).any()]
        raise TrackError(f"has no points of worm {name} at time {line.time:g}; frames with points: {listed(seen)}")
    return Track(line.points, metres_of(unit), f"worm {name} at time {line.time:g}")


def _content(path: Path) -> dict[str, Any]:
    try:
        if path.suffix.lower() == ".zip":
            with zipfile.ZipFile(path) as archive:
                names = [name for name in archive.namelist() if not name.endswith("/")]
                if len(names) != 1:
                    raise TrackError(f"holds {len(names)} files: unpack it and choose one")
                text = archive.read(names[0])
        else:
            text = path.read_bytes()
        content = json.loads(text.decode("utf-8-sig"))
    except TrackError:
        raise
    except (ValueError, zipfile.BadZipFile, RecursionError) as fault:
        raise TrackError(f"is no JSON: {fault}") from None
    if not isinstance(content, dict) or "data" not in content:
        raise TrackError('is no WCON: it must be an object with "units" and "data"')
    return content


def _midlines(data: Any) -> Iterator[Midline]:
    """Every worm at every time. The origin is (ox, oy), else the centroid (cx, cy), else 0."""
    for entry in data if isinstance(data, list) else [data]:
        times = entry["t"] if isinstance(entry["t"], list) else [entry["t"]]
        count = len(times)
        x, y = (_rows(entry[key], count, isinstance(entry["t"], list)) for key in ("x", "y"))
        ox, oy = (_each(entry.get(f"o{a}", entry.get(f"c{a}", 0.0)), count) for a in "xy")
        head = _each(entry.get("head", "?"), count)
        for i, time in enumerate(times):
            points = np.column_stack([x[i] + _real(ox[i]), y[i] + _real(oy[i])])
            yield Midline(str(entry["id"]), _real(time), points[::-1] if head[i] == "R" else points)


def _rows(values: Any, count: int, arrayed: bool) -> list[np.ndarray]:
    """The points of each time: a list of lists, or one list where there is one time."""
    nested = isinstance(values, list) and any(isinstance(row, list) for row in values)
    rows = values if nested else [values] if not arrayed or count == 1 else values
    if len(rows) != count:
        raise ValueError(f"{len(rows)} rows of points for {count} times")
    return [np.array([_real(v) for v in (row if isinstance(row, list) else [row])]) for row in rows]


def _each(value: Any, count: int) -> list[Any]:
    return value if isinstance(value, list) else [value] * count


def _real(value: Any) -> float:
    return math.nan if value is None else float(value)

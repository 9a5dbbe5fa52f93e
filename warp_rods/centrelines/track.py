"""What a reader of centre lines returns, and what readers share."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["Track", "TrackError", "chosen_frame", "listed", "metres_of"]

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "in": 0.0254}
WORDS = {
    **{f"{prefix}{root}": size * METRES["m"]
       for prefix, size in {"": 1.0, "centi": 1e-2, "milli": 1e-3, "micro": 1e-6, "nano": 1e-9}.items()
       for root in ("metre", "meter")},
    "micron": 1e-6, "inch": 0.0254,
}  # fmt: skip
MOST_LISTED = 12


class TrackError(ValueError):
    """A file, or points, that give no centre line; the message follows the name of the file."""


@dataclass(frozen=True)
class Track:
    """Points along a line as a file has them.

    points: [point, 2 or 3], NaN where one is missing. metres: one unit of the points, None where the file does not say.
    chosen: which of several lines this is, in words.
    """

    points: np.ndarray
    metres: float | None = None
    chosen: str = ""


def metres_of(unit: Any) -> float | None:
    """A unit of length such as "um", "microns", "0.65*um" or "in/72" in metres; None where it is not known."""
    if not isinstance(unit, str):
        return None
    found, known = 1.0, False
    for part in unit.replace("/", "*/").split("*"):
        word, power = part.strip().removeprefix("/").strip(), -1 if part.strip().startswith("/") else 1
        size = METRES.get(word) or WORDS.get(word) or WORDS.get(word.removesuffix("s"))
        if size is not None and power == 1 and not known:
            found, known = found * size, True
            continue
        try:
            found *= float(word) ** power
        except (ValueError, ZeroDivisionError):
            return None
    return found if known and 0 < found < math.inf else None


def listed(values: Sequence[Any]) -> str:
    """Values in a message, the first dozen of many."""
    shown = ", ".join(f"{value:g}" if isinstance(value, float) else str(value) for value in values[:MOST_LISTED])
    return shown + (f", … ({len(values)} in all)" if len(values) > MOST_LISTED else "")


def chosen_frame(times: Sequence[float], frame: int | None, time: float | None) -> int:
    """The index of the line that ``frame`` (from the end where negative) or ``time`` (the nearest) chooses.

    Raises TrackError where there are several and none is chosen, and where there is no such frame or time.
    """
    count = len(times)
    if frame is not None and time is not None:
        raise TrackError(f"frame = {frame} and time = {time:g}: give one of them")
    if frame is not None:
        if not -count <= frame < count:
            raise TrackError(f"frame = {frame}: has {count} frames, 0 to {count - 1}, or -1 for the last")
        return frame % count
    if time is not None:
        distance = np.abs(np.asarray(times, dtype=float) - time)
        if not np.isfinite(distance).any():
            raise TrackError(f"time = {time:g}: its frames have no times: choose one by frame")
        nearest = int(np.nanargmin(distance))
        apart = np.diff(np.unique(np.asarray(times, dtype=float)))
        if distance[nearest] > (float(apart.max()) if len(apart) else 1e-9 * max(1.0, abs(time))):
            raise TrackError(f"time = {time:g}: has the times {listed([float(t) for t in times])}")
        return nearest
    if count > 1:
        spoken = listed([float(t) for t in times])
        raise TrackError(f"has {count} frames, at the times {spoken}: choose one by frame, such as 0, or by time")
    return 0

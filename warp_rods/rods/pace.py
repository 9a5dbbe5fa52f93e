"""The array of steps of an ensemble: times of the levels of each rod, and its next step."""

from __future__ import annotations

from typing import Any

import warp as wp

from warp_rods.kernels.layout import per_rod
from warp_rods.kernels.multistep import LEVELS, Pace

PACE = ("at", "levels", "order", "step", "waited", "taken", "rejected", "largest_error", "total_error")
"""The fields that are part of the state of an ensemble; the highest order is a parameter."""


def allocate_pace(rods: int, device: Any) -> Any:
    """The pace of rods that have not taken a step yet."""
    pace = Pace()
    pace.at = wp.zeros((rods, LEVELS), dtype=wp.float64, device=device)
    for name in ("step", "largest_error", "total_error"):
        setattr(pace, name, per_rod(rods, device=device))
    pace.levels, pace.order = (wp.full(rods, 1, dtype=wp.int32, device=device) for _ in range(2))
    for name in ("waited", "highest_order", "taken", "rejected"):
        setattr(pace, name, per_rod(rods, wp.int32, device))
    return pace


def restart_pace(pace: Any, time: float) -> None:
    """Let all rods begin anew at this time, with no past."""
    pace.at.fill_(time)
    pace.levels.fill_(1)
    pace.order.fill_(1)
    pace.waited.zero_()

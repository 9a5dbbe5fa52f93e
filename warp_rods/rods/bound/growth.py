"""Length of filaments against time: constant, growing at a rate up to a length, or from a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from warp_rods.errors import SceneError
from warp_rods.rods.per_rod import each_rod


def knots(growth: Mapping[str, Any] | None, length: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times and lengths [rod, knot] of a length that is linear between knots and constant outside them.

    growth: None for a constant length; ``{rate, until, start}``: growth at ``rate`` from the time ``start`` (default 0)
    up to the length ``until``; or ``{time, length}``: a table, one for all rods or [rod, knot], that begins with the
    length of the rods. Raises SceneError if the length would shrink or the times do not increase.
    """
    count = len(length)
    if growth is None:
        return np.zeros((count, 1)), length[:, None].copy()
    if growth.get("rate") is not None:
        rate, until, start = (each_rod(growth.get(k, 0.0), count) for k in ("rate", "until", "start"))
        if (until <= length).any() or (rate <= 0).any():
            raise SceneError("growth: rate must be positive, and until larger than the length at the start")
        return np.stack([start, start + (until - length) / rate], axis=1), np.stack([length, until], axis=1)
    time, table = (np.atleast_2d(np.asarray(growth[k], dtype=float)) for k in ("time", "length"))
    if time.shape[1] != table.shape[1] or (np.diff(time) <= 0).any() or (np.diff(table) < 0).any():
        raise SceneError(
            "growth: time and length need the same number of values, with time increasing and length not decreasing"
        )
    shape = (count, time.shape[1])
    if not np.allclose(table[:, 0], length, atol=0.0):
        raise SceneError(f"growth.length: must begin with the filaments' length, {length.tolist()}")
    return np.broadcast_to(time, shape).copy(), np.broadcast_to(table, shape).copy()


def length_at(table: tuple[np.ndarray, np.ndarray], time: float) -> np.ndarray:
    """Length [rod] at a time."""
    return np.array([np.interp(time, t, l) for t, l in zip(*table, strict=True)])


def rate_at(table: tuple[np.ndarray, np.ndarray], time: float) -> np.ndarray:
    """dL/dt [rod] just after a time."""
    rates = np.zeros(len(table[0]))
    for rod, (t, l) in enumerate(zip(*table, strict=True)):
        k = np.searchsorted(t, time, side="right")
        if 0 < k < len(t):
            rates[rod] = (l[k] - l[k - 1]) / (t[k] - t[k - 1])
    return rates

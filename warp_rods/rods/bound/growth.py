"""Length of filaments against time: constant, growing at a rate up to a length, or from a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from warp_rods import arguments
from warp_rods.errors import SceneError
from warp_rods.rods.per_rod import parameter
from warp_rods.scene.checks import read_table
from warp_rods.scene.filaments import GrowthTable

Knots = tuple[np.ndarray, np.ndarray]
"""Times and lengths [rod, knot] of a length that is linear between knots and constant outside them."""


def read(growth: Any) -> GrowthTable:
    """The table of a growth; an empty one for None. Raises SceneError naming each faulty key."""
    if growth is None:
        return GrowthTable.none()
    if not isinstance(growth, (Mapping, GrowthTable)):
        raise arguments.wrong("growth", growth, "a mapping { rate, until } or { time, length }, or None")
    return read_table(GrowthTable, growth, "growth")


def knots(growth: GrowthTable | Mapping[str, Any] | None, length: np.ndarray) -> Knots:
    """The knots of a growth of filaments with this ``length`` [rod] at the start; arrays that are read-only.

    growth: None for a constant length; ``{rate, until, start}``: growth at ``rate`` from the time ``start`` (default 0)
    up to the length ``until``; or ``{time, length}``: a table, one for all rods or [rod, knot], that begins with the
    length of the rods. Raises SceneError naming the key.
    """
    table = growth if isinstance(growth, GrowthTable) else read(growth)
    found = _of_rate(table, length) if table.rate is not None else _of_table(table, length)
    for values in found:
        values.setflags(write=False)
    return found


def _of_rate(table: GrowthTable, length: np.ndarray) -> Knots:
    given = {"rate": table.rate, "until": table.until, "start": table.start or 0.0}
    rules = {"start": "zero or more"}
    rate, until, start = (
        parameter(f"growth.{key}", value, len(length), rules.get(key, "positive")) for key, value in given.items()
    )
    if len(short := np.flatnonzero(until <= length)):
        raise SceneError(f"growth.until = {until[short[0]]:g}: must be above the length, {length[short[0]]:g}")
    return np.stack([start, start + (until - length) / rate], axis=1), np.stack([length, until], axis=1)


def _of_table(table: GrowthTable, length: np.ndarray) -> Knots:
    count = len(length)
    if table.time is None:
        return np.zeros((count, 1)), length[:, None].copy()
    time, lengths = (np.atleast_2d(np.asarray(values, dtype=float)) for values in (table.time, table.length))
    for name, values in (("time", time), ("length", lengths)):
        if len(values) not in (1, count):
            raise SceneError(f"growth.{name}: needs one list, or one for each of {count} rods; has {len(values)}")
    if not np.allclose(lengths[:, 0], length, atol=0.0):
        raise SceneError(f"growth.length: must begin with the filaments' length, {length.tolist()}")
    shape = (count, time.shape[1])
    return np.broadcast_to(time, shape).copy(), np.broadcast_to(lengths, shape).copy()


def length_at(table: Knots, time: float) -> np.ndarray:
    """Length [rod] at a time."""
    return np.array([np.interp(time, t, l) for t, l in zip(*table, strict=True)])


def rate_at(table: Knots, time: float) -> np.ndarray:
    """dL/dt [rod] just after a time."""
    rates = np.zeros(len(table[0]))
    for rod, (t, l) in enumerate(zip(*table, strict=True)):
        k = np.searchsorted(t, time, side="right")
        if 0 < k < len(t):
            rates[rod] = (l[k] - l[k - 1]) / (t[k] - t[k - 1])
    return rates

"""Every kind of surface by its name in a scene, and the check of its values. Builds nothing, imports no kernels."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import MutableMapping
from typing import Any

import numpy as np

from warp_rods.membranes import motion
from warp_rods.membranes.built_in import SURFACES
from warp_rods.membranes.expression import Expression
from warp_rods.membranes.grid import Grid
from warp_rods.membranes.level_set import Fault, Kind, Values
from warp_rods.values import key_path, must_be, nearest

__all__ = ["GIVEN", "KINDS", "motion_faults", "read"]

CHECKED_TIMES = 50
"""Number of times at which the values of a moving surface are checked before a run."""

GIVEN: dict[str, Kind] = {"expression": Expression(), "grid": Grid()}
"""Kinds of surface given by the user, as a formula or a file."""

KINDS: MutableMapping[str, Kind] = ChainMap(GIVEN, SURFACES)  # type: ignore[arg-type]
"""Every kind of surface."""


def read(kind: Any, raw: Any) -> tuple[dict[str, Any], list[Fault]]:
    """The values of a surface with defaults filled in, and their faults; the surface is not built."""
    if not isinstance(kind, str) or kind not in KINDS:
        return {}, [(("kind",), must_be(f"one of {', '.join(KINDS)}", kind) + nearest(kind, KINDS))]
    if not isinstance(raw, dict):
        return {}, [((), must_be("a table of values by name", raw))]
    row = KINDS[kind]
    unknown: list[Fault] = [
        ((key,), f": not a parameter of {kind}{nearest(key, row.keys)}; it has {', '.join(row.keys)}")
        for key in raw
        if key not in row.keys
    ]
    values, faults = row.read(raw)
    return values, unknown + faults


def motion_faults(kind: str, values: Values, end: float) -> list[Fault]:
    """The first faults of the values of a moving surface up to the time ``end``."""
    for time in np.linspace(0.0, end, CHECKED_TIMES if end else 1) if motion.is_moving(values) else ():
        try:
            now = motion.values_at(values, time)
            motion.rates_at(values, time)
        except motion.MotionError as error:
            return [error.fault]
        if kind in SURFACES and (faults := SURFACES[kind].read(now)[1]):
            return [_at_time(time, fault) for fault in faults]
    return []


def _at_time(time: float, fault: Fault) -> Fault:
    """The fault, with the time at which it occurs."""
    loc, text = fault
    return (), f" at t = {time:.4g}: {(key_path(loc) + text).removeprefix(': ')}"

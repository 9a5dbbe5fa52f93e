"""Step an ensemble in time and keep frames of it, as the trajectory of a run would have them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.errors import RodFailure
from warp_rods.rods.variables import ARC, static_variable

SWIMMING = ("position", "strain", "activity", "status")
"""Variables from which speeds, mode coefficients and classes of motion are computed."""


def integrate(
    rods: Any, times: Sequence[float] | np.ndarray, variables: Sequence[str] = SWIMMING, tolerance: float = 1e-3
) -> xr.Dataset:
    """Advance rods (``FreeRods``, ``BoundRods``) to each of ``times`` in steps by error; one frame for each.

    ``variables``: names of the variables to keep. ``tolerance``: as in ``advance_to``. The dataset also has
    ``time``, ``s`` and all constant variables.
    Raises RodFailure where a rod fails.
    """
    frames: dict[str, list[np.ndarray]] = {name: [] for name in variables}
    for time in times:
        if time > rods.time:
            rods.advance_to(time, tolerance)
        now = rods.variables()
        for name, column in frames.items():
            column.append(now[name])
    if failures := rods.failures():
        rod, when, what = failures[0]
        raise RodFailure(f"{len(failures)} rods failed; rod {rod} {what} at t = {when:.4g}: {rods.parameters(rod)}")
    data: dict[str, Any] = {name: (rods.saved[name].dims, np.array(column)) for name, column in frames.items()}
    data |= {
        name: (static_variable(name, value.ndim).dims, value)
        for name, value in rods.static().items()
        if name not in data
    }
    s = np.linspace(-0.5, 0.5, next((v[1].shape[2] for v in data.values() if "node" in v[0]), rods.nodes))
    return xr.Dataset(data, coords={"time": ("frame", np.asarray(times)), "s": (ARC.dims, s)})

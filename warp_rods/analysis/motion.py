"""Speed of the middle node, over an interval of time and at each frame."""

from __future__ import annotations

import numpy as np
import xarray as xr

from warp_rods.analysis.described import FRAMES, described, need, rate


def speed(dataset: xr.Dataset, since: float | None = None, until: float | None = None) -> xr.DataArray:
    """Swimming speed from start to end (rod).

    U_swim = |∫ R u dt|/T = |r(T) − r(0)|/T of the middle node (§4.4), between the frames nearest ``since`` and
    ``until``, by default the first and the last. Raises ValueError where both are the same frame.
    """
    time = dataset["time"].to_numpy()
    first = 0 if since is None else int(np.argmin(abs(time - since)))
    last = len(time) - 1 if until is None else int(np.argmin(abs(time - until)))
    if first >= last:
        raise ValueError(
            f"no two frames between {since} and {until}; there are frames from {time[0]:g} to {time[-1]:g}"
        )
    middle = _middle(dataset)
    values = np.linalg.norm(middle[last] - middle[first], axis=-1) / (time[last] - time[first])
    return described(dataset, ("rod",), values, "length/time", "swimming speed", "|∫ R u dt|/T, §4.4")


def instantaneous_speed(dataset: xr.Dataset) -> xr.DataArray:
    """Speed of the middle node (frame, rod).

    |∂t r(0, t)| from differences between frames, second order in their spacing. Raises ValueError where there are fewer
    than three frames.
    """
    velocity = rate(dataset, _middle(dataset))
    return described(
        dataset, FRAMES, np.linalg.norm(velocity, axis=-1), "length/time", "speed of the midpoint", "|∂t r(0, t)|"
    )


def _middle(dataset: xr.Dataset) -> np.ndarray:
    """Position of the middle node [frame, rod, 3]."""
    need(dataset, "position")
    middle = dataset["position"].isel(node=dataset.sizes["node"] // 2)
    return middle.transpose("frame", "rod", "axis").to_numpy()

"""Functions for all measures: check the variables that they need, and label the DataArray that they return.

Units of length, force and time are those of the trajectory.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

FRAMES = ("frame", "rod")


def need(dataset: xr.Dataset, *names: str) -> None:
    """Raises ValueError where the dataset lacks one of these variables, naming it."""
    if lacking := [name for name in names if name not in dataset]:
        raise ValueError(f"the group has no {', '.join(lacking)}; it has {', '.join(sorted(map(str, dataset)))}")


def attributes(units: str, long_name: str, source: str = "") -> dict[str, str]:
    """Attributes of a variable as in trajectories; ``source`` is the equation."""
    return {"units": units, "long_name": long_name, **({"source": source} if source else {})}


def described(
    dataset: xr.Dataset, dims: Sequence[str], values: Any, units: str, long_name: str, source: str
) -> xr.DataArray:
    """A DataArray of values with these dimensions, the time of each frame, and attributes."""
    coords = {"time": dataset["time"]} if "frame" in dims and "time" in dataset.coords else {}
    return xr.DataArray(values, dims=tuple(dims), coords=coords, attrs=attributes(units, long_name, source))


def lengths(dataset: xr.Dataset) -> np.ndarray:
    """Length of each rod [rod]; 1 where the group has no length."""
    return dataset["length"].to_numpy() if "length" in dataset else np.ones(dataset.sizes["rod"])


def positions(dataset: xr.Dataset) -> np.ndarray:
    """Positions [frame, rod, node, 3]."""
    need(dataset, "position")
    return dataset["position"].transpose("frame", "rod", "node", "axis").to_numpy()


def strains(dataset: xr.Dataset) -> np.ndarray:
    """Strains [frame, rod, node, 3], twist first."""
    need(dataset, "strain")
    return dataset["strain"].transpose("frame", "rod", "node", "strain_component").to_numpy()


def rate(dataset: xr.Dataset, values: np.ndarray) -> np.ndarray:
    """Time derivative of values [frame, ...], second order on frames of any spacing.

    Raises ValueError where there are fewer than three frames.
    """
    time = dataset["time"].to_numpy()
    if len(time) < 3:
        raise ValueError(f"a rate of change needs three frames or more; there are {len(time)}")
    return np.gradient(values, time, axis=0, edge_order=2)

"""Functions for all measures: check the variables that they need, and label the DataArray that they return.

Units of length, force and time are those of the trajectory; where its scene has [units], they are named in SI.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.quantities import with_prefixes
from warp_rods.scene.units import Scale

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
    """A DataArray of values with these dimensions, the time of each frame, and attributes; units in SI where known."""
    units = units_of(dataset, units)
    coords = {"time": dataset["time"]} if "frame" in dims and "time" in dataset.coords else {}
    return xr.DataArray(values, dims=tuple(dims), coords=coords, attrs=attributes(units, long_name, source))


def lengths(dataset: xr.Dataset) -> np.ndarray:
    """Length of each rod [frame, rod], as filaments may grow; 1 where the group has no length."""
    shape = (dataset.sizes["frame"], dataset.sizes["rod"])
    if "length" not in dataset:
        return np.ones(shape)
    length = dataset["length"]
    return np.broadcast_to(length.transpose(*(dim for dim in FRAMES if dim in length.dims)).to_numpy(), shape)


def without_failed(dataset: xr.Dataset) -> xr.Dataset:
    """The rods that have not failed by the last frame; ``rod`` has their numbers where others failed.

    Raises ValueError where all failed.
    """
    if "status" not in dataset:
        return dataset
    kept = np.flatnonzero(dataset["status"].isel(frame=-1).to_numpy() == 0)
    if not len(kept):
        raise ValueError(
            "all rods failed: nothing is left to measure; select earlier frames, data.isel(frame=slice(…)), to measure "
            "rods until they failed"
        )
    numbers = dataset["rod"].to_numpy()
    return dataset if len(kept) == len(numbers) else dataset.isel(rod=kept).assign_coords(rod=numbers[kept])


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


def in_si(dataset: xr.Dataset, units: str) -> tuple[float, str]:
    """One of these units of the data in SI, with prefixes, and what it is called: 1.0, " 1/µm²".

    1 and nothing where the data have no such units.
    """
    number, unit = _scale(dataset).number_in_si(units)
    if not unit:
        return number, ""
    number, unit = with_prefixes(number, unit)
    return number, " " + unit.replace("^2", "²").replace("^3", "³")


def units_of(dataset: xr.Dataset, product: str) -> str:
    """Units such as "length/time" as they are named in this trajectory: in SI where its scene has [units]."""
    return _scale(dataset).in_si(product)


def _scale(dataset: xr.Dataset) -> Scale:
    return Scale.read(dataset.attrs.get("units", ""))

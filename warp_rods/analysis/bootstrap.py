"""Error bars by resampling the rods."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import xarray as xr


def bootstrap(
    values: xr.DataArray,
    statistic: Callable[..., np.ndarray] = np.nanmedian,
    resamples: int = 1000,
    level: float = 0.68,
    seed: int = 0,
) -> xr.Dataset:
    """A statistic over the rods, ``value``, with its percentile interval of this ``level``, ``low`` to ``high``.

    ``values`` have a dimension ``rod``, which is resampled with replacement. ``statistic(array, axis=0)`` reduces it,
    and must accept NaN of failed rods and inf of rods that did not settle. Equal seeds give equal intervals.
    """
    rods = values.transpose("rod", ...)
    rng, count = np.random.default_rng(seed), rods.sizes["rod"]
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "All-NaN|Mean of empty", RuntimeWarning)  # the result is NaN
        whole = np.asarray(statistic(rods.values, axis=0))
        drawn = [statistic(rods.values[rng.integers(count, size=count)], axis=0) for _ in range(resamples)]
    ordered = np.sort(drawn, axis=0)  # order statistics, as interpolation fails for inf
    tail = round((1 - level) / 2 * (resamples - 1))
    kept = rods.isel(rod=0, drop=True)
    bounds = {"value": whole, "low": ordered[tail], "high": ordered[-1 - tail]}
    return xr.Dataset({name: kept.copy(data=bound) for name, bound in bounds.items()})

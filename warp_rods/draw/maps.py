"""Maps in space and in time: functions ``(axes, measured, **options)``."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from warp_rods.analysis.kymograph import TERMS
from warp_rods.draw.labels import bin_edges, label, named, panels, times


def density_map(axes: Any, measured: xr.DataArray) -> None:
    """The map of the last frame; in three dimensions its mean along z."""
    last = measured.isel(frame=-1)
    last = last.mean("z") if last.ndim == 3 else last
    one, other = last.dims
    edges = [bin_edges(last[side].to_numpy()) for side in (one, other)]
    drawn = axes.pcolormesh(*edges, last.to_numpy().T, vmin=0, rasterized=True)
    axes.set(aspect="equal", xlabel=_named(last[one]), ylabel=_named(last[other]))
    axes.figure.colorbar(drawn, ax=axes, label=label(measured))
    axes.set_title(f"at t = {float(last['time']):.4g}" + (", mean along z" if measured.ndim == 4 else ""))


def _named(side: xr.DataArray) -> str:
    return named(str(side.name), str(side.attrs["units"]))


def energy_terms(axes: Any, measured: xr.Dataset, rod: int = 0) -> None:
    """Kymographs of the three energy densities of one rod; each colour scale ends at the 99th percentile.

    Raises ValueError where there is no such rod.
    """
    if not 0 <= rod < measured.sizes["rod"]:
        raise ValueError(f"rod = {rod}: there are {measured.sizes['rod']}, counted from 0")
    one = measured.isel(rod=rod)
    arc = one["arc"].to_numpy()
    time = np.broadcast_to(one["time"].to_numpy()[:, None], arc.shape)
    drawn = panels(axes, len(TERMS))
    for panel, (name, strain) in zip(drawn, TERMS.items(), strict=True):
        values = one[name].transpose("frame", "node").to_numpy()
        top = max(float(np.nanquantile(values, 0.99)), np.finfo(float).tiny)
        mapped = panel.pcolormesh(time, arc, values, vmin=0, vmax=top, shading="gouraud", rasterized=True)
        panel.figure.colorbar(mapped, ax=panel, extend="max", label=named("", one[name].attrs["units"]).strip())
        panel.set(
            title=f"energy per length of {strain}, rod {rod}", ylabel=named("arc length", one["arc"].attrs["units"])
        )
    times(drawn[-1], one)

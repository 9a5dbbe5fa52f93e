"""Plots against time: functions ``(axes, measured)``."""

from __future__ import annotations

from itertools import cycle
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.draw.labels import BAND, BLUE, GUIDE, ORANGE, label, panels, times
from warp_rods.draw.style import OKABE_ITO

ROUND_OFF = 1e-17
"""Smaller errors are drawn at this value."""


def curve(axes: Any, measured: xr.DataArray) -> None:
    """One value per frame; for several rods the median and the interquartile range."""
    measured = _known(measured)
    time = times(axes, measured)
    if measured.sizes.get("rod", 1) > 1:
        low, middle, high = measured.quantile([0.25, 0.5, 0.75], "rod").to_numpy()
        axes.fill_between(time, low, high, color=BLUE, label="interquartile range", **BAND)
        axes.plot(time, middle, color=BLUE, label="median")
        axes.legend()
    else:
        axes.plot(time, measured.to_numpy().reshape(-1), color=BLUE)
    if measured.size and float(measured.min()) >= 0:
        axes.set_ylim(0, 1.05 * axes.get_ylim()[1])
    axes.set_ylabel(label(measured))


def magnitude(axes: Any, measured: xr.DataArray) -> None:
    """Magnitude of a vector per frame (frame, rod, axis)."""
    curve(axes, ((measured**2).sum("axis", skipna=False) ** 0.5).rename(measured.name).assign_attrs(measured.attrs))


def error(axes: Any, measured: xr.DataArray) -> None:
    """Magnitude of an error; for several rods the median and the largest."""
    size = abs(_known(measured)).clip(min=ROUND_OFF)
    time = times(axes, size)
    axes.semilogy(time, size.median("rod"), color=BLUE, label="median")
    if size.sizes["rod"] > 1:
        axes.semilogy(time, size.max("rod"), color=ORANGE, label="largest")
        axes.legend()
    axes.set_ylabel(label(measured))


def modes(axes: Any, measured: xr.DataArray) -> None:
    """Each coefficient (…, component, mode) or (…, harmonic); for several rods its root mean square."""
    of = str(measured.dims[-1])
    each = measured.transpose("frame", "rod", ..., of)
    several = each.sizes["rod"] > 1
    values = (each**2).mean("rod") ** 0.5 if several else each.isel(rod=0)
    parts = [values.sel(component=k) for k in values["component"]] if "component" in values.dims else [values]
    drawn = panels(axes, len(parts))
    for number, (panel, part) in enumerate(zip(drawn, parts, strict=True), 1):
        for which, colour in zip(part[of].to_numpy(), cycle(OKABE_ITO)):
            panel.plot(part["time"], part.sel({of: which}), color=colour, label=f"{of} {which}")
        panel.set_ylabel((f"component {number}" if len(parts) > 1 else label(measured)) + (", rms" if several else ""))
    times(drawn[-1], measured)
    drawn[0].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    if len(parts) > 1:
        drawn[0].set_title(label(measured))


def order(axes: Any, measured: xr.DataArray) -> None:
    """An order parameter between 0 and 1, and its value for the same number of rods with random directions."""
    curve(axes, measured)
    axes.axhline(measured.attrs["isotropic"], label="random directions, 1/√N", **GUIDE)
    axes.set_ylim(0, 1.02)
    axes.legend()


def local_order(axes: Any, measured: xr.DataArray) -> None:
    """The mean over the rods and the interquartile range."""
    low, high = measured.quantile([0.25, 0.75], "rod").to_numpy()
    time = times(axes, measured)
    axes.fill_between(time, low, high, color=BLUE, label="interquartile range", **BAND)
    axes.plot(time, measured.mean("rod"), color=BLUE, label=f"mean, within {measured.attrs['radius']:.3g} of each rod")
    axes.set_ylim(0, 1.02)
    axes.set_ylabel(label(measured))
    axes.legend()


def enrichment(axes: Any, measured: xr.Dataset) -> None:
    """Enrichment at 𝒦 > 0 and 𝒦 < 0 with bootstrap intervals, and its value for uniformly distributed filaments."""
    time = times(axes, measured)
    for side, colour, sign in (("positive", BLUE, ">"), ("negative", ORANGE, "<")):
        part = measured.sel(side=side)
        name = f"$\\mathcal{{K}}$ {sign} 0, {float(part['area_share']):.0%} of the area"
        axes.fill_between(time, part["enrichment_low"], part["enrichment_high"], color=colour, **BAND)
        axes.plot(time, part["enrichment"], color=colour, label=name)
    axes.axhline(1, **GUIDE)
    axes.set_ylim(0, None)
    axes.set_ylabel("density over a uniform one")
    axes.legend()


def shape_shares(axes: Any, measured: xr.DataArray) -> None:
    """Fractions of the shape classes, stacked."""
    time = times(axes, measured)
    names = [str(name) for name in measured["shape"].to_numpy()]
    axes.stackplot(time, measured.transpose("shape", "frame").to_numpy(), labels=names, colors=OKABE_ITO, linewidth=0)
    axes.set(xlim=(time[0], time[-1]), ylim=(0, 1), ylabel=label(measured))
    handles, labels = axes.get_legend_handles_labels()
    axes.legend(handles[::-1], labels[::-1], loc="center left", bbox_to_anchor=(1.0, 0.5))


def crossings(axes: Any, measured: xr.DataArray) -> None:
    """Number of crossings since the start."""
    axes.step(times(axes, measured), np.cumsum(measured.to_numpy()), where="post", color=BLUE)
    axes.set_ylim(-0.05, max(1.0, 1.05 * float(measured.sum())))
    axes.set_ylabel("crossings since the start")
    axes.yaxis.get_major_locator().set_params(integer=True)


def _known(measured: xr.DataArray) -> xr.DataArray:
    """The frames in which some rod has a value; raises ValueError where there are none."""
    known = measured.dropna("frame", how="all")
    if not known.sizes["frame"]:
        raise ValueError(f"{measured.name} has no value in any frame: there is nothing to draw")
    return known

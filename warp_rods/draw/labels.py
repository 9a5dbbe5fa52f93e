"""Labels, axes and bins that several plots use."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.analysis.described import units_of
from warp_rods.draw.style import OKABE_ITO
from warp_rods.quantities import with_prefixes

BLUE, ORANGE = OKABE_ITO[:2]
GUIDE: dict[str, Any] = {"color": "0.5", "linewidth": 0.8, "linestyle": "--"}
BAND: dict[str, Any] = {"alpha": 0.25, "linewidth": 0}


def label(measured: xr.DataArray) -> str:
    """The long name and units of a measure, on two lines where they are long.

    Values are in the units of the scene; where these have a size in SI it is named: "µm", "in units of 20 µm".
    """
    return fill(named(str(measured.attrs["long_name"]), str(measured.attrs.get("units", "1"))), 38)


def named(name: str, units: str) -> str:
    """A name, and the units of its values in brackets where they have any: "speed (length/time)"."""
    words = _in_words(units).replace("^2", "²").replace("^3", "³").replace("*", "·")
    return name + (f" ({words})" if words not in ("", "1", name) else "")


def named_in(data: xr.Dataset, name: str, product: str) -> str:
    """A name and units such as "length/time", in SI where the scene of the data has these units."""
    return named(name, units_of(data, product))


def _in_words(units: str) -> str:
    """Units such as "1e-06 m" as what the values count: "µm"."""
    number, _, unit = units.partition(" ")
    try:
        size = float(number)
    except ValueError:
        return units
    size, unit = with_prefixes(size, unit) if unit else (size, unit)
    return units if not unit else unit if size == 1 else f"in units of {size:.4g} {unit}"


def times(axes: Any, measured: xr.DataArray | xr.Dataset) -> np.ndarray:
    """The times of the frames [frame]; labels the horizontal axis."""
    axes.set_xlabel(named("time", str(measured["time"].attrs.get("units", "time"))))
    return measured["time"].to_numpy()


def bin_edges(middles: np.ndarray) -> np.ndarray:
    """Edges of bins of equal width with these middles."""
    half = (middles[1] - middles[0]) / 2 if len(middles) > 1 else 0.5
    return np.append(middles - half, middles[-1] + half)


def plain_numbers(axis: Any) -> None:
    """A few plain numbers on a logarithmic axis, also where it spans less than a decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 300 * low else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def above(axes: Any) -> None:
    """The legend in one row above the axes, where it is over no line and takes no width."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, borderaxespad=0.2)


def panels(axes: Any, rows: int) -> list[Any]:
    """Panels above each other that replace these axes; the figure becomes higher for each additional one."""
    if rows == 1:
        return [axes]
    place = axes.get_subplotspec()
    axes.figure.set_figheight(axes.figure.get_figheight() * (1 + 0.35 * (rows - 1)))
    axes.remove()
    return list(place.subgridspec(rows, 1).subplots(sharex=True))

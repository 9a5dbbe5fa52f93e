"""Measures of swarms and their plots alone; ``warp_rods.measure`` and ``warp_rods.plot`` take all measures."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from warp_rods.analysis.registry import MEASURES as ALL
from warp_rods.analysis.registry import Measures, named, take
from warp_rods.analysis.swarm.data import together
from warp_rods.draw import measured

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["MEASURES", "PLOTS", "measure", "plot", "together"]

_ROWS = Measures({name: row for name, row in ALL.items() if row.of == "swarm"})
MEASURES: dict[str, Callable[..., xr.DataArray | xr.Dataset]] = {name: row.function for name, row in _ROWS.items()}
"""By name: functions ``(dataset, **options)``."""
PLOTS = {name: measured.PLOTS[name] for name in _ROWS}
"""Plot function ``(axes, measured)`` of each measure."""


def measure(data: xr.Dataset | xr.DataTree, *names: str, **options: Any) -> xr.Dataset:
    """Measures of a swarm by name, as ``warp_rods.measure`` takes them."""
    return take(_ROWS, data, names, options)


def plot(data: xr.Dataset | xr.DataTree, name: str, path: str | Path | None = None, **options: Any) -> Figure:
    """The figure of one measure of a swarm, as ``warp_rods.plot`` draws it."""
    named(_ROWS, name)
    return measured.plot(data, name, path, **options)

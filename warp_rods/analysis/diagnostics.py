"""Measures of single rods; ``warp_rods.measure`` takes all measures."""

from __future__ import annotations

from collections.abc import Callable

import xarray as xr

from warp_rods.analysis.registry import MEASURES as ALL
from warp_rods.analysis.registry import measure

__all__ = ["MEASURES", "measure"]

MEASURES: dict[str, Callable[..., xr.DataArray | xr.Dataset]] = {
    name: row.function for name, row in ALL.items() if row.of in ("rods", "swimmers")
}
"""By name: functions ``(dataset, **options)``."""

"""Curvature-sensing filaments: where they gather, and when they have settled.

The functions take one ensemble of a run (``open_run(folder)[name].to_dataset()``), and its membrane where they need it.
``warp_rods.measure`` computes the same measures and takes the membrane from the scene.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import xarray as xr

from warp_rods.analysis.bootstrap import bootstrap
from warp_rods.analysis.curvature import curvature_histogram, enrichment
from warp_rods.analysis.membrane import membrane_of
from warp_rods.analysis.registry import MEASURES as ALL
from warp_rods.analysis.registry import Measures, take
from warp_rods.analysis.settling import relaxation_time, settling_time
from warp_rods.membranes.surfaces import Surface

__all__ = [
    "MEASURES",
    "bootstrap",
    "curvature_histogram",
    "enrichment",
    "measure",
    "membrane_of",
    "relaxation_time",
    "settling_time",
]
_NAMES = ("curvature_histogram", "enrichment", "settling_time", "relaxation_time")
_ROWS = Measures({name: ALL[name] for name in _NAMES})


def measure(data: xr.Dataset, surface: Surface, *names: str) -> xr.Dataset:
    """Measures of filaments on this membrane by name; all of ``MEASURES`` by default.

    Raises ValueError for an unknown name, listing the known ones.
    """
    chosen = names or _NAMES
    needed = any(_ROWS[name].needs_membrane for name in chosen if name in _ROWS)
    return take(_ROWS, data, chosen, {"surface": surface} if needed else {})


def _of_membrane(name: str, data: xr.Dataset, surface: Surface) -> xr.Dataset:
    return measure(data, surface, name)


MEASURES: dict[str, Callable[[xr.Dataset, Surface], xr.Dataset]] = {
    name: partial(_of_membrane, name) for name in _NAMES
}
"""By name: functions of an ensemble of filaments and its membrane."""

"""The table that ``warp-rods run`` prints at the end: one row per ensemble, from the trajectory."""

from __future__ import annotations

import numpy as np
import xarray as xr
from rich.table import Table

from warp_rods.analysis.described import in_si, without_failed


def summary(data: xr.DataTree, order: list[str]) -> Table:
    """Mean energy and ⟨𝒦⟩ (start → end) or mean speed, largest residuals of the constraints, number of failed rods.

    In SI where the scene has [units]. Failed rods count in the last column only.
    """
    table = Table("ensemble", "rods", "mean energy", "⟨𝒦⟩ or speed", "largest residuals", "failed")
    for name in order:
        d = data[name].to_dataset()
        failed = int((d.status.isel(frame=-1) != 0).sum())
        cells = _cells(without_failed(d)) if failed < d.sizes["rod"] else ("–",) * 3
        table.add_row(name, str(d.sizes["rod"]), *cells, str(failed))
    return table


def _cells(d: xr.Dataset) -> tuple[str, str, str]:
    """Mean energy, ⟨𝒦⟩ or mean speed, and residuals."""
    gauss = _change(d, "gauss", "1/length^2") if "gauss" in d else _speed(d)
    return _change(d, "energy", "force*length") if "energy" in d else "–", gauss, _residual(d)


def _change(d: xr.Dataset, name: str, units: str) -> str:
    """The mean over the rods in the first and in the last frame."""
    factor, unit = in_si(d, units)
    first, last = (factor * float(d[name].isel(frame=frame).mean()) for frame in (0, -1))
    return f"{first:.4g} → {last:.4g}{unit}"


def _speed(d: xr.Dataset) -> str:
    """|r(T) − r(0)|/T of the middle node, averaged over the rods."""
    middle = d.position.isel(node=d.sizes["node"] // 2)
    displacement = middle.isel(frame=-1) - middle.isel(frame=0)
    span = float(d.time[-1] - d.time[0])
    factor, unit = in_si(d, "length/time")
    return f"{factor * float(np.linalg.norm(displacement, axis=-1).mean()) / span:.4g}{unit}" if span > 0 else "–"


def _residual(d: xr.Dataset) -> str:
    names = {"|φ|/|∇φ|": "constraint", "|q·n|": "orthogonality", "Δs": "arc_length"}
    worst = {label: d[name] for label, name in names.items() if name in d}
    return ", ".join(f"{label} {float(values.max()):.1e}" for label, values in worst.items()) or "–"

"""The table that ``warp-rods run`` prints at the end: one row per ensemble, from the trajectory."""

from __future__ import annotations

import numpy as np
import xarray as xr
from rich.table import Table


def summary(data: xr.DataTree, order: list[str]) -> Table:
    """Mean energy and ⟨𝒦⟩ (start → end) or mean speed, largest residuals of the constraints, number of failed rods."""
    table = Table("ensemble", "rods", "mean energy", "⟨𝒦⟩ or speed", "largest residuals", "failed")
    for name in order:
        d = data[name].to_dataset()
        first, last = d.isel(frame=0), d.isel(frame=-1)
        table.add_row(
            name,
            str(d.sizes["rod"]),
            _change(float(first.energy.mean()), float(last.energy.mean())) if "energy" in d else "–",
            _change(float(first.gauss.mean()), float(last.gauss.mean())) if "gauss" in d else _speed(d),
            _residual(d),
            str(int((last.status != 0).sum())),
        )
    return table


def _change(first: float, last: float) -> str:
    return f"{first:.4g} → {last:.4g}"


def _speed(d: xr.Dataset) -> str:
    """|r(T) − r(0)|/T of the middle node, averaged over the rods."""
    middle = d.position.isel(node=d.sizes["node"] // 2)
    displacement = middle.isel(frame=-1) - middle.isel(frame=0)
    span = float(d.time[-1] - d.time[0])
    return f"{float(np.linalg.norm(displacement, axis=-1).mean()) / span:.4g}" if span > 0 else "–"


def _residual(d: xr.Dataset) -> str:
    names = {"|φ|/|∇φ|": "constraint", "|q·n|": "orthogonality", "Δs": "arc_length"}
    worst = {label: d[name] for label, name in names.items() if name in d}
    return ", ".join(f"{label} {float(values.max()):.1e}" for label, values in worst.items()) or "–"

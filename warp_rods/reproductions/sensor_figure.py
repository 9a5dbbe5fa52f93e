"""The figure of curvature sensors: snapshots, energy, dissipation and 𝒦 over time with bands over seeds, settling."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from warp_rods.draw import plots
from warp_rods.membranes.mesh import Mesh

SNAPSHOTS = (0, 3, 25, -1)
"""Frames of the snapshots."""
VIEW = (35.0, 25.0)


def draw(groups: dict[float, xr.Dataset], shown_twist: float, membrane: Mesh) -> Any:
    """Snapshots of the first seed (σ1 = 0 above, ``shown_twist`` below) and four panels of curves for all σ1.

    groups: by σ1. Rods are coloured by elastic energy per length.
    """
    figure = plots.figure(plots.PAGE, 160)
    top, bottom = figure.subfigures(2, 1, squeeze=False, height_ratios=(2.1, 1))[:, 0]
    panels = top.subplots(2, len(SNAPSHOTS))
    shown = {twist: groups[twist].isel(rod=groups[twist]["seed"].to_numpy() == 0) for twist in (0.0, shown_twist)}
    # The energy at the start is much larger and has relaxed by the second snapshot.
    relaxed = [group["energy_density"].isel(frame=SNAPSHOTS[1]).quantile(0.95) for group in shown.values()]
    limits = (0.0, float(max(relaxed)))
    for row, (twist, group) in zip(panels, shown.items(), strict=True):
        for axes, frame in zip(row, SNAPSHOTS, strict=True):
            now = group.isel(frame=frame)
            drawn = plots.tubes(
                axes, now["position"].to_numpy(), now["energy_density"].to_numpy(), radius=0.022, view=VIEW,
                limits=limits, membrane=membrane,
            )  # fmt: skip
            axes.set_title(f"$\\sigma_1$ = {twist:g}, t = {float(now.time):.2f}")
    plots.scale_bar(panels[0, 0], 0.5, "0.5")
    for axes in panels.flat:
        axes.set_ylim(panels[0, 0].get_ylim())
    top.colorbar(drawn, ax=panels, shrink=0.5, extend="max", label="elastic energy per length ($B/\\mathrm{length}^2$)")
    _curves(bottom, groups)
    return figure


def _curves(figure: Any, groups: dict[float, xr.Dataset]) -> None:
    energy, dissipation, gauss, settled = figure.subplots(1, 4)
    for (twist, group), colour in zip(groups.items(), plots.OKABE_ITO, strict=False):
        label = f"$\\sigma_1$ = {twist:g}"
        for axes, name in ((energy, "energy"), (dissipation, "dissipation"), (gauss, "gauss")):
            seeds = group[name].groupby("seed").mean().to_numpy()
            seeds = seeds if seeds.shape[0] == group.sizes["frame"] else seeds.T
            time = group["time"].to_numpy()
            axes.plot(time, seeds.mean(axis=1), color=colour, label=label)
            axes.fill_between(time, seeds.min(axis=1), seeds.max(axis=1), color=colour, alpha=0.25, linewidth=0)
        times = np.sort(group["settling_time"].to_numpy())
        fraction = np.arange(1, len(times) + 1) / len(times)
        finite = np.isfinite(times)
        settled.step(times[finite], fraction[finite], where="post", color=colour, label=label)
    for axes in (energy, dissipation):
        axes.set_yscale("log")
    energy.set_ylabel("mean energy of a protein (B/length)")
    dissipation.set_ylabel("mean dissipation (B²/$\\zeta_\\parallel$length⁵)")
    gauss.set_ylabel("mean $\\mathcal{K}$ at the midpoints (1/length²)")
    gauss.axhline(0.0, color="0.6", linewidth=0.6, linestyle=":")
    settled.set_ylabel("fraction of proteins settled")
    settled.set_ylim(0, 1)
    for axes, name in zip((energy, dissipation, gauss, settled), ("(a)", "(b)", "(c)", "(d)"), strict=True):
        axes.set_xlabel("time ($\\zeta_\\parallel\\,\\mathrm{length}^4/B$)")
        plots.panel_title(axes, name)
    energy.legend(loc="upper right")  # over no line: energies fall at once

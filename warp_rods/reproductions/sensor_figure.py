"""The figure of curvature sensors: pictures in time, energy and 𝒦 with bands over seeds, settling times."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from warp_rods.draw import plots
from warp_rods.membranes.mesh import Mesh

PICTURES = (0, 3, 25, -1)
"""Frames of the pictures."""
VIEW = (35.0, 25.0)


def draw(groups: dict[float, xr.Dataset], pictured: float, membrane: Mesh) -> Any:
    """Achiral above, chiral below, of the first seed, coloured by elastic energy per length; three panels of curves."""
    figure = plots.figure(plots.PAGE, 160)
    top, bottom = figure.subfigures(2, 1, height_ratios=(2.1, 1))
    panels = top.subplots(2, len(PICTURES))
    shown = {twist: groups[twist].isel(rod=groups[twist]["seed"].to_numpy() == 0) for twist in (0.0, pictured)}
    # Only the start has more, and it is gone by the second picture.
    soon = [group["energy_density"].isel(frame=PICTURES[1]).quantile(0.95) for group in shown.values()]
    limits = (0.0, float(max(soon)))
    for row, (twist, group) in zip(panels, shown.items(), strict=True):
        for axes, frame in zip(row, PICTURES, strict=True):
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
    energy, spent, gauss, settled = figure.subplots(1, 4)
    for (twist, group), colour in zip(groups.items(), plots.OKABE_ITO, strict=False):
        label = f"$\\sigma_1$ = {twist:g}"
        for axes, name in ((energy, "energy"), (spent, "dissipation"), (gauss, "gauss")):
            seeds = group[name].groupby("seed").mean().to_numpy()
            seeds = seeds if seeds.shape[0] == group.sizes["frame"] else seeds.T
            time = group["time"].to_numpy()
            axes.plot(time, seeds.mean(axis=1), color=colour, label=label)
            axes.fill_between(time, seeds.min(axis=1), seeds.max(axis=1), color=colour, alpha=0.25, linewidth=0)
        times = np.sort(group["settling_time"].to_numpy())
        share = np.arange(1, len(times) + 1) / len(times)
        finite = np.isfinite(times)
        settled.step(times[finite], share[finite], where="post", color=colour, label=label)
    for axes in (energy, spent):
        axes.set_yscale("log")
    energy.set_ylabel("⟨energy⟩ of a protein (B/length)")
    spent.set_ylabel("⟨dissipation⟩ (B²/$\\zeta_\\parallel$length⁵)")
    gauss.set_ylabel("⟨$\\mathcal{K}$⟩ at the midpoints (1/length²)")
    gauss.axhline(0.0, color="0.6", linewidth=0.6, linestyle=":")
    settled.set_ylabel("share of proteins settled")
    settled.set_ylim(0, 1)
    for axes, name in zip((energy, spent, gauss, settled), ("(a)", "(b)", "(c)", "(d)"), strict=True):
        axes.set_xlabel("time ($\\zeta_\\parallel\\,\\mathrm{length}^4/B$)")
        plots.letter(axes, name)
    settled.legend(loc="lower right")

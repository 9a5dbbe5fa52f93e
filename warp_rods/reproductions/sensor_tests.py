"""The claims that the text makes of curvature sensors, each as a statistic of an ensemble and a test of it."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy import stats

from warp_rods.analysis.sensing import bootstrap
from warp_rods.reproductions.result import Row

LEVEL = 0.01
"""Largest p-value at which a claim counts as borne out."""


def sits_at_the_sign(twist: float, group: xr.Dataset, sign: float, area: float) -> Row:
    """Share of midpoints at the sign of 𝒦 that σ2 is after, against that sign's share of the area: binomial test."""
    gauss = group["gauss"].to_numpy()
    there = int((sign * gauss[-1] > 0).sum())
    test = stats.binomtest(there, gauss.shape[1], area, alternative="greater")
    where = "positive" if sign > 0 else "negative"
    seeds = group["gauss"].isel(frame=-1).groupby("seed").mean()
    return Row(
        f"σ1 = {twist:g}: share at {where} 𝒦 at the end", f"congregate near {where} 𝒦", there / gauss.shape[1],
        f"{area:.3f} of the area; binomial p = {test.pvalue:.1g}; ⟨𝒦⟩ {gauss[0].mean():.2f} → {gauss[-1].mean():.2f} "
        f"± {float(seeds.std(ddof=1)):.2f} over seeds", bool(test.pvalue < LEVEL),
    )  # fmt: skip


def median_settling(twist: float, group: xr.Dataset) -> Row:
    """Median of the times from which midpoints stay where they end, with its bootstrap interval."""
    found, late = bootstrap(group["settling_time"], np.nanmedian), float(np.isinf(group["settling_time"]).mean())
    interval = f"68 % of bootstraps {float(found.low):.2f}–{float(found.high):.2f}"
    reading = f"within 0.1 L of the end; {interval}; {late:.0%} not settled"
    return Row(f"σ1 = {twist:g}: median settling time", "", float(found.value), reading)


def settle_sooner(twist: float, chiral: xr.Dataset, achiral: xr.Dataset) -> Row:
    """Chance that a chiral protein settles before an achiral one: Mann–Whitney test, which bears inf."""
    times = [group["settling_time"] for group in (achiral, chiral)]
    test = stats.mannwhitneyu(times[1], times[0], alternative="less")
    sooner = 1 - float(test.statistic) / (times[0].size * times[1].size)
    by_seed = [
        float(np.median(times[1][chiral.seed == seed])) < float(np.median(times[0][achiral.seed == seed]))
        for seed in np.unique(chiral.seed)
    ]
    said, name = "chiral quickly, achiral much more slowly", f"chance that σ1 = {twist:g} settles before σ1 = 0"
    medians = f"medians sooner in {sum(by_seed)} of {len(by_seed)} seeds"
    reading = f"Mann–Whitney, one-sided p = {test.pvalue:.1g}; {medians}"
    return Row(name, said, sooner, reading, bool(test.pvalue < LEVEL))


def comes_to_rest(twist: float, chiral: xr.Dataset, achiral: xr.Dataset) -> Row:
    """Median dissipation at the end, chiral over achiral: what is left of the way, whenever a run ends."""
    ends = [group["dissipation"].isel(frame=-1).to_numpy() for group in (chiral, achiral)]
    test = stats.mannwhitneyu(*ends, alternative="less")
    ratio = float(np.median(ends[0]) / np.median(ends[1]))
    said, reading = "chiral quickly, achiral much more slowly", f"Mann–Whitney, one-sided p = {test.pvalue:.1g}"
    name = f"median dissipation at the end, σ1 = {twist:g} over σ1 = 0"
    return Row(name, said, ratio, reading, bool(ratio < 1 and test.pvalue < LEVEL))


def more_robust(twist: float, chiral: xr.Dataset, achiral: xr.Dataset) -> Row:
    """Spread of 𝒦 under the midpoints at the end, chiral over achiral: Brown–Forsythe test."""
    ends = [group["gauss"].isel(frame=-1).to_numpy() for group in (chiral, achiral)]
    ratio = float(np.std(ends[0]) / np.std(ends[1]))
    p = float(stats.levene(*ends, center="median").pvalue)
    said = "chirality can increase the robustness"
    reading = f"chapter 6; standard deviations; Brown–Forsythe p = {p:.1g}"
    name = f"spread of the final 𝒦, σ1 = {twist:g} over σ1 = 0"
    return Row(name, said, ratio, reading, bool(ratio < 1 and p < LEVEL))

"""The statements of the text on curvature sensors, each as a statistic of an ensemble with a significance test."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy import stats

from warp_rods.analysis.sensing import bootstrap
from warp_rods.reproductions.result import Comparison

SIGNIFICANCE_LEVEL = 0.01
"""A statement counts as supported where the p-value of its test is below this."""


def share_at_preferred_curvature(twist: float, group: xr.Dataset, sign: float, area: float) -> Comparison:
    """Share of midpoints where 𝒦 has the preferred ``sign``, against the share of the ``area`` there: binomial test."""
    gauss = group["gauss"].to_numpy()
    there = int((sign * gauss[-1] > 0).sum())
    test = stats.binomtest(there, gauss.shape[1], area, alternative="greater")
    where = "positive" if sign > 0 else "negative"
    seeds = group["gauss"].isel(frame=-1).groupby("seed").mean()
    return Comparison(
        f"σ1 = {twist:g}: share at {where} 𝒦 at the end", f"congregate near {where} 𝒦", there / gauss.shape[1],
        f"{area:.3f} of the area; binomial p = {test.pvalue:.1g}; ⟨𝒦⟩ {gauss[0].mean():.2f} → {gauss[-1].mean():.2f} "
        f"± {float(seeds.std(ddof=1)):.2f} over seeds", bool(test.pvalue < SIGNIFICANCE_LEVEL),
    )  # fmt: skip


def median_settling_time(twist: float, group: xr.Dataset) -> Comparison:
    """Median time from which a midpoint stays near its final place, with a bootstrap interval."""
    found = bootstrap(group["settling_time"], np.nanmedian)
    unsettled = float(np.isinf(group["settling_time"]).mean())
    interval = f"68 % of bootstraps {float(found.low):.2f}–{float(found.high):.2f}"
    reading = f"within 0.1 L of the final place; {interval}; {unsettled:.0%} not settled"
    return Comparison(f"σ1 = {twist:g}: median settling time", "", float(found.value), reading)


def settling_order(twist: float, chiral: xr.Dataset, achiral: xr.Dataset) -> Comparison:
    """Probability that a chiral protein settles before an achiral one: Mann–Whitney test, which allows inf."""
    times = [group["settling_time"] for group in (achiral, chiral)]
    test = stats.mannwhitneyu(times[1], times[0], alternative="less")
    probability = 1 - float(test.statistic) / (times[0].size * times[1].size)
    by_seed = [
        float(np.median(times[1][chiral.seed == seed])) < float(np.median(times[0][achiral.seed == seed]))
        for seed in np.unique(chiral.seed)
    ]
    published = "chiral quickly, achiral much more slowly"
    name = f"probability that σ1 = {twist:g} settles before σ1 = 0"
    medians = f"smaller median in {sum(by_seed)} of {len(by_seed)} seeds"
    reading = f"Mann–Whitney, one-sided p = {test.pvalue:.1g}; {medians}"
    return Comparison(name, published, probability, reading, bool(test.pvalue < SIGNIFICANCE_LEVEL))


def final_dissipation(twist: float, chiral: xr.Dataset, achiral: xr.Dataset) -> Comparison:
    """Median dissipation at the end, chiral over achiral: how far from equilibrium they are. Mann–Whitney test."""
    ends = [group["dissipation"].isel(frame=-1).to_numpy() for group in (chiral, achiral)]
    test = stats.mannwhitneyu(*ends, alternative="less")
    ratio = float(np.median(ends[0]) / np.median(ends[1]))
    published, reading = "chiral quickly, achiral much more slowly", f"Mann–Whitney, one-sided p = {test.pvalue:.1g}"
    name = f"median dissipation at the end, σ1 = {twist:g} over σ1 = 0"
    return Comparison(name, published, ratio, reading, bool(ratio < 1 and test.pvalue < SIGNIFICANCE_LEVEL))


def curvature_spread(twist: float, chiral: xr.Dataset, achiral: xr.Dataset) -> Comparison:
    """Standard deviation of 𝒦 at the midpoints at the end, chiral over achiral: Brown–Forsythe test."""
    ends = [group["gauss"].isel(frame=-1).to_numpy() for group in (chiral, achiral)]
    ratio = float(np.std(ends[0]) / np.std(ends[1]))
    p = float(stats.levene(*ends, center="median").pvalue)
    published = "chirality can increase the robustness"
    reading = f"chapter 6; standard deviations; Brown–Forsythe p = {p:.1g}"
    name = f"spread of the final 𝒦, σ1 = {twist:g} over σ1 = 0"
    return Comparison(name, published, ratio, reading, bool(ratio < 1 and p < SIGNIFICANCE_LEVEL))

"""What filaments sense of their membrane: where they gather, and when they have settled.

A measure takes one ensemble of a trajectory (``open_run(dir)[name].to_dataset()``) and gives variables with
units and source. Failed rods are left out. One that needs the membrane itself takes it too (``membrane_of``).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr

from warp_rods.errors import RunFolderError
from warp_rods.membranes.mesh import area_below, area_mean, curvatures, triangulate
from warp_rods.membranes.surfaces import Surface, make
from warp_rods.scene.scene import Scene

_ZERO = 1e-9  # a 𝒦 of less than this share of the largest squared principal curvature counts as none


def measure(data: xr.Dataset, surface: Surface, *names: str) -> xr.Dataset:
    """The measures of these names (all of ``MEASURES`` where none is given) of an ensemble, in one Dataset.

    Raises ValueError where a name is not known, listing those that are.
    """
    if unknown := [name for name in names if name not in MEASURES]:
        raise ValueError(f"{', '.join(unknown)}: not a measure of filaments; there are {', '.join(MEASURES)}")
    return xr.merge([MEASURES[name](data, surface) for name in names or MEASURES], compat="no_conflicts")


def membrane_of(run: xr.DataTree) -> Surface:
    """The membrane of a run opened by ``open_run``; raises RunFolderError where its scene has none."""
    surface = Scene.parse(run.attrs["scene"]).surface
    if surface is None:
        raise RunFolderError("The scene of this run has no [surface], so that there is no membrane to sense.")
    return make(surface.kind, surface.parameters)


def _at_rest(surface: Surface) -> None:
    """Raises ValueError for a moving membrane, whose area is another in each frame."""
    if surface.moving:
        raise ValueError("this membrane moves: give surface.at(t), and the frames of that time")


def curvature_histogram(data: xr.Dataset, surface: Surface, bins: int | Sequence[float] = 21) -> xr.Dataset:
    """How the Gaussian curvatures under the midpoints are spread, against how they are over the area.

    ``bins``: how many, over all curvatures that there are, or their edges (1/length²).
    Gives ``gauss_share(frame, bin)`` of the filaments and ``gauss_area_share(bin)`` of the area, in bins from
    ``gauss_low(bin)`` to ``gauss_high(bin)``, and ``gauss_mean(frame)``, ``gauss_area_mean``. Where
    edges leave values out, the shares add up to less than one.
    """
    _at_rest(surface)
    mesh = triangulate(surface)
    over_area, sampled = curvatures(surface, mesh.points).gaussian, _gauss(data)
    edges = _edges(np.concatenate([over_area, sampled.values[np.isfinite(sampled.values)]]), bins)
    counts = np.array([np.histogram(now[np.isfinite(now)], edges)[0] for now in sampled.values])
    sound = np.isfinite(sampled.values).sum(axis=1, keepdims=True)
    shares = np.divide(counts, sound, out=np.full(counts.shape, np.nan), where=sound > 0)
    per_area = {"units": "1/length^2", "source": "K11 K22 − K12²"}
    variables = {
        "gauss_share": (("frame", "bin"), shares, _said("1", "share of the filaments in the bin")),
        "gauss_area_share": ("bin", np.diff(area_below(mesh, over_area, edges)), _said("1", "share of area")),
        "gauss_mean": sampled.mean("rod").assign_attrs(per_area, long_name="mean 𝒦 at the midpoints"),
        "gauss_area_mean": ((), area_mean(mesh, over_area), {**per_area, "long_name": "mean 𝒦 of the area"}),
    }
    limits = {"gauss_low": ("bin", edges[:-1], per_area), "gauss_high": ("bin", edges[1:], per_area)}
    return xr.Dataset(variables, coords={"time": data.time, **limits})


def enrichment(data: xr.Dataset, surface: Surface) -> xr.Dataset:
    """How much denser filaments are where 𝒦 > 0, and where 𝒦 < 0, than if they were spread uniformly.

    ``enrichment(frame, side)``: the share of the midpoints on that side over its share of the area (NaN where
    there is none), with its bootstrap interval ``enrichment_low``, ``enrichment_high``; ``area_share(side)``.
    Where all filaments are on one side, no resample shows another: the interval has no width.
    """
    _at_rest(surface)
    mesh = triangulate(surface)
    over_area, gauss = curvatures(surface, mesh.points), _gauss(data)
    zero = _ZERO * float(np.max(over_area.principal**2))
    below, above = area_below(mesh, over_area.gaussian, np.array([-zero, zero]))
    sides = {"side": ["positive", "negative"]}
    area = xr.DataArray([1 - above, below], sides, attrs=_said("1", "share of the area"))
    there = xr.concat([gauss > zero, gauss < -zero], area.side).where(gauss.notnull())
    found = bootstrap(there / area.where(area > 0), np.nanmean)
    labels = {"value": "", "low": ", lower bound", "high": ", upper bound"}
    names = {"value": "enrichment", "low": "enrichment_low", "high": "enrichment_high"}
    for key, label in labels.items():
        found[key].attrs = _said("1", f"density of filaments over that of uniform ones{label}")
    return found.rename(names).transpose("frame", "side").assign(area_share=area)


def settling_time(data: xr.Dataset, distance: float = 0.1, quiet: float = 0.2) -> xr.Dataset:
    """When each filament's midpoint last came within ``distance`` rod lengths of where it ends.

    ``settling_time(rod)`` is the first saved time from which it stays there. It is inf where that leaves less
    than the last share ``quiet`` of the run, for a filament that drifts comes near its end late, whenever the
    run ends; so a median holds as long as fewer than half are inf. NaN for failed rods.
    """
    middle = data.position.isel(node=data.sizes["node"] // 2)
    away = np.sqrt(((middle - _last(middle)) ** 2).sum("axis")) > distance * data.length
    time = _last_true(away, data.time)
    latest = float(data.time[-1]) - quiet * _span(data)
    time = time.where(time <= latest, np.inf).where(_last(data.status) == 0)
    said = f"from when on the midpoint stays within {distance:g} lengths of the end; inf: after {latest:g}"
    return xr.Dataset({"settling_time": time.assign_attrs(_said("time", said))})


def relaxation_time(data: xr.Dataset, fraction: float = 0.95) -> xr.Dataset:
    """When each filament has released ``fraction`` of its energy, elastic and steric, for good.

    ``relaxation_time(rod)`` is the first saved time from which the energy stays within the rest of its
    largest excess over the end. It is inf where the dissipation at the end would, in another run as long,
    spend more than that rest; NaN for failed rods. Nearly all the energy of a random start is bending,
    released long before a filament has found its place: that search shows in the last parts, with a
    ``fraction`` of 0.9999.
    """
    energy = data.energy + data.steric_energy
    excess = energy - _last(energy)
    rest = (1 - fraction) * excess.max("frame")
    time = _last_true(np.abs(excess) > rest, data.time)
    still = _last(data.dissipation) * _span(data) > rest
    time = time.where(~still, np.inf).where(_last(data.status) == 0)
    said = f"from when on {fraction:g} of the energy is released; inf: still dissipating more than the rest"
    return xr.Dataset({"relaxation_time": time.assign_attrs(_said("time", said, "energy of (5.28)"))})


MEASURES: dict[str, Callable[[xr.Dataset, Surface], xr.Dataset]] = {
    "curvature_histogram": curvature_histogram,
    "enrichment": enrichment,
    "settling_time": lambda data, surface: settling_time(data),
    "relaxation_time": lambda data, surface: relaxation_time(data),
}
"""Every measure by its name: an ensemble of filaments and its membrane → its variables."""


def bootstrap(
    values: xr.DataArray,
    statistic: Callable[..., np.ndarray] = np.nanmedian,
    resamples: int = 1000,
    level: float = 0.68,
    seed: int = 0,
) -> xr.Dataset:
    """A statistic over the rods, ``value``, and its percentile interval of that level, ``low`` to ``high``.

    ``values`` have a dim ``rod``, which is drawn with replacement; ``statistic(array, axis=0)`` reduces it
    and has to bear NaN for failed rods and inf for those that did not settle. One seed gives one interval.
    """
    rods = values.transpose("rod", ...)
    rng, count = np.random.default_rng(seed), rods.sizes["rod"]
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "All-NaN|Mean of empty", RuntimeWarning)  # NaN says it
        whole = np.asarray(statistic(rods.values, axis=0))
        drawn = [statistic(rods.values[rng.integers(count, size=count)], axis=0) for _ in range(resamples)]
    ordered = np.sort(drawn, axis=0)  # an order statistic, where interpolation would fail on inf
    tail = round((1 - level) / 2 * (resamples - 1))
    kept = rods.isel(rod=0, drop=True)
    bounds = {"value": whole, "low": ordered[tail], "high": ordered[-1 - tail]}
    return xr.Dataset({name: kept.copy(data=bound) for name, bound in bounds.items()})


def _gauss(data: xr.Dataset) -> xr.DataArray:
    """𝒦 at the midpoints [frame, rod], NaN for failed rods."""
    return data.gauss.where(data.status == 0)


def _edges(gauss: np.ndarray, bins: int | Sequence[float]) -> np.ndarray:
    """Edges of bins that hold all of the values; a constant 𝒦 known to round-off is in the middle of them."""
    low, high = gauss.min(), gauss.max()
    slack = 1e-6 * max(abs(low), abs(high))
    return np.histogram_bin_edges(gauss, bins, (low - slack, high + slack))


def _last_true(condition: xr.DataArray, time: xr.DataArray) -> xr.DataArray:
    """The first time [rod] from which on a condition [frame, rod] never holds; it does not at the end."""
    frames = condition.transpose("frame", "rod").values
    after = np.where(frames.any(axis=0), len(frames) - np.argmax(frames[::-1], axis=0), 0)
    return xr.DataArray(time.values[after], dims="rod")


def _last(values: xr.DataArray) -> xr.DataArray:
    return values.isel(frame=-1).drop_vars("time")


def _span(data: xr.Dataset) -> float:
    return float(data.time[-1] - data.time[0])


def _said(units: str, long_name: str, source: str = "") -> dict[str, str]:
    return {"units": units, "long_name": long_name, **({"source": source} if source else {})}

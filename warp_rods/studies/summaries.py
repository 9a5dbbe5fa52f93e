"""What a study keeps of each point: the table ``SUMMARIES``, and whether the motion had settled.

To add one, give ``SUMMARIES`` a row. Every other measure of ``warp_rods.measures()`` can be named in a sweep, too: its
last frame, and the mean over the rods of the point.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.analysis.averages import commonest
from warp_rods.analysis.described import described
from warp_rods.analysis.listing import MEMBRANE, Measure
from warp_rods.analysis.motion_class import FEWEST, STRAIGHT
from warp_rods.analysis.registry import FAILED, IN_STUDIES, MEASURES, named, take
from warp_rods.analysis.settling import settling_time
from warp_rods.analysis.shape import mode_coefficients

__all__ = [
    "FEWEST_IN_QUARTER",
    "SETTLED",
    "SUMMARIES",
    "Summary",
    "each_point",
    "frames_in_quarters",
    "of_all",
    "settled",
    "summary_of",
]

BLOCK = 64
"""Rods that are measured together, always as many: round-off of sums and products depends on the shape of arrays."""
CHANGE = 0.05
"""Largest change of the modes of a settled motion from the third to the last quarter of the run, over their size."""
MOST = 0.9
"""Share of the rods of a point that must have settled."""
FEWEST_IN_QUARTER = FEWEST // 2
"""Frames of a quarter of the run with which it can be told."""
SETTLED = (
    f"1 where the motion had settled: for {MOST:.0%} of the rods the root mean square of the beam modes changed by "
    f"less than {CHANGE:.0%} from the third to the last quarter of the run; filaments kept place in its last fifth"
)
OF_SETTLED = {
    "filaments": {"gauss", "position", "length"},
    "swimmers": {"strain", "activity"},
    "cosserat": {"strain"},
}
"""Variables with which that is told, by the kind of rods."""


def _late_rms(found: xr.DataArray) -> xr.DataArray:
    """Root mean square over the later half of the run."""
    late = found.isel(frame=slice(found.sizes["frame"] // 2, None))
    return (late**2).mean("frame") ** 0.5


def _last(found: xr.DataArray) -> xr.DataArray:
    return found.isel(frame=-1).drop_vars("time", errors="ignore")


def _midpoint_gauss(data: xr.Dataset) -> xr.DataArray:
    """Gaussian curvature at the midpoint (frame, rod)."""
    units, words = "1/length^2", "Gaussian curvature at the midpoints"
    return described(data, ("frame", "rod"), data["gauss"].to_numpy(), units, words, "K11 K22 − K12²")


def _positive(data: xr.Dataset) -> xr.DataArray:
    """Whether the Gaussian curvature at the midpoint is positive (frame, rod)."""
    share = (data["gauss"].to_numpy() > 0).astype(float)
    return described(
        data, ("frame", "rod"), share, "1", "share of the filaments at positive curvature", "K11 K22 > K12²"
    )


@dataclass(frozen=True)
class Summary:
    """A measure of a point: a row of the table of measures, and how its values over frames and rods become one."""

    measure: Measure
    options: Mapping[str, Any] = field(default_factory=dict)
    """Options of the measure; "late" stands for the middle of the run."""
    over_frames: Callable[[xr.DataArray], xr.DataArray] = _last
    over_rods: Callable[..., Any] = np.mean
    settled: bool = True
    """Whether it assumes that the motion has settled."""

    @property
    def needs(self) -> set[str]:
        """Variables of the trajectory."""
        return {*self.measure.needs, "status"} - {MEMBRANE}

    def of(self, name: str, data: Any, surface: Any) -> xr.Dataset:
        """The measure of an ensemble, or a whole run: without frames."""
        time = np.asarray(next(iter(data.children.values()))["time"] if isinstance(data, xr.DataTree) else data["time"])
        options = {key: (time[0] + time[-1]) / 2 if value == "late" else value for key, value in self.options.items()}
        options |= {"surface": surface} if self.measure.needs_membrane else {}
        found = take({name: self.measure}, data, [name], options)
        last = xr.Dataset({k: self.over_frames(v) if "frame" in v.dims else v for k, v in found.data_vars.items()})
        return last if "rod" in last.dims else _with_edges(last, data, name)


def _with_edges(found: xr.Dataset, data: Any, name: str) -> xr.Dataset:
    """A measure whose own coordinates beside labels, such as edges of bins, are variables: each point has its own."""
    groups = data.children.values() if isinstance(data, xr.DataTree) else [data]
    known = {*found.dims}.union(*(group.coords for group in groups))
    own = [key for key, values in found.coords.items() if key not in known and values.dims]
    return found.reset_coords(own).assign(
        {key: found[key].reset_coords(drop=True).assign_attrs(measure=name) for key in own}
    )


_TIMES = {"settling_time", "relaxation_time"}
SUMMARIES: dict[str, Summary] = {
    "speed": Summary(MEASURES["speed"], {"since": "late"}),
    "class": Summary(MEASURES["shape_class"]),
    "period": Summary(MEASURES["period"]),
    "modes": Summary(MEASURES["mode_coefficients"], {"twist_free": True}, over_frames=_late_rms),
    "gauss": Summary(Measure(_midpoint_gauss, "filaments", "1/length^2", ("gauss",))),
    "positive_share": Summary(Measure(_positive, "filaments", "1", ("gauss",))),
    **{name: Summary(MEASURES[name], over_rods=np.median, settled=False) for name in sorted(_TIMES)},
}
"""By name in a sweep. ``speed``, ``class``, ``period`` and ``modes`` (root mean square of the twist-free bending on the
beam modes) are those of the later half of the run."""
SUMMARIES |= {name: SUMMARIES[short] for short, name in IN_STUDIES.items()}


def summary_of(name: str) -> Summary:
    """The row with this name, or one of the table of measures; raises ValueError with the known names."""
    if name in SUMMARIES:
        return SUMMARIES[name]
    rows = {key: row.measure for key, row in SUMMARIES.items()}
    return Summary(named({**rows, **MEASURES}, name))


def each_point(name: str, summary: Summary, data: Any, points: int, surface: Any) -> dict[str, xr.DataArray]:
    """The variables of a summary at each of so many points [point, …], whose rods are equal parts of ``data``, in turn.

    ``data``: an ensemble, or a run for a swarm. NaN, or "failed", where no rod of a point is left.
    """
    if isinstance(data, xr.DataTree):
        return _stacked([_or_nothing(name, summary, _part(data, points, p), surface) for p in range(points)])
    rods = data.sizes["rod"]
    sound = np.flatnonzero(data["status"].isel(frame=-1).to_numpy() == 0)
    found = None
    if summary.measure.of != "swarm" and len(sound):
        found = _in_blocks(lambda part: summary.of(name, part, surface), data, sound)
    if found is None:
        return _stacked([_or_nothing(name, summary, _part(data, points, p), surface) for p in range(points)])
    return {str(key): _over_rods(values, sound, rods, points, summary) for key, values in found.data_vars.items()}


def _part(data: Any, points: int, point: int) -> Any:
    """The rods of a point."""
    if isinstance(data, xr.DataTree):
        return xr.DataTree.from_dict({k: _part(g.to_dataset(), points, point) for k, g in data.children.items()})
    count = data.sizes["rod"] // points
    return data.isel(rod=slice(point * count, (point + 1) * count))


def _or_nothing(name: str, summary: Summary, data: Any, surface: Any) -> xr.Dataset | None:
    """The measure of a group of rods; None where none is left."""
    groups = data.children.values() if isinstance(data, xr.DataTree) else [data]
    left = any((group["status"].isel(frame=-1) == 0).any() for group in groups)
    return summary.of(name, data, surface) if left else None


def _stacked(found: list[xr.Dataset | None]) -> dict[str, xr.DataArray]:
    """Values at points, NaN or "failed" where there are none; raises ValueError where their labels differ."""
    some = next((one for one in found if one is not None), None)
    if some is None:
        return {}
    nothing = some.map(_nothing_like, keep_attrs=True)
    each = [nothing if one is None else one for one in found]
    whole = xr.concat(each, "point", combine_attrs="override", join="exact")
    return {str(key): values.transpose("point", ...) for key, values in whole.data_vars.items()}


def _nothing_like(values: xr.DataArray) -> xr.DataArray:
    words = values.dtype.kind in "UO"
    return xr.full_like(values, FAILED if words else np.nan, dtype=object if words else float)


def _in_blocks(
    function: Callable[[xr.Dataset], xr.Dataset], data: xr.Dataset, rods: np.ndarray
) -> xr.Dataset | None:  # fmt: skip
    """A function of rods that do not concern each other, of blocks of the same number; None if it is one of groups."""
    found = []
    for first in range(0, len(rods), BLOCK):
        part = rods[first : first + BLOCK]
        block = np.concatenate([part, np.full(BLOCK - len(part), part[-1])])
        values = function(data.isel(rod=block)).drop_vars("rod", errors="ignore")
        if "rod" not in values.dims:
            return None
        found.append(values.isel(rod=slice(0, len(part))))
    return xr.concat(found, "rod", combine_attrs="override", data_vars="minimal", coords="minimal", compat="override")


def _over_rods(values: xr.DataArray, sound: np.ndarray, rods: int, points: int, summary: Summary) -> xr.DataArray:
    """Values [point, …] from those of the sound rods [rod, …]."""
    values = values.transpose("rod", ...)
    words = values.dtype.kind in "UO"
    shape, of_point = values.shape[1:], sound // (rods // points)
    whole = np.full((points, *shape), FAILED if words else np.nan, dtype=object if words else float)
    given = values.to_numpy()
    for point in np.unique(of_point):
        mine = given[of_point == point]
        whole[point] = commonest(mine) if words else summary.over_rods(mine, axis=0)
    return xr.DataArray(whole, dims=("point", *values.dims[1:]), coords=_without_rod(values), attrs=values.attrs)


def _without_rod(values: xr.DataArray) -> dict[Any, Any]:
    return {key: c for key, c in values.coords.items() if "rod" not in c.dims and set(c.dims) <= set(values.dims)}


def settled(data: xr.Dataset, points: int) -> np.ndarray:
    """Whether the motion of each point had settled [point]: 1 or 0, −1 where it cannot be told. See ``SETTLED``."""
    rods, time = data.sizes["rod"], data["time"].to_numpy()
    sound = np.flatnonzero(data["status"].isel(frame=-1).to_numpy() == 0)
    late = frames_in_quarters(time)
    if not len(sound) or min(map(len, late)) < FEWEST_IN_QUARTER:
        return np.full(points, -1, dtype=np.int8)
    rule = _in_place if "gauss" in data else lambda part: _steady_modes(part, late)
    good = np.zeros(rods)
    rods_settled = _in_blocks(lambda part: xr.Dataset({"good": ("rod", rule(part))}), data, sound)
    assert rods_settled is not None
    good[sound] = rods_settled["good"]
    lost = np.ones(rods)
    lost[sound] = 0
    left = (1 - lost).reshape(points, -1).sum(axis=1)
    share = good.reshape(points, -1).sum(axis=1) / np.maximum(left, 1)
    return np.where(left == 0, -1, share >= MOST).astype(np.int8)


def of_all(told: Sequence[np.ndarray]) -> np.ndarray:
    """``settled`` of all ensembles together [point]: 0 where one had not settled, else −1 where it cannot be told."""
    each = np.array(told)
    return np.where((each == 0).any(axis=0), 0, each.min(axis=0))


def frames_in_quarters(time: np.ndarray) -> list[np.ndarray]:
    """The frames of the third and of the last quarter of a run, by the times of all."""
    first, last = time[0], time[-1]
    at = [first + share * (last - first) for share in (0.5, 0.75, 1.0)]
    return [np.flatnonzero((time >= a) & (time <= b)) for a, b in itertools.pairwise(at)]


def _in_place(data: xr.Dataset) -> np.ndarray:
    return np.isfinite(settling_time(data)["settling_time"].to_numpy())


def _steady_modes(data: xr.Dataset, quarters: list[np.ndarray]) -> np.ndarray:
    """Whether the modes are as large in both quarters [rod]; straight rods must not bend more and more."""
    a = mode_coefficients(data, twist_free=True).transpose("frame", "rod", "component", "mode").to_numpy()
    before, after = (np.sqrt((a[frames] ** 2).mean(axis=0)).reshape(a.shape[1], -1) for frames in quarters)
    size, change = np.linalg.norm(after, axis=1), np.linalg.norm(after - before, axis=1)
    fades = (size < STRAIGHT) & (size <= (1 + CHANGE) * np.linalg.norm(before, axis=1))
    return (change <= CHANGE * size) | fades

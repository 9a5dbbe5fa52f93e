"""Diagrams of studies: a measure over one swept key, or over two; functions ``(axes, data, name)``.

``data``: results of a study whose dimensions are the swept keys drawn and ``seed``. Numbers are means over the seeds,
words the commonest, and labels say so. Failed and lost points are crosses, points that had not settled are open
circles, those of which it cannot be told open squares.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from warp_rods.analysis.averages import MISSING, mean_or_commonest
from warp_rods.analysis.motion_class import CLASSES
from warp_rods.draw.labels import BAND, BLUE, plain_numbers
from warp_rods.draw.labels import label as label_of
from warp_rods.draw.style import OKABE_ITO
from warp_rods.values import shortened

__all__ = ["CLASS_COLOURS", "COMPUTED", "SEED", "classes_in", "colour_of", "diagram", "over_how_many", "stride_of"]

SEED = "seed"
COMPUTED = 1
FEW_DECADES = 30.0
"""Ratio of the ends of a logarithmic axis up to which numbers between powers of ten are written."""
GREY = "0.75"
CLASS_COLOURS = dict(zip(CLASSES, OKABE_ITO, strict=False)) | {"irregular": GREY}
"""Colours of the classes of motion; other words get those that are left."""
CROSS: dict[str, Any] = {"marker": "x", "color": "red", "linestyle": "none", "markersize": 2.5, "markeredgewidth": 0.8}
OPEN: dict[str, Any] = {"marker": "o", "color": "black", "linestyle": "none", "markerfacecolor": "white"}
UNTOLD = OPEN | {"marker": "s"}
DOT: dict[str, Any] = {"marker": "o", "color": "black", "linestyle": "none", "markeredgewidth": 0}


def diagram(axes: Any, data: xr.Dataset, name: str) -> Any:
    """A measure over the one or two keys that have several values; returns what a colour bar needs, or None."""
    keys = [str(dim) for dim in data["state"].dims if dim != SEED]
    values = over_seeds(data[name])
    if len(keys) == 1:
        (_words_on_a_line if _is_words(values) else _curve)(axes, data, values, keys[0])
        return None
    return _map(axes, data, values, keys)


def over_seeds(values: xr.DataArray) -> xr.DataArray:
    """The mean of a number over the seeds, the commonest of words, of those that were measured."""
    values = values.transpose(..., SEED)
    return values.isel({SEED: 0}).copy(data=mean_or_commonest(values.to_numpy()))


def over_how_many(data: xr.Dataset, name: str) -> str:
    """What is drawn of several seeds, such as "mean of 5 seeds"; empty for one."""
    count = data.sizes[SEED]
    return f"{'commonest' if _is_words(data[name]) else 'mean'} of {count} seeds" if count > 1 else ""


def _is_words(values: xr.DataArray) -> bool:
    return values.dtype.kind in "UO"


def classes_in(values: xr.DataArray) -> list[str]:
    """The words that occur, classes of motion in their order."""
    found = set(np.unique(values.to_numpy().astype(str))) - set(MISSING)
    return [word for word in CLASS_COLOURS if word in found] + sorted(found - set(CLASS_COLOURS))


def colour_of(word: str, words: list[str]) -> str:
    """The colour of a word."""
    others = [w for w in words if w not in CLASS_COLOURS]
    left = [c for c in OKABE_ITO if c not in [CLASS_COLOURS[w] for w in words if w in CLASS_COLOURS]] or list(OKABE_ITO)
    return CLASS_COLOURS[word] if word in CLASS_COLOURS else left[others.index(word) % len(left)]


class Marks:
    """Which points are computed, not settled, perhaps not settled, and failed."""

    def __init__(self, data: xr.Dataset, assumes: bool):
        state, settled = data["state"], data["settled"]
        good = state == COMPUTED
        self.failed = (state > COMPUTED).any(SEED).to_numpy()
        self.computed = good.any(SEED).to_numpy()
        loose, untold = ((good & assumes & (settled == code)).any(SEED).to_numpy() for code in (0, -1))
        self.open = loose & ~self.failed
        self.untold = untold & ~loose & ~self.failed
        self.sound = self.computed & ~self.open & ~self.untold & ~self.failed


def _marks(data: xr.Dataset, values: xr.DataArray) -> Marks:
    return Marks(data, "settled" in str(values.attrs.get("ancillary_variables", "")))


def _places(data: xr.Dataset, key: str) -> tuple[np.ndarray, bool, list[str]]:
    """Where the values of a key are on its axis, whether it is logarithmic, and labels where they are no numbers."""
    values = data[key].to_numpy()
    if values.dtype.kind in "UO":
        return np.arange(len(values), dtype=float), False, [shortened(str(value)) for value in values]
    return values.astype(float), data[key].attrs.get("scale") == "log", []


def _set_axis(axis: Any, data: xr.Dataset, key: str) -> None:
    """Scale, ticks and label of an axis."""
    places, log, labels = _places(data, key)
    axis.set_label_text(key)
    if log and max(places) < FEW_DECADES * min(places):
        plain_numbers(axis)
    if labels:
        axis.set_ticks(places, labels)


def _curve(axes: Any, data: xr.Dataset, values: xr.DataArray, key: str) -> None:
    """Mean, smallest and largest over the seeds, against one key."""
    places, log, labels = _places(data, key)
    marks, name = _marks(data, values), values.name
    each = data[name].where(np.isfinite(data[name])).transpose(key, SEED).to_numpy()
    known = np.isfinite(values.to_numpy())
    with np.errstate(all="ignore"):
        low, high = (
            f(each, axis=1, initial=e, where=np.isfinite(each)) for f, e in ((np.min, np.inf), (np.max, -np.inf))
        )
    if each.shape[1] > 1:
        axes.fill_between(places[known], low[known], high[known], color=BLUE, label="range over the seeds", **BAND)
    axes.plot(places[known], values.to_numpy()[known], "-" if not labels else "", color=BLUE)
    bottom = axes.get_ylim()[0]
    _points(axes, marks, places, np.where(known, values.to_numpy(), bottom), color=BLUE)
    axes.set_ylabel("\n".join(filter(None, [label_of(values), over_how_many(data, str(name))])))
    axes.set_xscale("log" if log else "linear")
    _set_axis(axes.xaxis, data, key)


def _words_on_a_line(axes: Any, data: xr.Dataset, values: xr.DataArray, key: str) -> None:
    """A row for each word, with the points of that class."""
    places, log, _ = _places(data, key)
    words, marks = classes_in(values), _marks(data, values)
    given = values.to_numpy().astype(str)
    rows = np.array([words.index(word) if word in words else len(words) for word in given], dtype=float)
    for word in words:
        here = (given == word) & marks.computed
        axes.plot(places[here], rows[here], "s", color=colour_of(word, words), markersize=5)
    _points(axes, marks, places, rows, size=1.5)
    axes.set_yticks(range(len(words)), words)
    axes.set_ylabel(over_how_many(data, str(values.name)))
    axes.set_ylim(-0.5, max(len(words) - 0.5, 0.5))
    axes.set_xscale("log" if log else "linear")
    _set_axis(axes.xaxis, data, key)


def _points(axes: Any, marks: Marks, x: np.ndarray, y: np.ndarray, size: float = 3.0, color: str = "black") -> None:
    """The points of a diagram, by what became of them."""
    kinds = (
        (marks.sound, DOT | {"color": color}, None),
        (marks.open, OPEN, "not settled"),
        (marks.untold, UNTOLD, "unknown if settled"),
        (marks.failed, CROSS, "failed or lost"),
    )
    for which, style, words in kinds:
        if which.any():
            edge = 0.4 if "markerfacecolor" in style else 0.0
            sizes = {} if style is CROSS else {"markersize": size, "markeredgewidth": edge}
            axes.plot(x[which], y[which], label=words, **style | sizes)


def _map(axes: Any, data: xr.Dataset, values: xr.DataArray, keys: list[str]) -> Any:
    """Colours over two keys: each place has that of the nearest point, and the points are drawn.

    Places whose nearest first points are not all computed stay blank.
    """
    x, y = keys
    values, data = values.transpose(x, y), data.transpose(x, y, ...)
    marks, words = _marks(data, values), classes_in(values) if _is_words(values) else []
    drawn = _as_numbers(values, words)
    drawn = _nearest(drawn, marks.computed & np.isfinite(drawn), data, keys)
    (px, log_x, _), (py, log_y, _) = _places(data, x), _places(data, y)
    axes.set_xscale("log" if log_x else "linear")
    axes.set_yscale("log" if log_y else "linear")
    colours: dict[str, Any] = {}
    if words:
        from matplotlib.colors import ListedColormap

        colours = {"cmap": ListedColormap([colour_of(word, words) for word in words]), "vmin": -0.5}
        colours |= {"vmax": len(words) - 0.5, "alpha": 0.75}
    mesh = axes.pcolormesh(_edges(px, log_x), _edges(py, log_y), drawn.T, rasterized=True, **colours)
    grid = np.meshgrid(px, py, indexing="ij")
    _points(axes, marks, grid[0], grid[1], size=min(2.5, 60.0 / max(marks.computed.sum(), 1) ** 0.5))
    for word in words:
        axes.plot([], [], "s", color=colour_of(word, words), alpha=0.75, label=word)
    _set_axis(axes.xaxis, data, x)
    _set_axis(axes.yaxis, data, y)
    return None if _is_words(values) else mesh


def _as_numbers(values: xr.DataArray, words: list[str]) -> np.ndarray:
    if not words:
        return values.to_numpy().astype(float) if not _is_words(values) else np.full(values.shape, np.nan)
    given = values.to_numpy().astype(str)
    return np.select([given == word for word in words], [float(k) for k in range(len(words))], np.nan)


def _nearest(values: np.ndarray, known: np.ndarray, data: xr.Dataset, keys: list[str]) -> np.ndarray:
    """The value of the nearest known point, in steps of the first points; NaN where a nearest first point has none.

    What is not computed yet is not taken from afar: a place has the colour of its own neighbourhood, or none.
    """
    from scipy.ndimage import distance_transform_edt

    if not known.any():
        return np.full(values.shape, np.nan)
    strides = [stride_of(data[key]) for key in keys]
    where = distance_transform_edt(
        ~known, sampling=[1 / s for s in strides], return_distances=False, return_indices=True
    )
    filled = values[tuple(where)]
    surrounded = known
    for axis, stride in enumerate(strides):
        low, high = _nearest_first(values.shape[axis], stride)
        surrounded = surrounded.take(low, axis) & surrounded.take(high, axis)
    filled[~surrounded & ~known] = np.nan
    return np.asarray(filled)


def _nearest_first(count: int, stride: int) -> tuple[np.ndarray, np.ndarray]:
    """Of each of ``count`` places the first points nearest to it: two in the middle between them, else one twice."""
    at = np.arange(count)
    return (at + (stride - 1) // 2) // stride * stride, (at + stride // 2) // stride * stride


def stride_of(key: xr.DataArray) -> int:
    """Of the values of a key, every so-many-th is one of the first points, before refinement."""
    return int(str(key.attrs.get("first_points", "every 1")).split()[-1])


def _edges(places: np.ndarray, log: bool) -> np.ndarray:
    """Edges of cells about places, half-way to their neighbours."""
    at = np.log(places) if log else places
    if len(at) == 1:
        at = np.array([at[0] - 0.5, at[0] + 0.5])
    else:
        middle = (at[1:] + at[:-1]) / 2
        at = np.concatenate([[2 * at[0] - middle[0]], middle, [2 * at[-1] - middle[-1]]])
    return np.exp(at) if log else at

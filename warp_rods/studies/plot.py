"""Diagrams of a study from its store: for each measure a figure with one or several panels."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Hashable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.draw import plots
from warp_rods.draw.colours import MAPS
from warp_rods.draw.diagrams import COMPUTED, SEED, diagram, over_how_many, stride_of
from warp_rods.draw.labels import label as label_of
from warp_rods.draw.of_run import FOLDER
from warp_rods.errors import RunFolderError, SceneError
from warp_rods.studies.status import counts
from warp_rods.studies.store import OWN, STORE, Store
from warp_rods.studies.tasks import plan_of
from warp_rods.values import nearest, shortened

__all__ = ["plot_study"]

LOG = logging.getLogger("warp_rods")
WIDTH = 110.0
"""Of a figure with one panel, mm."""
MOST_PANELS = 9
"""Of a study with more than two keys, values of the others for which there is a panel."""


def plotted(
    folder: Path, names: Sequence[str], ensembles: Sequence[str] = (), out: Path | None = None, rod: int | None = None
) -> list[Path | str]:
    """``plot_study`` as ``warp-rods plot`` calls it; ensembles and rods of a study are chosen by its keys."""
    if ensembles or rod is not None:
        raise SceneError("--ensembles and --rod are for runs: a study has one number for each point")
    said: list[str] = []
    paths = plot_study(folder, [] if "all" in names else names, out, tell=said.append)
    return [*paths, *said]


def plot_study(
    folder: str | Path, measures: Sequence[str] = (), out: str | Path | None = None,
    tell: Callable[[str], None] = LOG.warning,
) -> list[Path]:  # fmt: skip
    """Draw measures of a study (default: all) into ``plots`` in its folder, or ``out``; returns the PNGs.

    Each is NAME.png and NAME.svg. ``tell`` is called with lines about what is not drawn: measures with further
    dimensions, such as ``modes``, panels beyond ``MOST_PANELS``, and points that are not computed yet. Raises
    RunFolderError where there is no study, or nothing is computed, and SceneError for a measure that it does not have,
    or that cannot be drawn.
    """
    data = opened(folder)
    further = {str(name): v.dims[data["state"].ndim :] for name, v in data.data_vars.items() if name not in OWN}
    names = [name for name, dims in further.items() if not dims]
    for name in measures:
        if further.get(name):
            raise SceneError(_not_drawn(name, further[name]))
        if name not in names:
            raise SceneError(
                f"{name}: is not drawn of this study{nearest(name, names)}; known here: {', '.join(names)}"
            )
    for name in further if not measures else ():
        if further[name]:
            tell(_not_drawn(name, further[name]))
    unfinished = _unfinished(Path(folder))
    for line in filter(None, [_left_out(data), unfinished]):
        tell(line)
    place = Path(folder) / FOLDER if out is None else Path(out)
    return [
        plots.save(figure_of(data, name, unfinished), place / name.replace(".", "-"))[0] for name in measures or names
    ]


def opened(folder: str | Path) -> xr.Dataset:
    """The results of a study in memory, with numbers of keys in ascending order; raises RunFolderError."""
    path = Path(folder) / STORE
    if not path.exists():
        raise RunFolderError(f"There is no study in {folder}: {STORE} is missing")
    try:
        data = xr.open_zarr(path, chunks=None).load()
    except ValueError as fault:  # of a checksum
        raise RunFolderError(
            f"{path} is damaged ({fault}): run the same sweep again, which computes these points anew"
        ) from None
    texts = {name: v.astype(object) for name, v in data.variables.items() if v.dtype.kind not in "fiub"}
    data = data.assign({name: v for name, v in texts.items() if name in data.data_vars}).assign_coords(
        {name: v for name, v in texts.items() if name in data.coords}
    )
    if not (data["state"] == COMPUTED).any():
        raise RunFolderError(f"{folder}: no point is computed yet, so that there is nothing to draw")
    keys = data["state"].dims
    return data.sortby([key for key in keys if key != SEED and data[key].dtype.kind in "fiu"])


def _not_drawn(name: str, dims: Sequence[Hashable]) -> str:
    what = ", ".join(map(str, dims))
    return f"{name}: is not drawn, as it has values over {what} at each point: read them from {STORE} with xarray"


def _keys(data: xr.Dataset) -> tuple[list[str], list[str]]:
    """The keys of the axes of a panel, the two with the most values, and the others, by which panels differ."""
    keys = [str(dim) for dim in data["state"].dims if dim != SEED]
    long = sorted(keys, key=lambda key: -data.sizes[key])[:2]
    shown = [key for key in keys if key in long and data.sizes[key] > 1] or keys[:1]
    return shown, [key for key in keys if key not in shown]


def _cases(data: xr.Dataset) -> list[tuple[int, ...]]:
    """The places of values of the other keys with computed points: of first points, as refined ones have few others."""
    shown, others = _keys(data)
    computed = (data["state"] == COMPUTED).any([*shown, SEED]).transpose(*others)
    cases: list[tuple[int, ...]] = [tuple(case) for case in np.argwhere(computed.to_numpy()).tolist()]
    strides = [stride_of(data[key]) for key in others]
    return [case for case in cases if not any(np.mod(case, strides))] or cases


def _drawn(cases: list[tuple[int, ...]]) -> list[tuple[int, ...]]:
    """Those of which there is a panel."""
    at = np.linspace(0, len(cases) - 1, min(len(cases), MOST_PANELS))
    return [cases[i] for i in at.astype(int)]


def _left_out(data: xr.Dataset) -> str:
    """How many panels are left out, in words; empty where none is."""
    cases, (_, others) = _cases(data), _keys(data)
    left = len(cases) - len(_drawn(cases))
    return (
        f"panels for {MOST_PANELS} of {len(cases)} values of {', '.join(others)}; {left} are left out" if left else ""
    )


def _unfinished(folder: Path) -> str:
    """How many points are computed, in words, where some are left; empty where none is."""
    with contextlib.suppress(SceneError):  # a study may have been moved away from the files of its scene
        store = Store(folder / STORE)
        points, left = counts(plan_of(store), store)
        done = points.get("computed", 0)
        others = sum(points.get(word, 0) for word in ("lost", "failed"))
        return f"{done} of {done + others + left} points computed" if left else ""
    return ""


def figure_of(data: xr.Dataset, name: str, note: str = "") -> Any:
    """The figure of one measure over the two keys with the most values; a panel for each value of the others.

    note: a line below it.
    """
    _, others = _keys(data)
    cases = _drawn(_cases(data))
    columns = min(len(cases), 3)
    rows = -(-len(cases) // columns)
    with plots.style():
        figure = plots.figure(WIDTH if columns == 1 else plots.PAGE, 80.0 * rows)
        panels = np.atleast_1d(figure.subplots(rows, columns, squeeze=False)).ravel()
        meshes = []
        for axes, case in zip(panels, cases, strict=False):
            part = data.isel(dict(zip(others, case, strict=True)))
            meshes.append(diagram(axes, part, name))
            if others:
                axes.set_title(", ".join(_title(key, part[key].item()) for key in others))
        for axes in panels[len(cases) :]:
            axes.remove()
        _legend(figure, list(panels[: len(cases)]), meshes, data, name)
        figure.supxlabel("; ".join(filter(None, [_left_out(data), note])), fontsize="x-small", color="0.4")
    return figure


def _title(key: str, value: object) -> str:
    """A value of a key of which each panel has one."""
    return f"{key.split('.')[-1]} = {f'{value:.4g}' if isinstance(value, float) else shortened(str(value))}"


def _legend(figure: Any, panels: list[Any], meshes: list[Any], data: xr.Dataset, name: str) -> None:
    """One legend for all panels, or the colour bar."""
    drawn = [mesh for mesh in meshes if mesh is not None]
    seeds = over_how_many(data, name)
    found = [axes.get_legend_handles_labels() for axes in panels]
    entries = {label: handle for handles, labels in found for handle, label in zip(handles, labels, strict=True)}
    if entries:
        on_a_map = len(_keys(data)[0]) == 2 and data[name].dtype.kind in "UO"  # others say it on an axis
        title = seeds if on_a_map and seeds else None
        figure.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=4, title=title)
    if drawn and _scale(drawn):
        figure.colorbar(drawn[0], ax=panels, label=", ".join(filter(None, [label_of(data[name]), seeds])))


def _scale(meshes: list[Any]) -> bool:
    """Give all panels the same colours, centred on zero where values have both signs; False where there are none."""
    values = np.concatenate([np.ma.masked_invalid(mesh.get_array()).compressed() for mesh in meshes])
    if not len(values):
        return False
    low, high = float(values.min()), float(values.max())
    signed = low < 0 < high
    for mesh in meshes:
        if signed:
            mesh.set_cmap(MAPS["signed"])
        mesh.set_clim(*((-max(-low, high), max(-low, high)) if signed else (low, high)))
    return True

"""Diagrams of a study from its store: for each measure a figure with one or several panels."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from warp_rods.draw import plots
from warp_rods.draw.diagrams import SEED, diagram
from warp_rods.draw.labels import label as label_of
from warp_rods.draw.of_run import FOLDER
from warp_rods.errors import RunFolderError, SceneError
from warp_rods.studies.store import OWN, STORE
from warp_rods.values import nearest

__all__ = ["plot_study"]

WIDTH = 110.0
"""Of a figure with one panel, mm."""
MOST_PANELS = 9
"""Of a study with more than two keys, values of the others for which there is a panel."""


def plotted(
    folder: Path, names: Sequence[str], ensembles: Sequence[str] = (), out: Path | None = None, rod: int | None = None
) -> list[Path]:
    """``plot_study`` as ``warp-rods plot`` calls it; ensembles and rods of a study are chosen by its keys."""
    if ensembles or rod is not None:
        raise SceneError("--ensembles and --rod are for runs: a study has one number for each point")
    return plot_study(folder, [] if "all" in names else names, out)


def plot_study(folder: str | Path, measures: Sequence[str] = (), out: str | Path | None = None) -> list[Path]:
    """Draw measures of a study (default: all) into ``plots`` in its folder, or ``out``; returns the PNGs.

    Each is NAME.png and NAME.svg. Measures with further dimensions, such as ``modes``, are not drawn. Raises
    RunFolderError where there is no study, or nothing is computed, and SceneError for a measure that it does not have.
    """
    path = Path(folder) / STORE
    if not path.exists():
        raise RunFolderError(f"There is no study in {folder}: {STORE} is missing")
    data = xr.open_zarr(path, chunks=None).load()
    texts = {name: v.astype(object) for name, v in data.variables.items() if v.dtype.kind not in "fiub"}
    data = data.assign({name: v for name, v in texts.items() if name in data.data_vars}).assign_coords(
        {name: v for name, v in texts.items() if name in data.coords}
    )
    if not (data["state"] == 1).any():
        raise RunFolderError(f"{folder}: no point is computed yet, so that there is nothing to draw")
    names = [str(n) for n in data.data_vars if n not in OWN and data[n].dims == data["state"].dims]
    for name in measures:
        if name not in names:
            raise SceneError(
                f"{name}: is not drawn of this study{nearest(name, names)}; known here: {', '.join(names)}"
            )
    place = Path(folder) / FOLDER if out is None else Path(out)
    return [plots.save(figure_of(data, name), place / name.replace(".", "-"))[0] for name in measures or names]


def figure_of(data: xr.Dataset, name: str) -> Any:
    """The figure of one measure over the two keys with the most values; a panel for each value of the others."""
    keys = [str(dim) for dim in data["state"].dims if dim != SEED]
    long = sorted(keys, key=lambda key: -data.sizes[key])[:2]
    shown = [key for key in keys if key in long and data.sizes[key] > 1] or keys[:1]
    others = [key for key in keys if key not in shown]
    cases = list(itertools.product(*(range(data.sizes[key]) for key in others)))
    if len(cases) > MOST_PANELS:
        cases = [cases[i] for i in np.linspace(0, len(cases) - 1, MOST_PANELS).astype(int)]
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
        _legend(figure, [axes for axes, _ in zip(panels, cases, strict=False)], meshes, label_of(data[name]))
    return figure


def _title(key: str, value: object) -> str:
    """A value of a key of which each panel has one."""
    return f"{key.split('.')[-1]} = {value:.4g}" if isinstance(value, float) else f"{key.split('.')[-1]} = {value}"


def _legend(figure: Any, panels: list[Any], meshes: list[Any], words: str) -> None:
    """One legend for all panels, or the colour bar."""
    found = [axes.get_legend_handles_labels() for axes in panels]
    entries = {label: handle for handles, labels in found for handle, label in zip(handles, labels, strict=True)}
    if entries:
        figure.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=4)
    if meshes[0] is not None:
        low = min(np.nanmin(mesh.get_array()) for mesh in meshes)
        high = max(np.nanmax(mesh.get_array()) for mesh in meshes)
        for mesh in meshes:
            mesh.set_clim(low, high)
        figure.colorbar(meshes[0], ax=panels, label=words)
